#include "strak/exchange/g2.h"

#include <fmt/format.h>

#include <algorithm>
#include <charconv>
#include <cmath>
#include <iterator>

#include "strak/base/error.h"

namespace strak {
namespace {

constexpr int kCurveClass = 100;
constexpr int kSurfaceClass = 200;
constexpr int kVolumeClass = 700;
constexpr int kCloudClass = 400;

bool isSpace(char c) { return c == ' ' || c == '\t' || c == '\n' || c == '\r' || c == '\f' || c == '\v'; }

// Reads numbers one by one and knows the line it stands in.
class Scanner {
 public:
  explicit Scanner(std::string_view text) : text_(text) {}

  bool atEnd() {
    skipSpace();
    return at_ == text_.size();
  }
  std::size_t position() const { return at_; }
  std::size_t line() const { return line_; }
  std::string_view text() const { return text_; }

  // How many more numbers there can be at the very most.
  Index room() const { return static_cast<Index>((text_.size() - at_ + 1) / 2); }

  [[noreturn]] void fail(const std::string& what) const { throw InvalidInput(fmt::format("line {}: {}", line_, what)); }

  Index integer(const char* what) {
    const std::string_view word = next(what);
    Index value = 0;
    const auto [end, error] = std::from_chars(word.data(), word.data() + word.size(), value);
    if (error != std::errc() || end != word.data() + word.size()) {
      fail(fmt::format("'{}' is not {}, a whole number was expected", shown(word), what));
    }
    return value;
  }

  double number(const char* what) {
    std::string_view word = next(what);
    if (word.size() > 1 && word[0] == '+' && word[1] != '-') word.remove_prefix(1);
    double value = 0;
    const auto [end, error] = std::from_chars(word.data(), word.data() + word.size(), value);
    const bool underflow = error == std::errc::result_out_of_range && end == word.data() + word.size() && tiny(word);
    if (!underflow && (error != std::errc() || end != word.data() + word.size() || !std::isfinite(value))) {
      fail(fmt::format("'{}' is not {}, a finite number was expected", shown(word), what));
    }
    return underflow ? 0.0 : value;
  }

  // Goes on to `position`, which lies ahead.
  void moveTo(std::size_t position) {
    line_ += static_cast<std::size_t>(std::count(text_.begin() + static_cast<std::ptrdiff_t>(at_),
                                                 text_.begin() + static_cast<std::ptrdiff_t>(position), '\n'));
    at_ = position;
  }

 private:
  void skipSpace() {
    while (at_ < text_.size() && isSpace(text_[at_])) {
      if (text_[at_] == '\n') ++line_;
      ++at_;
    }
  }

  std::string_view next(const char* what) {
    skipSpace();
    if (at_ == text_.size()) fail(fmt::format("the file ends where {} should be: it is cut off", what));
    const std::size_t begin = at_;
    while (at_ < text_.size() && !isSpace(text_[at_])) ++at_;
    return text_.substr(begin, at_ - begin);
  }

  static bool tiny(std::string_view word) { return word.find("e-") != word.npos || word.find("E-") != word.npos; }

  // A word fit for a message: short, without control characters.
  static std::string shown(std::string_view word) {
    std::string text(word.substr(0, 24));
    std::replace_if(
        text.begin(), text.end(), [](unsigned char c) { return c < 32 || c > 126; }, '?');
    return text;
  }

