#include "strak/exchange/digitised.h"

#include <fmt/format.h>

#include <Eigen/Geometry>
#include <Eigen/SparseLU>
#include <algorithm>
#include <array>
#include <cctype>
#include <charconv>
#include <cmath>
#include <numbers>
#include <optional>

#include "strak/base/error.h"
#include "strak/spline/evaluate.h"

namespace strak {

namespace {

struct Token {
  std::size_t begin = 0, size = 0;
  double value = 0;
  bool number = false;
};

bool separates(char c) { return c == ',' || c == ';' || c == ' ' || c == '\t' || c == '\r'; }

std::vector<Token> tokens(std::string_view line) {
  std::vector<Token> result;
  for (std::size_t i = 0; i < line.size();) {
    if (separates(line[i])) {
      ++i;
      continue;
    }
    Token token{i, 0, 0, false};
    while (i < line.size() && !separates(line[i])) ++i;
    token.size = i - token.begin;
    const char* first = line.data() + token.begin;
    const char* last = first + token.size;
    if (*first == '+') ++first;
    const auto [end, error] = std::from_chars(first, last, token.value);
    token.number = error == std::errc{} && end == last && std::isfinite(token.value);
    result.push_back(token);
  }
  return result;
}

bool allNumbers(const std::vector<Token>& list) {
  return list.size() >= 2 && std::all_of(list.begin(), list.end(), [](const Token& t) { return t.number; });
}

std::vector<std::string> linesOf(std::string_view text) {
  std::vector<std::string> lines;
  while (!text.empty()) {
    const std::size_t end = std::min(text.find('\n'), text.size());
    lines.emplace_back(text.substr(0, end));
    text.remove_prefix(std::min(end + 1, text.size()));
  }
  return lines;
}

// Which columns are x, y (and z), by the names in a header line.
std::optional<std::vector<std::size_t>> namedColumns(const std::string& line) {
  std::vector<std::string> names;
  for (const Token& token : tokens(line)) {
    std::string name = line.substr(token.begin, token.size);
    std::transform(name.begin(), name.end(), name.begin(), [](unsigned char c) { return std::tolower(c); });
    name.erase(std::remove_if(name.begin(), name.end(), [](char c) { return c == '#' || c == '"'; }), name.end());
    if (!name.empty() && name != "fields") names.push_back(name);
  }
  std::vector<std::size_t> columns;
  for (const char wanted : {'x', 'y', 'z'}) {
    const auto place = std::find_if(names.begin(), names.end(), [&](const std::string& name) {
      return name[0] == wanted && (name.size() == 1 || name[1] == '_' || name[1] == '[' || name[1] == '(');
    });
    if (place != names.end()) columns.push_back(static_cast<std::size_t>(place - names.begin()));
  }
  if (columns.size() < 2) return std::nullopt;
  return columns;
}

struct Row {
  Index line = 0;
  std::vector<double> values;
};

// Lednicer's order: a line with the two numbers of points, then the upper and the lower side, each from the leading
// edge.
void toSeligOrder(std::vector<Row>& rows) {
  if (rows.size() < 6 || rows[0].values.size() != 2) return;
  const double upper = rows[0].values[0], lower = rows[0].values[1];
  const auto count = static_cast<double>(rows.size() - 1);
  if (upper < 2 || lower < 2 || upper != std::floor(upper) || lower != std::floor(lower) || upper + lower != count)
    return;
  rows.erase(rows.begin());
  std::reverse(rows.begin(), rows.begin() + static_cast<std::ptrdiff_t>(upper));
}

bool closes(const Net& points) {
  const Index n = points.rows();
  const Point gap = points.row(0) - points.row(n - 1);
  const Point in = points.row(n - 1) - points.row(n - 2), out = points.row(1) - points.row(0);
  if (gap.norm() > 1.5 * std::max(in.norm(), out.norm())) return false;
  const auto turns = [](const Point& a, const Point& b) {
    return a.dot(b) < std::cos(std::numbers::pi / 3) * a.norm() * b.norm();
  };
  if (gap.norm() == 0) return !turns(in, out);
  return !turns(in, gap) && !turns(gap, out) && !turns(in, out);
}

// f(a, b, c), the blossom of the cubic with Bezier points b on [from, to].
Point blossom(const Net& bezier, double from, double to, const std::array<double, 3>& arguments) {
  Net points = bezier;
  for (int r = 0; r < 3; ++r) {
    const double t = (arguments[static_cast<std::size_t>(r)] - from) / (to - from);
    for (Index i = 0; i + r + 1 < points.rows(); ++i) points.row(i) = (1 - t) * points.row(i) + t * points.row(i + 1);
  }
  return points.row(0);
}

int decimalsOf(std::string_view token) {
  const std::size_t point = token.find('.');
  if (point == token.npos) return 0;
  std::size_t end = point + 1;
  while (end < token.size() && std::isdigit(static_cast<unsigned char>(token[end]))) ++end;
  return static_cast<int>(end - point - 1);
}

}  // namespace

Curve interpolatingCurve(const Net& points, bool closed, std::vector<double>* parameters) {
  const Index n = points.rows();
  if (n < 4) throw InvalidInput("a curve through points needs at least 4 of them");
  std::vector<double> t{0};
  for (Index i = 1; i < n + (closed ? 1 : 0); ++i) {
    const double chord = (points.row(i % n) - points.row(i - 1)).norm();
    if (!(chord > 0)) throw InvalidInput(fmt::format("points {} and {} of a curve are the same", i, i % n + 1));
    t.push_back(t.back() + chord);
  }
  const auto spans = static_cast<Index>(t.size()) - 1;
  const auto h = [&](Index i) { return t[static_cast<std::size_t>(i) + 1] - t[static_cast<std::size_t>(i)]; };
  const auto slope = [&](Index i) { return Point((points.row((i + 1) % n) - points.row(i)) / h(i)); };

  // The tangents of the C2 cubic: h_i m_(i-1) + 2 (h_(i-1) + h_i) m_i + h_(i-1) m_(i+1) = 3 (h_i s_(i-1) + h_(i-1)
  // s_i).
  std::vector<Eigen::Triplet<double>> entries;
  Eigen::MatrixXd right(n, points.cols());
  for (Index i = 0; i < n; ++i) {
    const bool inner = closed || (i > 0 && i < n - 1);
    if (inner) {
      const Index before = (i + spans - 1) % spans;
      entries.emplace_back(i, (i + n - 1) % n, h(i));
      entries.emplace_back(i, i, 2 * (h(before) + h(i)));
      entries.emplace_back(i, (i + 1) % n, h(before));
      right.row(i) = 3 * (h(i) * slope(before) + h(before) * slope(i));
      continue;
    }
    // Not-a-knot: the first two (last two) pieces are one cubic.
    const Index a = i == 0 ? 0 : n - 2, b = i == 0 ? 1 : n - 3;
    const double both = h(a) + h(b);
    entries.emplace_back(i, i, h(b));
    entries.emplace_back(i, i == 0 ? 1 : n - 2, both);
    right.row(i) = ((h(a) + 2 * both) * h(b) * slope(a) + h(a) * h(a) * slope(b)) / both;
  }
  Eigen::SparseMatrix<double> matrix(n, n);
  matrix.setFromTriplets(entries.begin(), entries.end());
  const Eigen::SparseLU<Eigen::SparseMatrix<double>> solver(matrix);
  const Eigen::MatrixXd tangents = solver.solve(right);

  std::vector<double> knots(3, t.front());
  knots.insert(knots.end(), t.begin(), t.end());
  knots.insert(knots.end(), 3, t.back());
  Net net(spans + 3, points.cols());
  for (Index j = 0; j < spans + 3; ++j) {
    const auto k = static_cast<std::size_t>(j);
    // Any piece inside the function's support gives the same blossom; the middle one does it best.
    const Index piece = std::clamp<Index>(j - 1, 0, spans - 1);
    const auto from = static_cast<std::size_t>(piece);
    const Index next = (piece + 1) % n;
    Net bezier(4, points.cols());
    bezier.row(0) = points.row(piece);
    bezier.row(1) = points.row(piece) + h(piece) / 3 * tangents.row(piece);
    bezier.row(2) = points.row(next) - h(piece) / 3 * tangents.row(next);
    bezier.row(3) = points.row(next);
    net.row(j) = blossom(bezier, t[from], t[from + 1], {knots[k + 1], knots[k + 2], knots[k + 3]});
  }
  net.row(0) = points.row(0);
  net.row(spans + 2) = points.row(spans % n);
  if (parameters != nullptr) parameters->assign(t.begin(), t.begin() + n);
  return {{KnotVector(3, std::move(knots))}, std::move(net)};
}

DigitisedCurve parseDigitised(std::string_view text, const std::string& fileName) {
  DigitisedCurve result;
  result.lines = linesOf(text);
  std::optional<std::vector<std::size_t>> columns;
  std::vector<Row> rows;
  for (std::size_t i = 0; i < result.lines.size(); ++i) {
    const std::string& line = result.lines[i];
    const auto list = tokens(line);
    if (list.empty()) continue;
    if (allNumbers(list)) {
      Row row{static_cast<Index>(i), {}};
      std::transform(list.begin(), list.end(), std::back_inserter(row.values), [](const Token& t) { return t.value; });
      rows.push_back(std::move(row));
      continue;
    }
    if (line.starts_with("DATA") && line.find("ascii") == line.npos) {
      throw InvalidInput(fmt::format("line {}: a point cloud that is not in text form: convert it to ASCII", i + 1));
    }
    if (!rows.empty() && line.find_first_not_of(" \t\r") != line.npos && line[line.find_first_not_of(" \t")] != '#') {
      throw InvalidInput(fmt::format("line {}: '{}' is not a row of numbers", i + 1, line.substr(0, 60)));
    }
    const bool headerOfCloud = line.starts_with("VERSION") || line.starts_with("SIZE") || line.starts_with("COUNT");
    if (const auto named = namedColumns(line)) columns = named;
    if (result.name.empty() && rows.empty() && line[0] != '#' && !headerOfCloud) result.name = line;
  }
  toSeligOrder(rows);
  if (!columns) columns = std::vector<std::size_t>{0, 1};
  for (const Row& row : rows) {
    for (const std::size_t c : *columns) {
      if (c >= row.values.size()) {
        throw InvalidInput(fmt::format("line {}: {} numbers, but a coordinate is expected in column {}", row.line + 1,
                                       row.values.size(), c + 1));
      }
    }
  }
  while (!result.name.empty() && std::isspace(static_cast<unsigned char>(result.name.back()))) result.name.pop_back();
  result.name.erase(0, std::min(result.name.find_first_not_of(" \t"), result.name.size()));
  if (result.name.empty() || result.name.starts_with("FIELDS")) result.name = fileName;
  const bool flat = columns->size() == 3 && std::all_of(rows.begin(), rows.end(),
                                                        [&](const Row& row) { return row.values[(*columns)[2]] == 0; });
  if (flat) columns->pop_back();
  result.columns = *columns;

  const auto dimension = static_cast<Index>(columns->size());
  Net points(static_cast<Index>(rows.size()), dimension);
  Index count = 0;
  std::vector<Index> number;  // of each row's point
  for (const Row& row : rows) {
    Point point(dimension);
    for (Index c = 0; c < dimension; ++c) point[c] = row.values[(*columns)[static_cast<std::size_t>(c)]];
    if (count == 0 || point != points.row(count - 1)) points.row(count++) = point;
    number.push_back(count - 1);
  }
  points.conservativeResize(count, Eigen::NoChange);
  if (count < 4) {
    throw InvalidInput(fmt::format("{} different points in rows of numbers: a curve needs at least 4", count));
  }
  result.closed = closes(points);
  const bool repeats = points.row(0) == points.row(count - 1);
  if (result.closed && repeats) points.conservativeResize(count - 1, Eigen::NoChange);
  if (points.rows() < 4) throw InvalidInput("3 different points: a curve needs at least 4");
  std::vector<double> parameters;
  result.curve = interpolatingCurve(points, result.closed, &parameters);
  if (result.closed && repeats) parameters.push_back(result.curve.knots(0).to());
  for (std::size_t i = 0; i < rows.size(); ++i) {
    result.places.push_back({rows[i].line, parameters[static_cast<std::size_t>(number[i])]});
  }
  return result;
}

std::string formatDigitised(const DigitisedCurve& original, const Curve& curve) {
  const KnotVector &before = original.curve.knots(0), &after = curve.knots(0);
  if (curve.pointDimension() != static_cast<Index>(original.columns.size()) || before.from() != after.from() ||
      before.to() != after.to()) {
    throw InvalidInput("a digitised curve can only be written back on its own parameters");
  }
  constexpr int kLeastDecimals = 8, kMoreDecimals = 4;
  std::vector<std::string> lines = original.lines;
  for (const DigitisedPoint& place : original.places) {
    std::string& line = lines[static_cast<std::size_t>(place.line)];
    const Point point = evaluate(curve, {place.parameter});
    if ((point - evaluate(original.curve, {place.parameter})).isZero(0)) continue;
    const auto list = tokens(line);
    std::vector<std::size_t> order(original.columns.size());
    for (std::size_t c = 0; c < order.size(); ++c) order[c] = c;
    // From the right, so that the places of the others stay.
    std::sort(order.begin(), order.end(),
              [&](std::size_t a, std::size_t b) { return original.columns[a] > original.columns[b]; });
    for (const std::size_t c : order) {
      const Token& token = list[original.columns[c]];
      const int decimals =
          std::max(kLeastDecimals, decimalsOf(std::string_view(line).substr(token.begin, token.size)) + kMoreDecimals);
      line.replace(token.begin, token.size, fmt::format("{:.{}f}", point[static_cast<Index>(c)], decimals));
    }
  }
  std::string text;
  for (const std::string& line : lines) text += line + "\n";
  return text;
}

}  // namespace strak
