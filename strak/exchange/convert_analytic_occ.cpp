#include "strak/exchange/convert_analytic_occ.h"

#include <BRepTools.hxx>
#include <BRep_Tool.hxx>
#include <Geom_BSplineCurve.hxx>
#include <Geom_Circle.hxx>
#include <Geom_ConicalSurface.hxx>
#include <Geom_CylindricalSurface.hxx>
#include <Geom_Ellipse.hxx>
#include <Geom_Line.hxx>
#include <Geom_Plane.hxx>
#include <Geom_SphericalSurface.hxx>
#include <Geom_SurfaceOfLinearExtrusion.hxx>
#include <Geom_SurfaceOfRevolution.hxx>
#include <Geom_ToroidalSurface.hxx>
#include <Precision.hxx>
#include <Standard_Failure.hxx>

#include <fmt/format.h>
#include <Eigen/Geometry>

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>

#include "strak/base/error.h"
#include "strak/exchange/audit_occ.h"
#include "strak/exchange/cad_geometry_occ.h"
#include "strak/exchange/shared_geometry_occ.h"
#include "strak/spline/basis.h"
#include "strak/spline/degree_elevation.h"
#include "strak/spline/periodic.h"

namespace strak::cad {
namespace {

constexpr double kTurn = 2 * std::numbers::pi;
constexpr double kWhole = 1e-6;  // this near to a whole turn is one
constexpr int kArcDegree = 7;
constexpr double kArcSpan = 0.15;  // the error is about (span / pi)^8 of the radius
constexpr int kLineDegree = 3;

using Vector = Eigen::Vector3d;

Vector vector(const gp_XYZ& v) { return {v.X(), v.Y(), v.Z()}; }

// (cos t, sin t) over [from, to] in equal spans. On such knots control points on a circle give a curve that meets a
// smaller one at all knots; its radius is known.
Curve unitArc(double from, double to) {
  const int p = kArcDegree;
  const bool whole = std::abs(to - from - kTurn) < kWhole;
  const auto spans = static_cast<Index>(std::max(whole ? 2.0 * p : 1.0, std::ceil((to - from) / kArcSpan)));
  const double step = (to - from) / static_cast<double>(spans);
  std::vector<double> knots;
  for (Index i = -p; i <= spans + p; ++i) {
    knots.push_back(i == 0 ? from : i == spans ? to : from + step * static_cast<double>(i));
  }
  const KnotVector uniform(p, std::move(knots));
  Net values = basisDerivatives(uniform, p, from, 0);
  double radius = 0;
  for (Index j = 0; j <= p; ++j) {
    radius += values(0, j) * std::cos(step * static_cast<double>(j - p + (p + 1) / 2));
  }
  Net net(uniform.size(), 2);
  for (Index j = 0; j < net.rows(); ++j) {
    // Points that come again after a whole turn are the same to the bit.
    const double angle = from + step * static_cast<double>((whole ? j % spans : j) - p + (p + 1) / 2);
    net.row(j) << std::cos(angle) / radius, std::sin(angle) / radius;
  }
  return toClamped(Curve({uniform}, std::move(net)), 0);
}

// start + t direction over [from, to].
Curve line(const Vector& start, const Vector& direction, double from, double to) {
  Net net(2, 3);
  net.row(0) = start + from * direction;
  net.row(1) = start + to * direction;
  return elevateDegree(Curve({KnotVector(1, {from, from, to, to})}, std::move(net)), 0, kLineDegree - 1);
}

// centre + x cos t + y sin t.
Curve ellipse(const Vector& centre, const Vector& x, const Vector& y, double from, double to) {
  const Curve arc = unitArc(from, to);
  Net net = arc.net() * (Eigen::Matrix<double, 2, 3>() << x.transpose(), y.transpose()).finished();
  net.rowwise() += centre.transpose();
  return Curve(arc.knots(), std::move(net));
}

// The curve with its own parameters; nothing for the kinds that are no splines.
std::optional<Curve> profile(const Handle(Geom_Curve) & trimmed, double from, double to) {
  const Handle(Geom_Curve) curve = untrimmed(trimmed);
  if (const auto* straight = dynamic_cast<const Geom_Line*>(curve.get())) {
    const gp_Ax1& axis = straight->Position();
    return line(vector(axis.Location().XYZ()), vector(axis.Direction().XYZ()), from, to);
  }
  if (const auto* conic = dynamic_cast<const Geom_Conic*>(curve.get())) {
    double a = 0, b = 0;
    if (const auto* circle = dynamic_cast<const Geom_Circle*>(conic)) {
      a = b = circle->Radius();
    } else if (const auto* oval = dynamic_cast<const Geom_Ellipse*>(conic)) {
      a = oval->MajorRadius();
      b = oval->MinorRadius();
    } else {
      return std::nullopt;
    }
    const gp_Ax2& frame = conic->Position();
    return ellipse(vector(frame.Location().XYZ()), a * vector(frame.XDirection().XYZ()),
                   b * vector(frame.YDirection().XYZ()), from, to);
  }
  const Handle(Geom_BSplineCurve) spline = copyAsSpline(curve);
  if (spline.IsNull()) return std::nullopt;
  if (from < spline->FirstParameter() - Precision::PConfusion() ||
      to > spline->LastParameter() + Precision::PConfusion()) {
    return std::nullopt;
  }
  return toClamped(toSpline(*spline, 1), 0);
}

// The meridian turned by u around the axis through `origin` along z (against it if handed is -1).
Surface revolved(const Curve& meridian, const Vector& origin, const Vector& z, double handed, double from, double to) {
  const Curve arc = unitArc(from, to);
  const Index rows = arc.size(0), columns = meridian.size(0);
  Net net(rows * columns, meridian.net().cols());
  for (Index j = 0; j < columns; ++j) {
    const double w = meridian.isRational() ? meridian.net()(j, 3) : 1.0;
    const Vector from0 = meridian.net().row(j).head(3).transpose() - w * origin;
    const Vector along = from0.dot(z) * z;
    const Vector across = from0 - along;
    const Vector side = handed * z.cross(across);
    for (Index i = 0; i < rows; ++i) {
      auto row = net.row(i * columns + j);
      row.head(3) = (w * origin + along + arc.net()(i, 0) * across + arc.net()(i, 1) * side).transpose();
      if (meridian.isRational()) row(3) = w;
    }
  }
  return Surface({arc.knots(0), meridian.knots(0)}, std::move(net), meridian.isRational());
}

Surface extruded(const Curve& curve, const Vector& direction, double from, double to) {
  const Curve rail = line(Vector::Zero(), direction, from, to);
  const Index columns = rail.size(0);
  Net net(curve.size(0) * columns, curve.net().cols());
  for (Index i = 0; i < curve.size(0); ++i) {
    const double w = curve.isRational() ? curve.net()(i, 3) : 1.0;
    for (Index j = 0; j < columns; ++j) {
      net.row(i * columns + j) = curve.net().row(i);
      net.row(i * columns + j).head(3) += w * rail.net().row(j);
    }
  }
  return Surface({curve.knots(0), rail.knots(0)}, std::move(net), curve.isRational());
}

// The frame of a plane or of a surface around an axis.
struct Frame {
  Vector origin, x, y, z;
  double handed;  // 1 if y = z x x, else -1

