#include "strak/report/curve_plot.h"

#include <fmt/format.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <limits>

#include "strak/base/error.h"
#include "strak/metrology/arc_length.h"
#include "strak/metrology/closest_point.h"
#include "strak/metrology/closest_points.h"
#include "strak/metrology/curvature_extrema.h"
#include "strak/metrology/orthotomic.h"
#include "strak/metrology/piece.h"
#include "strak/metrology/plane_of_points.h"
#include "strak/metrology/point_deviation.h"
#include "strak/report/svg.h"
#include "strak/spline/evaluate.h"

namespace strak {

namespace {

constexpr const char* kBefore = "fill=\"none\" stroke=\"#9a9a9a\" stroke-width=\"1\"";
constexpr const char* kAfter = "fill=\"none\" stroke=\"#0b5fa5\" stroke-width=\"1.6\"";
constexpr const char* kAxis = "stroke=\"#cccccc\" stroke-width=\"0.7\"";
constexpr const char* kLabel = "font-family=\"sans-serif\" font-size=\"11\" fill=\"#555555\"";
constexpr const char* kRight = "font-family=\"sans-serif\" font-size=\"11\" fill=\"#555555\" text-anchor=\"end\"";
constexpr Index kSamples = 12;  // per span

struct Profile {
  std::vector<double> length, value;
  std::vector<Eigen::Vector2d> turns;
  Index extrema = 0;
};

Profile curvatureOf(const Curve& curve) {
  Profile profile;
  std::optional<Eigen::Vector3d> normal;
  if (curve.pointDimension() == 2) {
    normal = Eigen::Vector3d::UnitZ();
  } else if (curve.pointDimension() == 3) {
    if (const auto plane = planeOfPoints(curve.euclideanNet())) normal = plane->normal();
  }
  const CurvatureProfile counted = curvatureProfile(curve);
  profile.extrema = counted.extrema();
  CurveJet jet;
  Eigen::Vector3d last = Eigen::Vector3d::Zero();
  double length = 0;
  std::size_t turn = 0;
  for (const Index span : curve.knots(0).spans()) {
    const CurvePiece piece(curve, span);
    for (Index i = 0; i <= kSamples; ++i) {
      const double u = std::lerp(piece.from(), piece.to(), static_cast<double>(i) / kSamples);
      piece.at(u, 2, jet);
      if (!profile.length.empty()) length += (jet[0] - last).norm();
      last = jet[0];
      const Eigen::Vector3d bend = jet[1].cross(jet[2]);
      const double k = (normal ? bend.dot(*normal) : bend.norm()) / std::pow(jet[1].norm(), 3);
      if (!std::isfinite(k)) continue;
      while (turn < counted.turns.size() && counted.turns[turn].parameter <= u) {
        profile.turns.emplace_back(length, counted.turns[turn++].curvature);
      }
      profile.length.push_back(length);
      profile.value.push_back(k);
    }
  }
  return profile;
}

// Values to pixels, linear or logarithmic away from zero.
struct Scale {
  double low = 0, high = 1, unit = 0;  // unit 0: linear
  double top = 0, bottom = 1;