  std::string_view text_;
  std::size_t at_ = 0;
  std::size_t line_ = 1;
};

template <int D>
Spline<D> parseSpline(Scanner& scan) {
  const std::size_t firstLine = scan.line();
  const Index dimension = scan.integer("the dimension");
  if (dimension < 1 || dimension > scan.room()) {
    scan.fail(fmt::format("the dimension {} cannot be: 1, 2 or 3 is usual", dimension));
  }
  const Index rational = scan.integer("the rational flag");
  if (rational != 0 && rational != 1) scan.fail(fmt::format("the rational flag is {}, it must be 0 or 1", rational));
  const Index columns = dimension + rational;

  std::array<KnotVector, D> knots;
  std::array<Index, D> sizes{};
  Index points = 1;
  for (int k = 0; k < D; ++k) {
    const auto direction = static_cast<std::size_t>(k);
    const Index size = scan.integer("the number of control points");
    const Index order = scan.integer("the order");
    if (order < 1 || size < order) {
      scan.fail(
          fmt::format("direction {} has {} control points and order {}: the order must be at least 1 and at "
                      "most the number of points",
                      directionName(k), size, order));
    }
    // Sizes are believed only as far as the rest of the file can fill them.
    if (size > scan.room() / columns / points || size + order > scan.room()) {
      scan.fail(fmt::format("direction {} is said to have {} control points, more than the rest of the file can hold",
                            directionName(k), size));
    }
    points *= size;
    std::vector<double> values(static_cast<std::size_t>(size + order));
    for (double& value : values) value = scan.number("a knot");
    try {
      knots[direction] = KnotVector(static_cast<int>(order - 1), std::move(values), directionName(k));
    } catch (const InvalidInput& error) {
      scan.fail(error.what());
    }
    sizes[direction] = size;
  }

  // The file runs through direction 1 first, a net through its last direction.
  Net net(points, columns);
  std::array<Index, D> stride{};
  stride[D - 1] = 1;
  for (int k = D - 1; k > 0; --k) {
    stride[static_cast<std::size_t>(k - 1)] = stride[static_cast<std::size_t>(k)] * sizes[static_cast<std::size_t>(k)];
  }
  for (Index r = 0; r < points; ++r) {
    Index rest = r;
    Index row = 0;
    for (std::size_t k = 0; k < D; ++k) {
      row += (rest % sizes[k]) * stride[k];
      rest /= sizes[k];
    }
    for (Index c = 0; c < columns; ++c) net(row, c) = scan.number("a coordinate");
  }
  try {
    return Spline<D>(std::move(knots), std::move(net), rational == 1);
  } catch (const InvalidInput& error) {
    throw InvalidInput(fmt::format("line {}: {}", firstLine, error.what()));
  }
}

// Whether `line` is the head of an object: a class, version 1 0, the number of auxiliary integers and those.
bool isHead(std::string_view line) {
  std::vector<long> numbers;
  const char* at = line.data();
  const char* const end = at + line.size();
  while (at != end) {
    if (isSpace(*at)) {
      ++at;
      continue;
    }
    long value = 0;
    const auto [next, error] = std::from_chars(at, end, value);
    if (error != std::errc() || (next != end && !isSpace(*next))) return false;
    numbers.push_back(value);
    at = next;
  }
  return numbers.size() >= 4 && numbers[0] >= 100 && numbers[0] < 1000 && numbers[1] == 1 && numbers[2] == 0 &&
         numbers[3] == static_cast<long>(numbers.size()) - 4;
}

// Reads the head of an object: its class.
Index parseHead(Scanner& scan) {
  const Index number = scan.integer("the class of an object (100, 200, 700, ...)");
  if (number < 100 || number > 999) {
    scan.fail(fmt::format("{} is no class of an object: curves have 100, surfaces 200, volumes 700", number));
  }
  scan.integer("the major version");
  scan.integer("the minor version");
  const Index auxiliary = scan.integer("the number of auxiliary integers");
  if (auxiliary < 0 || auxiliary > scan.room()) scan.fail(fmt::format("{} auxiliary integers cannot be", auxiliary));
  for (Index i = 0; i < auxiliary; ++i) scan.integer("an auxiliary integer");
  return number;
}

// Where the next object begins after `from`, at the head of a line; the end of the text if there is none.
std::size_t nextHead(std::string_view text, std::size_t from) {
  while (true) {
    const std::size_t end = text.find('\n', from);
    if (end == text.npos) return text.size();
    const std::size_t next = text.find('\n', end + 1);
    if (isHead(text.substr(end + 1, next == text.npos ? text.npos : next - end - 1))) return end + 1;
    from = end + 1;
  }
}

std::string kindOfClass(Index number) {
  switch (number) {
    case 210:
      return "trimmed surface";
    case kCloudClass:
      return "point cloud";
    case 410:
      return "line cloud";
    default:
      return fmt::format("object of class {}", number);
  }
}

template <int D>
void append(std::string& text, const Spline<D>& spline) {
  auto out = std::back_inserter(text);
  fmt::format_to(out, "{} 1 0 0\n{} {}\n",
                 D == 1   ? kCurveClass
                 : D == 2 ? kSurfaceClass
                          : kVolumeClass,
                 spline.pointDimension(), spline.isRational() ? 1 : 0);
  Index stride[D];
  stride[D - 1] = 1;
  for (int k = D - 1; k > 0; --k) stride[k - 1] = stride[k] * spline.size(k);
  for (int k = 0; k < D; ++k) {
    fmt::format_to(out, "{} {}\n", spline.size(k), spline.degree(k) + 1);
    for (double knot : spline.knots(k).knots()) fmt::format_to(out, "{:.17g} ", knot);
    text.back() = '\n';
  }
  for (Index r = 0; r < spline.net().rows(); ++r) {
    Index rest = r;
    Index row = 0;
    for (int k = 0; k < D; ++k) {
      row += (rest % spline.size(k)) * stride[k];
      rest /= spline.size(k);
    }
    for (Index c = 0; c < spline.net().cols(); ++c) fmt::format_to(out, "{:.17g} ", spline.net()(row, c));
    text.back() = '\n';
  }
  text += '\n';
}

}  // namespace

std::vector<PlainObject> parseG2(std::string_view text) {
  Scanner scan(text);
  std::vector<PlainObject> objects;
  while (!scan.atEnd()) {
    const std::size_t begin = scan.position();
    const Index number = parseHead(scan);
    PlainObject object;
    if (number == kCurveClass) {
      object.spline = parseSpline<1>(scan);
    } else if (number == kSurfaceClass) {
      object.spline = parseSpline<2>(scan);
    } else if (number == kVolumeClass) {
      object.spline = parseSpline<3>(scan);
    } else {
      const std::size_t end = nextHead(text, scan.position());
      object.kind = kindOfClass(number);
      object.text = text.substr(begin, end - begin);
      scan.moveTo(end);
    }
    objects.push_back(std::move(object));
  }
  if (objects.empty()) throw InvalidInput("line 1: the file is empty, an object was expected");
  return objects;
}

bool beginsWithG2Cloud(std::string_view text) {
  const std::size_t end = std::min(text.find('\n'), text.size());
  if (!text.starts_with(fmt::format("{} ", kCloudClass)) || !isHead(text.substr(0, end))) return false;
  // A row of a table would be followed by one as long; here the number of points stands alone.
  text.remove_prefix(std::min(end + 1, text.size()));
  const std::string_view line = text.substr(0, std::min(text.find_first_of("\r\n"), text.size()));
  const std::string_view word = line.substr(0, line.find_last_not_of(" \t") + 1);
  return !word.empty() && word.find_first_not_of("0123456789") == word.npos;
}

Net parseG2Clouds(std::string_view text) {
  Scanner scan(text);
  std::vector<double> numbers;
  bool found = false;
  while (!scan.atEnd()) {
    if (parseHead(scan) != kCloudClass) {
      scan.moveTo(nextHead(text, scan.position()));
      continue;
    }
    found = true;
    const Index count = scan.integer("the number of points");
    if (count < 0 || count > scan.room() / 3) {
      scan.fail(fmt::format("the file is too short for {} points: it may be damaged", count));
    }
    for (Index i = 0; i < 3 * count; ++i) numbers.push_back(scan.number("a coordinate"));
  }
  if (!found) throw InvalidInput("the .g2 file holds no point cloud (class 400): give measured points");
  return Eigen::Map<const Net>(numbers.data(), static_cast<Index>(numbers.size()) / 3, 3);
}

std::string formatG2(const std::vector<PlainObject>& objects) {
  std::string text;
  for (const PlainObject& object : objects) {
    if (object.spline) {
      std::visit([&](const auto& spline) { append(text, spline); }, *object.spline);
    } else {
      text += object.text;
      if (!text.ends_with('\n')) text += '\n';
    }
  }
  return text;
}

}  // namespace strak