  explicit Frame(const gp_Ax3& axes)
      : origin(vector(axes.Location().XYZ())),
        x(vector(axes.XDirection().XYZ())),
        y(vector(axes.YDirection().XYZ())),
        z(vector(axes.Direction().XYZ())),
        handed(axes.Direct() ? 1 : -1) {}
};

AnalyticSpline fromElementary(const Geom_ElementarySurface& surface, const ParameterBox& box) {
  const Frame f(surface.Position());
  const auto [u0, v0] = box.from;
  const auto [u1, v1] = box.to;
  const auto around = [&](const Curve& meridian) -> AnalyticSpline {
    return {revolved(meridian, f.origin, f.z, f.handed, u0, u1), ""};
  };
  if (dynamic_cast<const Geom_Plane*>(&surface) != nullptr) {
    return {extruded(line(f.origin, f.x, u0, u1), f.y, v0, v1), ""};
  }
  if (const auto* cylinder = dynamic_cast<const Geom_CylindricalSurface*>(&surface)) {
    return around(line(f.origin + cylinder->Radius() * f.x, f.z, v0, v1));
  }
  if (const auto* cone = dynamic_cast<const Geom_ConicalSurface*>(&surface)) {
    const double angle = cone->SemiAngle();
    return around(line(f.origin + cone->RefRadius() * f.x, std::sin(angle) * f.x + std::cos(angle) * f.z, v0, v1));
  }
  if (const auto* sphere = dynamic_cast<const Geom_SphericalSurface*>(&surface)) {
    return around(ellipse(f.origin, sphere->Radius() * f.x, sphere->Radius() * f.z, v0, v1));
  }
  if (const auto* torus = dynamic_cast<const Geom_ToroidalSurface*>(&surface)) {
    return around(
        ellipse(f.origin + torus->MajorRadius() * f.x, torus->MinorRadius() * f.x, torus->MinorRadius() * f.z, v0, v1));
  }
  return {std::nullopt, "its kind is not known"};
}

}  // namespace

std::optional<ParameterBox> boxOf(const std::vector<TopoDS_Face>& faces, const Geom_Surface& surface) {
  constexpr double kInfinity = std::numeric_limits<double>::infinity();
  ParameterBox box{{kInfinity, kInfinity}, {-kInfinity, -kInfinity}};
  for (const TopoDS_Face& located : faces) {
    TopoDS_Face face = located;
    face.Location(TopLoc_Location());
    std::array<double, 2> from{}, to{};
    BRepTools::UVBounds(face, from[0], to[0], from[1], to[1]);
    for (std::size_t k = 0; k < 2; ++k) {
      if (!std::isfinite(from[k]) || !std::isfinite(to[k]) || !(from[k] <= to[k])) return std::nullopt;
      box.from[k] = std::min(box.from[k], from[k]);
      box.to[k] = std::max(box.to[k], to[k]);
    }
  }
  std::array<double, 2> least{}, most{};
  surface.Bounds(least[0], most[0], least[1], most[1]);
  for (std::size_t k = 0; k < 2; ++k) {
    const bool periodic = k == 0 ? surface.IsUPeriodic() : surface.IsVPeriodic();
    if (periodic) {
      const double period = k == 0 ? surface.UPeriod() : surface.VPeriod();
      if (std::abs(box.to[k] - box.from[k] - period) < kWhole) {
        const double start = least[k] + period * std::round((box.from[k] - least[k]) / period);
        if (std::abs(box.from[k] - start) < kWhole) box.from[k] = start;
        box.to[k] = box.from[k] + period;
      }
    } else {
      box.from[k] = std::max(box.from[k], least[k]);
      box.to[k] = std::min(box.to[k], most[k]);
    }
    if (!(box.from[k] < box.to[k]) || Precision::IsInfinite(box.from[k]) || Precision::IsInfinite(box.to[k])) {
      return std::nullopt;
    }
  }
  return box;
}

AnalyticSpline analyticSpline(const Handle(Geom_Surface) & surface, const ParameterBox& box) {
  for (std::size_t k = 0; k < 2; ++k) {
    const bool periodic = k == 0 ? surface->IsUPeriodic() : surface->IsVPeriodic();
    const double period = !periodic ? 0 : k == 0 ? surface->UPeriod() : surface->VPeriod();
    if (periodic && box.to[k] - box.from[k] > period * (1 + 1e-12)) {
      return {std::nullopt, "its edges run beyond one turn"};
    }
  }
  if (const auto* elementary = dynamic_cast<const Geom_ElementarySurface*>(surface.get())) {
    return fromElementary(*elementary, box);
  }
  const char* const noProfile = "its profile is not a line, a circle, an ellipse or a spline";
  if (const auto* turned = dynamic_cast<const Geom_SurfaceOfRevolution*>(surface.get())) {
    const auto meridian = profile(turned->BasisCurve(), box.from[1], box.to[1]);
    if (!meridian) return {std::nullopt, noProfile};
    const gp_Ax1 axis = turned->Axis();
    return {
        revolved(*meridian, vector(axis.Location().XYZ()), vector(axis.Direction().XYZ()), 1, box.from[0], box.to[0]),
        ""};
  }
  if (const auto* drawn = dynamic_cast<const Geom_SurfaceOfLinearExtrusion*>(surface.get())) {
    const auto curve = profile(drawn->BasisCurve(), box.from[0], box.to[0]);
    if (!curve) return {std::nullopt, noProfile};
    return {extruded(*curve, vector(drawn->Direction().XYZ()), box.from[1], box.to[1]), ""};
  }
  return {std::nullopt, fmt::format("a {} has no exact B-spline", kindOf(surface))};
}

namespace {

// Whether the faces fit their edges on `next` as well as before; if not, the old surfaces are back under them.
bool layAndCheck(const std::vector<TopoDS_Face>& faces, const Handle(Geom_BSplineSurface) & next, double tolerance) {
  std::vector<Handle(Geom_Surface)> old;
  std::vector<Audit> before;
  for (const TopoDS_Face& face : faces) {
    TopLoc_Location ignored;
    old.push_back(BRep_Tool::Surface(face, ignored));
    before.push_back(auditShape(face, 1));
  }
  bool good = true;
  try {
    for (const TopoDS_Face& face : faces) layUnder(face, next);
    for (std::size_t i = 0; i < faces.size() && good; ++i) {
      const Audit after = auditShape(faces[i], 1);
      good = after.valid || !before[i].valid;
      for (std::size_t e = 0; e < after.edges.size(); ++e) {
        const EdgeFit& edge = after.edges[e];
        good = good && edge.gap <= std::max(before[i].edges[e].gap + tolerance, edge.tolerance);
      }
    }
  } catch (const Standard_Failure&) {
    good = false;
  }
  if (good) return true;
  for (std::size_t i = 0; i < faces.size(); ++i) layUnder(faces[i], old[i]);
  return false;
}

std::string tryToConvert(const std::vector<TopoDS_Face>& faces, double tolerance, Handle(Geom_BSplineSurface) & made) {
  TopLoc_Location ignored;
  const Handle(Geom_Surface) surface = untrimmed(BRep_Tool::Surface(faces.front(), ignored));
  const auto box = boxOf(faces, *surface);
  if (!box) return "it has no bounds";
  const AnalyticSpline analytic = analyticSpline(surface, *box);
  if (!analytic.spline) return analytic.refused;
  const Handle(Geom_BSplineSurface) next = fromSpline(*analytic.spline, 1);
  constexpr int kSamples = 25;
  for (int i = 0; i <= kSamples; ++i) {
    for (int j = 0; j <= kSamples; ++j) {
      const double u = std::lerp(box->from[0], box->to[0], static_cast<double>(i) / kSamples);
      const double v = std::lerp(box->from[1], box->to[1], static_cast<double>(j) / kSamples);
      if (!(surface->Value(u, v).Distance(next->Value(u, v)) <= tolerance)) return "no spline comes near enough to it";
    }
  }
  if (!layAndCheck(faces, next, tolerance)) return "its edges would fit less well";
  for (const TopoDS_Face& face : faces) BRepTools::Clean(face);
  made = next;
  return "";
}

}  // namespace

std::string convertFaces(const std::vector<TopoDS_Face>& faces, double tolerance, Handle(Geom_BSplineSurface) & made) {
  try {
    return tryToConvert(faces, tolerance, made);
  } catch (const Standard_Failure& failure) {
    return fmt::format("Open CASCADE gives up ({})", failure.GetMessageString());
  } catch (const InvalidInput& error) {
    return error.what();
  }
}

}  // namespace strak::cad
