#pragma once
//
// Shapes for the tests of pictures, and a small check of XML.

#include <cmath>
#include <map>
#include <string>
#include <vector>

#include "strak/exchange/model.h"
#include "strak/report/drawing.h"

namespace strak::test {

// The whole unit sphere as a rational biquadratic surface: 9 x 5 control points, u around z, v from the south pole up.
inline Surface sphere(const Eigen::Vector3d& centre = Eigen::Vector3d::Zero()) {
  const double s = std::sqrt(0.5);
  const double around[9][3] = {{1, 0, 1},   {1, 1, s},  {0, 1, 1},  {-1, 1, s}, {-1, 0, 1},
                               {-1, -1, s}, {0, -1, 1}, {1, -1, s}, {1, 0, 1}};
  const double profile[5][3] = {{0, -1, 1}, {1, -1, s}, {1, 0, 1}, {1, 1, s}, {0, 1, 1}};
  Net net(45, 4);
  for (Index i = 0; i < 9; ++i)
    for (Index j = 0; j < 5; ++j) {
      const double w = around[i][2] * profile[j][2];
      net.row(i * 5 + j) << w * (profile[j][0] * around[i][0] + centre.x()),
          w * (profile[j][0] * around[i][1] + centre.y()), w * (profile[j][1] + centre.z()), w;
    }
  return Surface({KnotVector(2, {0, 0, 0, 1, 1, 2, 2, 3, 3, 4, 4, 4}), KnotVector(2, {0, 0, 0, 1, 1, 2, 2, 2})}, net,
                 true);
}

// A bicubic sheet over [0, 1]^2 with control points at height f(x, y).
template <class Height>
Surface sheet(Height f, Index spans = 6) {
  const KnotVector knots = KnotVector::uniformClamped(3, spans);
  const std::vector<double> places = knots.greville();
  Net net(knots.size() * knots.size(), 3);
  for (Index i = 0; i < knots.size(); ++i)
    for (Index j = 0; j < knots.size(); ++j) {
      const double x = places[static_cast<std::size_t>(i)], y = places[static_cast<std::size_t>(j)];
      net.row(i * knots.size() + j) << x, y, f(x, y);
    }
  return Surface({knots, knots}, net);
}

inline Surface wavySheet(double height = 0.05) {
  return sheet([=](double x, double y) { return height * std::sin(9 * x) * std::cos(7 * y) + 0.3 * x * x; });
}

inline Curve planeCurve() {
  const KnotVector knots = KnotVector::uniformClamped(3, 5);
  Net net(knots.size(), 2);
  for (Index i = 0; i < knots.size(); ++i) net.row(i) << static_cast<double>(i), std::sin(0.9 * static_cast<double>(i));
  return Curve({knots}, net);
}

inline Volume block() {
  const KnotVector line = KnotVector::uniformClamped(1, 1), bend = KnotVector::uniformClamped(2, 2);
  Net net(2 * 4 * 2, 3);
  for (Index i = 0; i < 2; ++i)
    for (Index j = 0; j < 4; ++j)
      for (Index k = 0; k < 2; ++k)
        net.row((i * 4 + j) * 2 + k) << static_cast<double>(i), static_cast<double>(j),
            static_cast<double>(k) + 0.2 * static_cast<double>(j * j);
  return Volume({line, bend, line}, net);
}

inline Object object(AnySpline spline, std::string name = "thing") {
  Object out;
  out.name = std::move(name);
  out.kind = "B-spline";
  out.spline = std::move(spline);
  return out;
}

// A polygon around the middle of the unit square, closed.
inline std::vector<Eigen::Vector2d> circle(double radius, int corners, Eigen::Vector2d middle = {0.5, 0.5}) {
  std::vector<Eigen::Vector2d> out;
  for (int i = 0; i < corners; ++i) {
    const double angle = 2 * M_PI * i / corners;
    out.emplace_back(middle + radius * Eigen::Vector2d(std::cos(angle), std::sin(angle)));
  }
  out.push_back(out.front());
  return out;
}

// The first fault of an XML text, or nothing: tags that nest, quoted attributes, no stray < or &.
inline std::string xmlFault(const std::string& text) {
  std::vector<std::string> open;
  bool hadRoot = false;
  for (std::size_t i = 0; i < text.size();) {
    if (text[i] == '&') {
      const std::size_t end = text.find(';', i);
      if (end == std::string::npos || end > i + 8) return "stray & at " + std::to_string(i);
      i = end + 1;
      continue;
    }
    if (text[i] != '<') {
      if (open.empty() && !std::isspace(static_cast<unsigned char>(text[i]))) return "text outside the root";
      ++i;
      continue;
    }
    std::size_t p = i + 1;
    const bool closing = text[p] == '/';
    if (closing) ++p;
    const std::size_t nameEnd = text.find_first_of(" />\n", p);
    if (nameEnd == std::string::npos || nameEnd == p) return "no name at " + std::to_string(i);
    const std::string name = text.substr(p, nameEnd - p);
    std::map<std::string, int> attributes;
    p = nameEnd;
    while (p < text.size() && text[p] != '>' && text[p] != '/') {
      if (std::isspace(static_cast<unsigned char>(text[p]))) {
        ++p;
        continue;
      }
      const std::size_t equals = text.find('=', p);
      if (equals == std::string::npos || text[equals + 1] != '"') return "attribute without quotes in " + name;
      if (attributes[text.substr(p, equals - p)]++) return "attribute twice in " + name;
      const std::size_t quote = text.find('"', equals + 2);
      if (quote == std::string::npos || text.substr(equals + 2, quote - equals - 2).find('<') != std::string::npos)
        return "bad attribute value in " + name;
      p = quote + 1;
    }
    const bool empty = text[p] == '/';
    if (empty) ++p;
    if (p >= text.size() || text[p] != '>') return "unfinished tag " + name;
    if (closing) {
      if (open.empty() || open.back() != name) return "wrong end of " + name;
      open.pop_back();
    } else {
      if (open.empty() && hadRoot) return "second root " + name;
      hadRoot = true;
      if (!empty) open.push_back(name);
    }
    i = p + 1;
  }
  return open.empty() && hadRoot ? "" : "not closed";
}

// The length and the number of pieces of the path of a class in a drawing.
struct PathSize {
  double length = 0;
  int pieces = 0;
};
inline PathSize pathSize(const std::string& svg, const std::string& cssClass) {
  PathSize size;
  const std::size_t at = svg.find("class=\"" + cssClass + "\"");
  if (at == std::string::npos) return size;
  const std::size_t start = svg.find(" d=\"", at) + 4, end = svg.find('"', start);
  Eigen::Vector2d last(0, 0), p;
  std::vector<double> numbers;
  char command = 'M';
  const auto flush = [&] {
    for (std::size_t i = 0; i + 1 < numbers.size(); i += 2) {
      p = {numbers[i], numbers[i + 1]};
      if (command == 'C') {
        if (i % 6 != 4) continue;
        const Eigen::Vector2d b(numbers[i - 4], numbers[i - 3]), c(numbers[i - 2], numbers[i - 1]), a = last;
        for (int k = 1; k <= 16; ++k) {
          const double t = k / 16.0, r = 1 - t;
          const Eigen::Vector2d x = a * (r * r * r) + b * (3 * r * r * t) + c * (3 * r * t * t) + p * (t * t * t);
          size.length += (x - last).norm();
          last = x;
        }
        continue;
      }
      if (command == 'M' && i == 0)
        ++size.pieces;
      else
        size.length += (p - last).norm();
      last = p;
    }
    numbers.clear();
  };
  for (std::size_t i = start; i < end;) {
    if (std::isalpha(static_cast<unsigned char>(svg[i]))) {
      flush();
      command = svg[i++];
    } else if (svg[i] == ' ') {
      ++i;
    } else {
      std::size_t used = 0;
      numbers.push_back(std::stod(svg.substr(i, 24), &used));
      i += used;
    }
  }
  flush();
  return size;
}

}  // namespace strak::test
