#include "strak/report/scene.h"

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>

#include "strak/spline/evaluate.h"

namespace strak {

namespace {

std::vector<double> spread(const KnotVector& knots, int count) {
  std::vector<double> out;
  for (int i = 0; i <= count; ++i) out.push_back(knots.from() + knots.length() * i / count);
  return out;
}

// Area of a coarse mesh of the whole domain.
double roughArea(const Surface& surface) {
  constexpr int kCells = 12;
  const Net p = derivativesOnGrid<2>(surface, {spread(surface.knots(0), kCells), spread(surface.knots(1), kCells)}, 0);
  double area = 0;
  for (int i = 0; i < kCells; ++i)
    for (int j = 0; j < kCells; ++j) {
      const Eigen::Vector3d a = p.row(i * (kCells + 1) + j), b = p.row((i + 1) * (kCells + 1) + j),
                            c = p.row((i + 1) * (kCells + 1) + j + 1), d = p.row(i * (kCells + 1) + j + 1);
      area += (c - a).cross(d - b).norm() / 2;
    }
  return area;
}

double spanCount(const Surface& surface) {
  return static_cast<double>(surface.knots(0).spans().size()) * static_cast<double>(surface.knots(1).spans().size());
}

SceneCurve sceneCurve(Index object, const Curve& curve) {
  SceneCurve out{object, curve, {}, {}};
  const KnotVector& knots = curve.knots(0);
  const std::vector<Index> spans = knots.spans();
  const int parts = static_cast<int>(std::clamp<std::size_t>(400 / spans.size(), 6, 200));
  for (Index span : spans)
    for (int i = 0; i < parts; ++i) out.parameters.push_back(knots[span] + (knots[span + 1] - knots[span]) * i / parts);
  out.parameters.push_back(knots.to());
  const Net points = derivativesAt(
      curve, Eigen::Map<const Net>(out.parameters.data(), static_cast<Index>(out.parameters.size()), 1), 0);
  for (Index i = 0; i < points.rows(); ++i) out.points.emplace_back(points.row(i).transpose());
  return out;
}

}  // namespace

Scene buildScene(const std::vector<Object>& objects, const SceneDetail& detail) {
  Scene scene;
  std::vector<double> areas;
  double wholeArea = 0;
  for (std::size_t i = 0; i < objects.size(); ++i) {
    if (!objects[i].spline) continue;
    const Drawable parts = drawable(*objects[i].spline);
    scene.plane = scene.plane && parts.plane;
    for (const Curve& curve : parts.curves) scene.curves.push_back(sceneCurve(static_cast<Index>(i), curve));
    for (const Surface& surface : parts.surfaces) {
      scene.surfaces.push_back({static_cast<Index>(i), surface, TrimRegion(surface, objects[i].trims), {}, {}});
      areas.push_back(roughArea(surface));
      wholeArea += areas.back();
    }
  }
  std::vector<double> wishes;
  double sum = 0;
  for (std::size_t i = 0; i < areas.size(); ++i) {
    const double share = wholeArea > 0 ? areas[i] / wholeArea * static_cast<double>(detail.shared) : 0;
    wishes.push_back(std::max({share, static_cast<double>(detail.least),
                               spanCount(scene.surfaces[i].surface) * detail.perSpan * detail.perSpan}));
    sum += wishes.back();
  }
  const double cut = std::min(1.0, static_cast<double>(detail.total) / std::max(sum, 1.0));
  for (std::size_t i = 0; i < areas.size(); ++i) {
    SceneSurface& s = scene.surfaces[i];
    s.mesh = meshDomain(s.surface, s.region, static_cast<Index>(wishes[i] * cut));
    s.samples = sampleSurface(s.surface, s.mesh.parameters);
  }
  return scene;
}

std::vector<Eigen::Vector3d> scenePoints(const Scene& scene) {
  std::vector<Eigen::Vector3d> out;
  for (const SceneSurface& s : scene.surfaces) out.insert(out.end(), s.samples.points.begin(), s.samples.points.end());
  for (const SceneCurve& c : scene.curves) out.insert(out.end(), c.points.begin(), c.points.end());
  return out;
}

Eigen::Vector3d defaultView(const Scene& scene) {
  if (scene.plane) return Eigen::Vector3d::UnitZ();
  Eigen::Vector3d corner = Eigen::Vector3d(0.55, -0.8, 0.5).normalized();
  // The second moment of the normals: faces may be orientated against each other.
  Eigen::Matrix3d moment = Eigen::Matrix3d::Zero();
  for (const SceneSurface& s : scene.surfaces)
    for (const auto& t : s.mesh.triangles) {
      const auto& p = s.samples.points;
      const Eigen::Vector3d normal = (p[t[1]] - p[t[0]]).cross(p[t[2]] - p[t[0]]);
      if (normal.norm() > 0) moment += normal * normal.transpose() / normal.norm();
    }
  const Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> axes(moment);
  if (!(axes.eigenvalues()[2] > 0.7 * moment.trace())) return corner;
  Eigen::Vector3d normal = axes.eigenvectors().col(2);
  if (normal.dot(corner) < 0) normal = -normal;
  return (normal + 0.7 * corner).normalized();
}

std::vector<Eigen::Vector3d> pointsAt(const Surface& surface, const std::vector<Eigen::Vector2d>& parameters) {
  Net uv(static_cast<Index>(parameters.size()), 2);
  for (std::size_t i = 0; i < parameters.size(); ++i) uv.row(static_cast<Index>(i)) = parameters[i].transpose();
  const Net points = derivativesAt(surface, uv, 0);
  std::vector<Eigen::Vector3d> out;
  for (Index i = 0; i < points.rows(); ++i) out.emplace_back(points.row(i).transpose());
  return out;
}

std::vector<std::vector<Eigen::Vector2d>> borderLines(const SceneSurface& scene,
                                                      const std::vector<std::vector<Eigen::Vector2d>>& trims) {
  const Surface& surface = scene.surface;
  const Eigen::AlignedBox2d& domain = scene.region.domain();
  // Whether both sides across a direction are the same line.
  std::array<bool, 2> closed{};
  for (int k = 0; k < 2; ++k) {
    std::vector<Eigen::Vector2d> low, high;
    for (double along : spread(surface.knots(1 - k), 16)) {
      Eigen::Vector2d p;
      p[1 - k] = along;
      p[k] = domain.min()[k];
      low.push_back(p);
      p[k] = domain.max()[k];
      high.push_back(p);
    }
    const auto a = pointsAt(surface, low), b = pointsAt(surface, high);
    Eigen::AlignedBox3d box;
    double apart = 0;
    for (std::size_t i = 0; i < a.size(); ++i) {
      box.extend(a[i]);
      box.extend(pointsAt(surface, {(low[i] + high[i]) / 2}).front());
      apart = std::max(apart, (a[i] - b[i]).norm());
    }
    closed[static_cast<std::size_t>(k)] = apart < 1e-4 * box.diagonal().norm();
  }
  const auto onSeam = [&](const Eigen::Vector2d& p, int k) {
    const double near = 1e-6 * domain.sizes()[k];
    return closed[static_cast<std::size_t>(k)] && (p[k] < domain.min()[k] + near || p[k] > domain.max()[k] - near);
  };
  std::vector<std::vector<Eigen::Vector2d>> lines;
  if (!scene.region.isWholeDomain()) {
    for (const auto& trim : trims) {
      bool seam = false;
      for (int k = 0; k < 2; ++k)
        seam = seam || std::all_of(trim.begin(), trim.end(), [&](const auto& p) { return onSeam(p, k); });
      if (!seam && trim.size() > 1) lines.push_back(trim);
    }
    return lines;
  }
  for (int k = 0; k < 2; ++k) {
    if (closed[static_cast<std::size_t>(k)]) continue;
    const KnotVector& along = surface.knots(1 - k);
    const std::vector<Index> spans = along.spans();
    const int parts = static_cast<int>(std::clamp<std::size_t>(240 / spans.size(), 4, 60));
    for (double side : {domain.min()[k], domain.max()[k]}) {
      std::vector<Eigen::Vector2d> line;
      const auto add = [&](double t) {
        Eigen::Vector2d p;
        p[k] = side;
        p[1 - k] = t;
        line.push_back(p);
      };
      for (Index span : spans)
        for (int i = 0; i < parts; ++i) add(along[span] + (along[span + 1] - along[span]) * i / parts);
      add(along.to());
      lines.push_back(std::move(line));
    }
  }
  return lines;
}

}  // namespace strak
