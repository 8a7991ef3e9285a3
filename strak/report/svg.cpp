#include "strak/report/svg.h"

#include <fmt/format.h>

#include <Eigen/LU>

#include <algorithm>
#include <cmath>

namespace strak {

namespace {

using Vector = Eigen::Vector2d;

void append(std::string& out, const Vector& p, int decimals = 2) {
  out += shortNumber(p.x(), decimals);
  out += ' ';
  out += shortNumber(p.y(), decimals);
}

// The direction at q of the parabola through p, q and r.
Vector tangent(const Vector& p, const Vector& q, const Vector& r) {
  const double a = (q - p).norm(), b = (r - q).norm();
  return ((q - p) * (b / a) + (r - q) * (a / b)).normalized();
}

// The direction at its start.
Vector startTangent(const Vector& p, const Vector& q, const Vector& r) {
  const double a = (q - p).norm(), b = (r - q).norm();
  return ((q - p) * ((2 * a + b) / (a * (a + b))) - (r - q) * (a / (b * (a + b)))).normalized();
}

// Fits cubic Bezier curves to points[first..last] with the given directions at the ends, splitting where one is not
// enough.
class CurveFitter {
 public:
  explicit CurveFitter(const PicturePolyline& points) : points_(points) {}

  void fit(std::size_t first, std::size_t last, const Vector& startDirection, const Vector& endDirection) {
    const Vector &from = points_[first], &to = points_[last];
    const double length = (to - from).norm();
    if (last - first == 1) {
      const bool straight = (startDirection + endDirection).norm() < 1e-6;
      straight ? lineTo(to) : curveTo(from + startDirection * (length / 3), to + endDirection * (length / 3), to);
      return;
    }
    std::vector<double> t{0};
    for (std::size_t i = first + 1; i <= last; ++i) t.push_back(t.back() + (points_[i] - points_[i - 1]).norm());
    for (double& value : t) value /= t.back();
    Vector p1, p2;
    double worst = 0;
    // The parameters of the points are known only roughly at first: fit, find the feet of the perpendiculars, fit
    // again.
    for (int round = 0; round < 6; ++round) {
      const auto [a, b] = handles(first, last, t, startDirection, endDirection, length);
      p1 = from + startDirection * a;
      p2 = to + endDirection * b;
      worst = 0;
      for (std::size_t i = first + 1; i < last; ++i)
        worst = std::max(worst, improve(t[i - first], points_[i], from, p1, p2, to));
      if (worst <= kTolerance || worst > 6 * kTolerance) break;
    }
    // Legs that pass each other make loops and cusps between the points.
    if (worst <= kTolerance && (p2 - p1).dot(to - from) > 0) {
      curveTo(p1, p2, to);
      return;
    }
    const std::size_t split = (first + last) / 2;
    const Vector direction = tangent(points_[split - 1], points_[split], points_[split + 1]);
    fit(first, split, startDirection, -direction);
    fit(split, last, direction, endDirection);
  }

  std::string out;

 private:
  static constexpr double kTolerance = 0.05;

  void lineTo(const Vector& p) {
    out += 'L';
    append(out, p);
  }
  void curveTo(const Vector& p1, const Vector& p2, const Vector& p3) {
    out += 'C';
    append(out, p1);
    out += ' ';
    append(out, p2);
    out += ' ';
    append(out, p3);
  }

  // The lengths of the two inner legs, by least squares.
  std::pair<double, double> handles(std::size_t first, std::size_t last, const std::vector<double>& t, const Vector& d1,
                                    const Vector& d2, double length) const {
    Eigen::Matrix2d normal = Eigen::Matrix2d::Zero();
    Vector rhs = Vector::Zero();
    for (std::size_t i = first + 1; i < last; ++i) {
      const double s = t[i - first], r = 1 - s, b1 = 3 * s * r * r, b2 = 3 * s * s * r;
      const Vector rest = points_[i] - points_[first] * (r * r * r + b1) - points_[last] * (s * s * s + b2),
                   a1 = d1 * b1, a2 = d2 * b2;
      normal(0, 0) += a1.dot(a1);
      normal(0, 1) += a1.dot(a2);
      normal(1, 1) += a2.dot(a2);
      rhs += Vector(rest.dot(a1), rest.dot(a2));
    }
    normal(1, 0) = normal(0, 1);
    const double determinant = normal.determinant();
    const Vector solution = determinant > 1e-12 * normal(0, 0) * normal(1, 1) ? Vector(normal.inverse() * rhs)
                                                                              : Vector(Vector::Constant(length / 3));
    const bool usable = solution.minCoeff() > 1e-3 * length && solution.maxCoeff() < 10 * length;
    return usable ? std::pair{solution.x(), solution.y()} : std::pair{length / 3, length / 3};
  }

