#include "strak/fitting/sheet_check.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <utility>

#include "strak/base/error.h"
#include "strak/metrology/closest_points.h"
#include "strak/spline/evaluator.h"

namespace strak {

namespace {

// Cells with fewer points, in parts of the mean of those that have some, hang over the cloud's border: their shape is
// extrapolated.
constexpr double kLeastFilling = 0.2;
constexpr double kPointsPerCell = 50;  // enough to tell two groups from one
constexpr double kLeastSine = 0.02;    // of the angle between the parameter lines
constexpr double kLeastLayers = 3e-4;  // root mean square in parts of the size: nearer layers are patterns of errors
constexpr double kNearer = 0.5;        // a place that is nearer by less may be rounding or noise
constexpr double kAway = 1;            // knot spans: what is nearer in the domain is the same part of the surface
constexpr double kLeastPart = 0.05;    // of the points: fewer are strays
constexpr double kPointsPerPartCell = 9;
constexpr Index kMostPartCells = 1000;  // a direction
constexpr double kTouching = 1e-6;      // of the surface's size: shorter distances are none

// Unit normals on a lattice; zero where the parameter lines touch.
std::vector<Eigen::Vector3d> normalsOn(const Evaluator<2>& evaluator, const Evaluator<2>::Parameters& places) {
  const Net d = evaluator.derivativesOnGrid(places, 1);
  std::vector<Eigen::Vector3d> normals(static_cast<std::size_t>(d.rows()));
  for (Index r = 0; r < d.rows(); ++r) {
    const Eigen::Vector3d u = d.row(r).segment<3>(3), v = d.row(r).segment<3>(6);
    const Eigen::Vector3d n = u.cross(v);
    const double length = n.norm();
    normals[static_cast<std::size_t>(r)] =
        length > kLeastSine * u.norm() * v.norm() ? Eigen::Vector3d(n / length) : Eigen::Vector3d::Zero();
  }
  return normals;
}

void findFolds(const Evaluator<2>& evaluator, const std::vector<FitErrors<2>::Cell>& cells, SheetCheck& check) {
  std::array<std::vector<double>, 2> places;  // the knots and the middles between them
  for (std::size_t k = 0; k < 2; ++k) {
    const KnotVector& knots = evaluator.knots(static_cast<int>(k));
    for (const Index s : knots.spans()) {
      places[k].push_back(knots[s]);
      places[k].push_back((knots[s] + knots[s + 1]) / 2);
    }
    places[k].push_back(knots.to());
  }
  const auto normals = normalsOn(evaluator, places);
  const std::size_t line = places[1].size(), columns = (line - 1) / 2;
  double points = 0, filled = 0;
  for (const auto& cell : cells) {
    points += static_cast<double>(cell.count);
    filled += cell.count > 0 ? 1 : 0;
  }
  const double least = std::max(1.0, kLeastFilling * points / std::max(filled, 1.0));
  for (std::size_t c = 0; c < cells.size(); ++c) {
    if (static_cast<double>(cells[c].count) < least) continue;
    ++check.cells;
    const std::size_t i = 2 * (c / columns), j = 2 * (c % columns);
    const auto normal = [&](std::size_t a, std::size_t b) -> const Eigen::Vector3d& {
      return normals[(i + a) * line + j + b];
    };
    bool folds = false;
    for (std::size_t a = 0; a < 3; ++a) {
      for (std::size_t b = 0; b < 2; ++b) {
        folds = folds || !(normal(a, b).dot(normal(a, b + 1)) > 0) || !(normal(b, a).dot(normal(b + 1, a)) > 0);
      }
    }
    if (!folds) continue;
    if (check.folded == 0) check.foldedAt = {places[0][i + 1], places[1][j + 1]};
    ++check.folded;
    check.foldedCells.push_back({static_cast<Index>(c / columns), static_cast<Index>(c % columns)});
  }
}

// Filled cells of an even grid over the domain that touch are one part.
void findParts(const Surface& surface, const Net& parameters, SheetCheck& check) {
  std::array<Index, 2> cells{};
  const double area = surface.knots(0).length() * surface.knots(1).length();
  const double side = std::sqrt(area * kPointsPerPartCell / static_cast<double>(std::max<Index>(parameters.rows(), 1)));
  for (std::size_t k = 0; k < 2; ++k) {
    cells[k] = std::clamp<Index>(static_cast<Index>(surface.knots()[k].length() / side), 1, kMostPartCells);
  }
  std::vector<Index> count(static_cast<std::size_t>(cells[0] * cells[1]), 0);
  for (Index r = 0; r < parameters.rows(); ++r) {
    std::array<Index, 2> cell{};
    for (std::size_t k = 0; k < 2; ++k) {
      const KnotVector& knots = surface.knots()[k];
      const double at = (parameters(r, static_cast<Index>(k)) - knots.from()) / knots.length();
      cell[k] = std::clamp<Index>(static_cast<Index>(at * static_cast<double>(cells[k])), 0, cells[k] - 1);
    }
    ++count[static_cast<std::size_t>(cell[0] * cells[1] + cell[1])];
  }
  struct Part {
    Index points = 0, cells = 0;
    std::array<double, 2> sum{};
  };
  std::vector<Part> parts;
  for (Index first = 0; first < cells[0] * cells[1]; ++first) {
    if (count[static_cast<std::size_t>(first)] == 0) continue;
    Part part;
    std::vector<Index> open{first};
    while (!open.empty()) {
      const Index c = open.back();
      open.pop_back();
      Index& here = count[static_cast<std::size_t>(c)];
      if (here == 0) continue;
      part.points += std::exchange(here, 0);
      ++part.cells;
      const Index i = c / cells[1], j = c % cells[1];
      part.sum[0] += static_cast<double>(i) + 0.5;
      part.sum[1] += static_cast<double>(j) + 0.5;
      for (Index a = std::max<Index>(i - 1, 0); a <= std::min(i + 1, cells[0] - 1); ++a) {
        for (Index b = std::max<Index>(j - 1, 0); b <= std::min(j + 1, cells[1] - 1); ++b)
          open.push_back(a * cells[1] + b);
      }
    }
    if (static_cast<double>(part.points) >= kLeastPart * static_cast<double>(parameters.rows())) parts.push_back(part);
  }
  if (parts.size() < 2) return;
  std::sort(parts.begin(), parts.end(), [](const Part& a, const Part& b) { return a.points > b.points; });
  check.parts = static_cast<Index>(parts.size());
  for (std::size_t k = 0; k < 2; ++k) {
    const double middle = parts[1].sum[k] / static_cast<double>(parts[1].cells * cells[k]);
    check.partAt[k] = surface.knots()[k].from() + middle * surface.knots()[k].length();
  }
}

// The errors sorted into cells: those of the function zero.
Fit<2> errorsOnCells(const std::array<KnotVector, 2>& knots, const FitPoints<2>& errors) {
  Fit<2> result;
  result.spline = Surface(knots, Net::Zero(knots[0].size() * knots[1].size(), 1));
  FitErrors<2> sums(result.spline, 0);
  sums.add(errors);
  result.cells = sums.cells();
  return result;
}

}  // namespace

SheetCheck checkSheet(const Surface& surface, const FitPoints<2>& points, Index mostLooked) {
  if (surface.pointDimension() != 3 || points.values.cols() != 3 || points.parameters.rows() != points.values.rows()) {
    throw InvalidInput("a sheet is a surface in space, and its points need three coordinates and two parameters each");
  }
  SheetCheck check;
  const Evaluator<2> evaluator(surface);
  const Net d = evaluator.derivativesAt(points.parameters, 1);
  Net distances(points.count(), 1);  // with sign, along the normal
  for (Index r = 0; r < points.count(); ++r) {
    const Eigen::Vector3d error = (points.values.row(r) - d.row(r).head<3>()).transpose();
    const Eigen::Vector3d u = d.row(r).segment<3>(3), v = d.row(r).segment<3>(6);
    distances(r, 0) = error.norm() * (error.dot(u.cross(v)) < 0 ? -1 : 1);
  }
  const FitPoints<2> signedErrors{points.parameters, distances, points.weights};
  findFolds(evaluator, errorsOnCells(surface.knots(), signedErrors).cells, check);
  std::array<KnotVector, 2> coarse;
  const auto cells = static_cast<Index>(std::sqrt(static_cast<double>(points.count()) / kPointsPerCell));
  for (std::size_t k = 0; k < 2; ++k) {
    const KnotVector& knots = surface.knots()[k];
    const Index spans = std::clamp<Index>(cells, 1, static_cast<Index>(knots.spans().size()));
    coarse[k] = KnotVector::uniformClamped(1, spans, knots.from(), knots.to());
  }
  if (mostLooked > 0) findParts(surface, points.parameters, check);
  const auto groups = twoGroups<2>(errorsOnCells(coarse, signedErrors));
  const double size = (surface.net().colwise().maxCoeff() - surface.net().colwise().minCoeff()).norm();
  if (points.count() > 0 && size > 0) {
    std::vector<double> sorted(distances.data(), distances.data() + distances.size());
    for (double& one : sorted) one = std::abs(one);
    const auto middle = sorted.begin() + static_cast<std::ptrdiff_t>(sorted.size() / 2);
    std::nth_element(sorted.begin(), middle, sorted.end());
    check.thickness = *middle / size;
  }
  if (distances.norm() > kLeastLayers * size * std::sqrt(static_cast<double>(points.count()))) {
    check.layered = groups.share;
    check.layeredAt = groups.place;
  }

  if (mostLooked < 1 || points.count() == 0) return check;
  const Index step = (points.count() + mostLooked - 1) / mostLooked;
  check.looked = (points.count() + step - 1) / step;
  const double far = kTouching * size;
  std::vector<Index> rows;
  for (Index r = 0; r < points.count(); r += step) {
    if (std::abs(distances(r, 0)) > far) rows.push_back(r);
  }
  if (rows.empty()) return check;
  Net looked(static_cast<Index>(rows.size()), 3);
  for (std::size_t i = 0; i < rows.size(); ++i) looked.row(static_cast<Index>(i)) = points.values.row(rows[i]);
  const auto nearest = closestPoints<2>(surface, looked);
  double worst = 0;
  for (std::size_t i = 0; i < rows.size(); ++i) {
    const double own = std::abs(distances(rows[i], 0)), least = nearest.distances[static_cast<Index>(i)];
    bool away = false;
    for (Index k = 0; k < 2; ++k) {
      const KnotVector& knots = surface.knots()[static_cast<std::size_t>(k)];
      const double span = knots.length() / static_cast<double>(knots.spans().size());
      const double way = nearest.parameters(static_cast<Index>(i), k) - points.parameters(rows[i], k);
      away = away || std::abs(way) > kAway * span;
    }
    if (!away || least > kNearer * own) continue;
    ++check.astray;
    if (own - least > worst) {
      worst = own - least;
      check.astrayPoint = points.values.row(rows[i]);
    }
  }
  return check;
}

}  // namespace strak