  double bent(double v) const { return unit > 0 ? std::asinh(v / unit) : v; }
  double operator()(double v) const {
    return bottom - (bent(v) - bent(low)) / (bent(high) - bent(low)) * (bottom - top);
  }
  std::vector<double> marks() const {
    std::vector<double> list;
    if (unit > 0) {
      list.push_back(0);
      for (double m = std::pow(10, std::ceil(std::log10(unit))); m < std::max(high, -low); m *= 10) {
        list.push_back(m);
        list.push_back(-m);
      }
    } else {
      const double step = std::pow(10, std::floor(std::log10(high - low)));
      for (double i = std::ceil(low / step); i * step <= high; ++i) list.push_back(i * step);
    }
    list.erase(std::remove_if(list.begin(), list.end(), [&](double m) { return m < low || m > high; }), list.end());
    return list;
  }
};

Scale scaleOf(const std::vector<const std::vector<double>*>& lists, bool mayBend) {
  std::vector<double> all;
  Scale scale;
  scale.low = scale.high = 0;
  for (const auto* list : lists) {
    for (const double v : *list) {
      scale.low = std::min(scale.low, v);
      scale.high = std::max(scale.high, v);
      all.push_back(std::abs(v));
    }
  }
  if (all.empty() || !(scale.high > scale.low)) {
    scale.high = scale.low + 1;
    return scale;
  }
  std::nth_element(all.begin(), all.begin() + static_cast<std::ptrdiff_t>(all.size() / 2), all.end());
  const double median = all[all.size() / 2], largest = std::max(scale.high, -scale.low);
  constexpr double kPeaked = 8;
  if (mayBend && largest > kPeaked * median && median > 0) scale.unit = median;
  const double room = 0.04;
  const double from = scale.bent(scale.low), to = scale.bent(scale.high), more = room * (to - from);
  const auto back = [&](double v) { return scale.unit > 0 ? scale.unit * std::sinh(v) : v; };
  scale.low = back(from - more);
  scale.high = back(to + more);
  return scale;
}

struct Frame {
  double left = 64, right = 0, top = 28, bottom = 0, from = 0, length = 1;
  double x(double s) const { return left + (s - from) / length * (right - left); }
};

void axes(SvgWriter& svg, const Frame& frame, const Scale& scale, const char* along = "arc length") {
  for (const double mark : scale.marks()) {
    const double y = scale(mark);
    svg.line(frame.left, y, frame.right, y, kAxis);
    svg.text(frame.left - 6, y + 4, figure(mark, 3), kRight);
  }
  for (int i = 0; i <= 4; ++i) {
    const double s = frame.from + frame.length * i / 4;
    svg.line(frame.x(s), frame.top, frame.x(s), frame.bottom, kAxis);
    svg.text(frame.x(s), frame.bottom + 16, figure(s, 3), i == 4 ? kRight : kLabel);
  }
  svg.text(frame.right, frame.bottom + 32, along, kRight);
}

PicturePolyline line(const Frame& frame, const Scale& scale, const std::vector<double>& s,
                     const std::vector<double>& v) {
  PicturePolyline points;
  for (std::size_t i = 0; i < s.size(); ++i) points.emplace_back(frame.x(s[i]), scale(v[i]));
  return points;
}

// Straight pieces: a curve's curvature has kinks that must not be rounded off.
std::string pathOf(const PicturePolyline& points) {
  std::string data;
  for (const auto& p : points) data += fmt::format("{}{:.2f} {:.2f}", data.empty() ? "M" : "L", p.x(), p.y());
  return data;
}

Frame frameFor(const CurvePlotOptions& options) {
  if (options.width < 200 || options.height < 120) throw InvalidInput("a diagram needs at least 200 x 120 pixels");
  Frame frame;
  frame.right = options.width - 16;
  frame.bottom = options.height - 44;
  return frame;
}

void requireDimension(const Curve& curve) {
  if (curve.pointDimension() != 2 && curve.pointDimension() != 3) {
    throw InvalidInput("curvature is drawn of curves in the plane or in space");
  }
}

}  // namespace

std::string curvaturePlotSvg(const Curve& curve, const Curve* before, const CurvePlotOptions& options) {
  requireDimension(curve);
  Frame frame = frameFor(options);
  const Profile after = curvatureOf(curve);
  std::optional<Profile> old;
  if (before != nullptr) {
    requireDimension(*before);
    old = curvatureOf(*before);
  }
  std::vector<const std::vector<double>*> lists{&after.value};
  if (old) lists.push_back(&old->value);
  Scale scale = scaleOf(lists, true);
  scale.top = frame.top;
  scale.bottom = frame.bottom;
  const double length = after.length.empty() ? 0 : after.length.back();
  frame.length = std::max({length, old && !old->length.empty() ? old->length.back() : 0.0, 1e-300});
  SvgWriter svg(options.width, options.height, "curvature over arc length");
  axes(svg, frame, scale);
  if (old) svg.path(pathOf(line(frame, scale, old->length, old->value)), kBefore);
  svg.path(pathOf(line(frame, scale, after.length, after.value)), kAfter);
  for (const auto& turn : after.turns) {
    const double x = frame.x(turn.x()), y = scale(turn.y());
    svg.rectangle(x - 2.5, y - 2.5, 5, 5, "fill=\"#b3261e\"");
  }
  svg.text(frame.left, 16,
           old ? fmt::format("curvature: {} extrema before (grey), {} after", old->extrema, after.extrema)
               : fmt::format("curvature: {} extrema", after.extrema),
           kLabel);
  return std::move(svg).finish();
}

std::string tolerancePlotSvg(const Curve& curve, const Curve& before, const CurvePlotOptions& options) {
  requireDimension(curve);
  if (curve.pointDimension() != before.pointDimension()) {
    throw InvalidInput("the two curves must have as many coordinates");
  }
  const bool same = curve.knots(0).from() == before.knots(0).from() && curve.knots(0).to() == before.knots(0).to();
  const ClosestPointFinder<1> finder(curve);
  Frame frame = frameFor(options);
  std::vector<double> length, distance;
  Eigen::RowVectorXd last;
  double sum = 0;
  for (const Index span : before.knots(0).spans()) {
    for (Index i = 0; i <= kSamples; ++i) {
      const double u = std::lerp(before.knots(0)[span], before.knots(0)[span + 1], static_cast<double>(i) / kSamples);
      const Net d = derivatives<1>(before, {u}, 1);
      const Point place = same ? evaluate(curve, {u}) : finder.find(d.row(0)).point;
      const Point away = place - d.row(0);
      if (!length.empty()) sum += (d.row(0) - last).norm();
      last = d.row(0);
      length.push_back(sum);
      const bool plane = d.cols() == 2 && d.row(1).norm() > 0;
      distance.push_back(plane ? (away[1] * d(1, 0) - away[0] * d(1, 1)) / d.row(1).norm() : away.norm());
    }
  }
  const std::vector<double> band{-options.tolerance, options.tolerance};
  Scale scale = scaleOf({&distance, &band}, false);
  scale.top = frame.top;
  scale.bottom = frame.bottom;
  frame.length = std::max(sum, 1e-300);
  SvgWriter svg(options.width, options.height, "distance along the normal");
  if (options.tolerance > 0) {
    const double top = scale(options.tolerance);
    svg.rectangle(frame.left, top, frame.right - frame.left, scale(-options.tolerance) - top, "fill=\"#e8f1e4\"");
  }
  axes(svg, frame, scale);
  svg.path(pathOf(line(frame, scale, length, distance)), kAfter);
  svg.text(frame.left, 16,
           before.pointDimension() == 2 ? "moved along the normal, in the band of the tolerance" : "distance moved",
           kLabel);
  return std::move(svg).finish();
}

std::string deviationPlotSvg(const Curve& curve, const Eigen::Ref<const Net>& feet, const Eigen::VectorXd& deviations,
                             const CurvePlotOptions& options) {
  const bool graph = isGraph<1>(curve);
  const Eigen::VectorXd places =
      graph ? Eigen::VectorXd(feet.col(0)) : arcLengths(curve, closestPoints<1>(curve, feet).parameters.col(0));
  std::vector<double> along, values;
  for (Index r = 0; r < deviations.size(); ++r) {
    if (std::isnan(deviations[r])) continue;
    along.push_back(places[r]);
    values.push_back(deviations[r]);
  }
  if (values.empty()) throw InvalidInput("no point has a deviation that could be drawn");
  const std::vector<double> band{-options.tolerance, options.tolerance};
  Frame frame = frameFor(options);
  Scale scale = scaleOf({&values, &band}, false);
  scale.top = frame.top;
  scale.bottom = frame.bottom;
  frame.from = graph ? curve.knots(0).from() : 0;
  frame.length =
      graph ? curve.knots(0).length() : arcLengths(curve, Eigen::VectorXd::Constant(1, curve.knots(0).to()))[0];
  SvgWriter svg(options.width, options.height, "deviations of the points");
  if (options.tolerance > 0) {
    const double top = scale(options.tolerance);
    svg.rectangle(frame.left, top, frame.right - frame.left, scale(-options.tolerance) - top, "fill=\"#e8f1e4\"");
  }
  axes(svg, frame, scale, graph ? "x" : "arc length");
  Index outside = 0;
  for (std::size_t i = 0; i < values.size(); ++i) {
    const bool out = options.tolerance > 0 && std::abs(values[i]) > options.tolerance;
    outside += out ? 1 : 0;
    const double half = out ? 2 : 1;
    svg.rectangle(frame.x(along[i]) - half, scale(values[i]) - half, 2 * half, 2 * half,
                  out ? "fill=\"#b3261e\"" : "fill=\"#0b5fa5\"");
  }
  svg.text(frame.left, 16,
           options.tolerance > 0
               ? fmt::format("deviations of {} points, {} outside the tolerance", values.size(), outside)
               : fmt::format("deviations of {} points", values.size()),
           kLabel);
  return std::move(svg).finish();
}

std::string orthotomicSvg(const Curve& curve, const CurvePlotOptions& options) {
  const Orthotomic shape = orthotomic(curve, options.pole ? *options.pole : suggestedPole(curve), options.factor);
  Eigen::AlignedBox2d box;
  for (const auto& p : shape.curve) box.extend(p);
  for (const auto& p : shape.points) box.extend(p);
  box.extend(shape.pole);
  const double margin = 30;
  const double scale = std::min((options.width - 2 * margin) / std::max(box.sizes().x(), 1e-300),
                                (options.height - 2 * margin) / std::max(box.sizes().y(), 1e-300));
  const auto place = [&](const Eigen::Vector2d& p) {
    return Eigen::Vector2d(options.width / 2.0 + (p.x() - box.center().x()) * scale,
                           options.height / 2.0 - (p.y() - box.center().y()) * scale);
  };
  const auto all = [&](const std::vector<Eigen::Vector2d>& points) {
    PicturePolyline result;
    for (const auto& p : points) result.push_back(place(p));
    return result;
  };
  SvgWriter svg(options.width, options.height, "k-orthotomic");
  svg.path(pathOf(all(shape.curve)), "fill=\"none\" stroke=\"#222222\" stroke-width=\"1.6\"");
  svg.path(pathOf(all(shape.points)), kAfter);
  for (const double u : shape.cusps) {
    const auto i = static_cast<std::size_t>(std::lower_bound(shape.parameters.begin(), shape.parameters.end(), u) -
                                            shape.parameters.begin());
    for (const auto& point : {shape.points[i], shape.curve[i]}) {
      const Eigen::Vector2d p = place(point);
      svg.rectangle(p.x() - 2.5, p.y() - 2.5, 5, 5, "fill=\"#b3261e\"");
    }
  }
  const Eigen::Vector2d pole = place(shape.pole);
  svg.rectangle(pole.x() - 3, pole.y() - 3, 6, 6, "fill=\"none\" stroke=\"#222222\"");
  svg.text(margin, 18,
           fmt::format("curve (black), k-orthotomic (blue, k = {}) of the pole (box); {} inflections (red)",
                       figure(shape.factor, 3), shape.cusps.size()),
           kLabel);
  return std::move(svg).finish();
}

}  // namespace strak