  // The distance of a point from the curve near t; moves t by one step of Newton's method to where it is least.
  static double improve(double& t, const Vector& point, const Vector& p0, const Vector& p1, const Vector& p2,
                        const Vector& p3) {
    const auto offset = [&] {
      const double r = 1 - t;
      return Vector(p0 * (r * r * r) + p1 * (3 * r * r * t) + p2 * (3 * r * t * t) + p3 * (t * t * t) - point);
    };
    const double r = 1 - t;
    const Vector d = (p1 - p0) * (3 * r * r) + (p2 - p1) * (6 * r * t) + (p3 - p2) * (3 * t * t);
    if (d.squaredNorm() > 0) t = std::clamp(t - offset().dot(d) / d.squaredNorm(), 0.0, 1.0);
    return offset().norm();
  }

  const PicturePolyline& points_;
};

// Points closer than a hundredth of a pixel to the one before say nothing.
PicturePolyline withoutRepeats(const PicturePolyline& line) {
  PicturePolyline out;
  for (const Vector& p : line)
    if (out.empty() || (out.back() - p).norm() > 0.01) out.push_back(p);
  return out;
}

}  // namespace

std::string escaped(std::string_view text) {
  constexpr std::string_view unknown = "\xEF\xBF\xBD";
  std::string out;
  for (std::size_t i = 0; i < text.size();) {
    const auto c = static_cast<unsigned char>(text[i]);
    const std::size_t length = c < 0x80                ? 1
                               : c >= 0xC2 && c < 0xE0 ? 2
                               : c >= 0xE0 && c < 0xF0 ? 3
                               : c >= 0xF0 && c < 0xF5 ? 4
                                                       : 0;
    bool valid = length > 0 && i + length <= text.size() && (c >= 0x20 || c == '\n' || c == '\t') && c != 0x7F;
    for (std::size_t k = 1; valid && k < length; ++k) valid = (static_cast<unsigned char>(text[i + k]) & 0xC0) == 0x80;
    if (!valid) {
      out += unknown;
      ++i;
      continue;
    }
    switch (text[i]) {
      case '&':
        out += "&amp;";
        break;
      case '<':
        out += "&lt;";
        break;
      case '>':
        out += "&gt;";
        break;
      case '"':
        out += "&quot;";
        break;
      case '\'':
        out += "&#39;";
        break;
      default:
        out += text.substr(i, length);
    }
    i += length;
  }
  return out;
}

std::string smoothPath(const PicturePolyline& line) {
  const PicturePolyline points = withoutRepeats(line);
  if (points.size() < 2) return {};
  CurveFitter fitter(points);
  fitter.out = "M";
  append(fitter.out, points.front());
  const auto direction = [&](std::size_t from, std::size_t to) {
    return Vector((points[to] - points[from]).normalized());
  };
  std::size_t start = 0;
  for (std::size_t i = 1; i < points.size(); ++i) {
    const bool last = i + 1 == points.size();
    const bool corner = !last && direction(i - 1, i).dot(direction(i, i + 1)) < std::cos(0.52);
    if (!last && !corner) continue;
    if (i - start > 1) {
      fitter.fit(start, i, startTangent(points[start], points[start + 1], points[start + 2]),
                 startTangent(points[i], points[i - 1], points[i - 2]));
    } else {
      fitter.fit(start, i, direction(start, i), direction(i, start));
    }
    start = i;
  }
  return std::move(fitter.out);
}

std::string polygonPath(const PicturePolyline& polygon) {
  PicturePolyline kept;
  for (std::size_t i = 0; i < polygon.size(); ++i) {
    const Vector& p = polygon[i];
    if (!kept.empty()) {
      const Vector& next = polygon[(i + 1) % polygon.size()];
      const Vector chord = next - kept.back(), d = p - kept.back();
      const double length = chord.norm(), along = length > 0 ? chord.dot(d) / length : -1;
      const double off = length > 0 ? std::abs(chord.x() * d.y() - chord.y() * d.x()) / length : d.norm();
      // Only short chords: errors of points left out before must not add up.
      if (off < 0.05 && along > 0 && along < length && length < 12) continue;
    }
    kept.push_back(p);
  }
  if (kept.size() < 3) return {};
  std::string out;
  for (const Vector& p : kept) {
    out += out.empty() ? 'M' : ' ';
    append(out, p, 1);
  }
  out += 'Z';
  return out;
}

SvgWriter::SvgWriter(int width, int height, std::string_view title) {
  out_ = fmt::format(
      "<svg xmlns=\"http://www.w3.org/2000/svg\" viewBox=\"0 0 {0} {1}\" width=\"{0}\" height=\"{1}\" role=\"img\" "
      "font-family=\"system-ui, 'Segoe UI', 'Helvetica Neue', Arial, sans-serif\">\n<title>{2}</title>\n",
      width, height, escaped(title));
}

void SvgWriter::path(std::string_view data, std::string_view attributes) {
  if (!data.empty()) out_ += fmt::format("<path {} d=\"{}\"/>\n", attributes, data);
}

void SvgWriter::text(double x, double y, std::string_view text, std::string_view attributes) {
  out_ +=
      fmt::format("<text x=\"{}\" y=\"{}\" {}>{}</text>\n", shortNumber(x), shortNumber(y), attributes, escaped(text));
}

void SvgWriter::rectangle(double x, double y, double width, double height, std::string_view attributes) {
  out_ += fmt::format("<rect x=\"{}\" y=\"{}\" width=\"{}\" height=\"{}\" {}/>\n", shortNumber(x), shortNumber(y),
                      shortNumber(width), shortNumber(height), attributes);
}

void SvgWriter::line(double x1, double y1, double x2, double y2, std::string_view attributes) {
  out_ += fmt::format("<line x1=\"{}\" y1=\"{}\" x2=\"{}\" y2=\"{}\" {}/>\n", shortNumber(x1), shortNumber(y1),
                      shortNumber(x2), shortNumber(y2), attributes);
}

void SvgWriter::open(std::string_view attributes) { out_ += fmt::format("<g {}>\n", attributes); }
void SvgWriter::close() { out_ += "</g>\n"; }

std::string SvgWriter::finish() && {
  out_ += "</svg>\n";
  return std::move(out_);
}

std::string shortNumber(double value, int decimals) {
  std::string text = fmt::format("{:.{}f}", value, decimals);
  if (text.find('.') != std::string::npos) {
    text.erase(text.find_last_not_of('0') + 1);
    if (text.back() == '.') text.pop_back();
  }
  return text == "-0" ? "0" : text;
}

std::string figure(double value, int digits) {
  if (std::isnan(value)) return "\xE2\x80\x93";
  if (std::isinf(value)) return value > 0 ? "\xE2\x88\x9E" : "\xE2\x88\x92\xE2\x88\x9E";
  std::string text = fmt::format("{:.{}g}", value, digits);
  const std::size_t exponent = text.find('e');
  if (exponent == std::string::npos) return text[0] == '-' ? "\xE2\x88\x92" + text.substr(1) : text;
  // 1.2e-07 as 1.2 x 10 to the -7, with a real minus and superscripts.
  std::string out = text.substr(0, exponent) +
                    "\xC2\xB7"
                    "10";
  static const char* const kSuperscripts[] = {"\xE2\x81\xB0", "\xC2\xB9",     "\xC2\xB2",     "\xC2\xB3",
                                              "\xE2\x81\xB4", "\xE2\x81\xB5", "\xE2\x81\xB6", "\xE2\x81\xB7",
                                              "\xE2\x81\xB8", "\xE2\x81\xB9"};
  const int power = std::stoi(text.substr(exponent + 1));
  if (power < 0) out += "\xE2\x81\xBB";
  for (char digit : std::to_string(std::abs(power))) out += kSuperscripts[digit - '0'];
  return out[0] == '-' ? "\xE2\x88\x92" + out.substr(1) : out;
}

}  // namespace strak
