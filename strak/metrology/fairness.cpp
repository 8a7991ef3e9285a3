#include "strak/metrology/fairness.h"

#include <tbb/blocked_range.h>
#include <tbb/parallel_for.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>

#include "strak/metrology/curvature.h"
#include "strak/metrology/piece.h"
#include "strak/spline/basis.h"

namespace strak {

namespace {

// Area, plate, curvature variation, isophote roughness of a surface; length, bending, curvature variation of a curve.
constexpr int kFigures = 4;
using Figures = Eigen::Array<double, kFigures, 1>;

// Cells are not cut more often than this below their span: what is left of an integral that does not converge (a
// singular point with unbounded curvature) is reported as its error.
constexpr int kMaxDepth = 16;

// An integral whose worst figure goes on growing by this factor from round to round, over so many of them, and with as
// large an error as that, follows a power of the distance to a singular place and has no value: the rounds to come
// would cost twice as much each and tell the same.
constexpr int kGrowingRounds = 8;
constexpr double kGrows = 1.5;
constexpr double kLargeError = 0.3;

// A trimmed surface starts with at least so many cells a direction, or small holes between the nodes would go unseen.
constexpr Index kTrimmedCells = 32;

struct RulePair {
  GaussRule coarse, fine;
  Index evaluations(int directions) const {
    const auto a = static_cast<Index>(coarse.nodes.size()), b = static_cast<Index>(fine.nodes.size());
    return directions == 1 ? a + b : a * a + b * b;
  }
};

struct Cell {
  std::array<Index, 2> spans{};
  std::array<double, 2> from{}, to{};
  int depth = 0;
  bool cut = false;  // partly outside
  Figures value = Figures::Zero(), error = Figures::Zero();
};

// What is below this is rounding, not shape: `figures` of a surface whose bending is of order one, with its size. The
// plate energy has no unit, the variations are 1 / area (1 / length^3 for curves, bending 1 / length).
Figures floors(const Figures& figures, int directions) {
  constexpr double kNoise = 1e-12;
  const double size = figures[0], bending = std::max(1.0, directions == 1 ? figures[1] * size : figures[1]);
  if (!(size > 0)) return Figures::Constant(std::numeric_limits<double>::min());
  if (directions == 1) return {0, kNoise / size, kNoise * bending / (size * size * size), 0};
  return {0, kNoise, kNoise * bending / size, kNoise * bending / size};
}

// The indices of the cells to refine: those with the largest share of the error, until what the others leave is a
// quarter of `allowed`; at most `limit`. Ties go to the first cell, so that the choice is always the same.
std::vector<std::size_t> worstCells(const std::vector<Cell>& cells, const Figures& scale, double allowed,
                                    std::size_t limit) {
  std::vector<double> share(cells.size());
  std::vector<std::size_t> order;
  for (std::size_t i = 0; i < cells.size(); ++i) {
    share[i] = (cells[i].error / scale).maxCoeff();
    if (cells[i].depth < kMaxDepth && share[i] > 0) order.push_back(i);
  }
  std::sort(order.begin(), order.end(),
            [&](std::size_t a, std::size_t b) { return share[a] > share[b] || (share[a] == share[b] && a < b); });
  double smooth = 0, cut = 0;
  while (!order.empty()) {
    const std::size_t i = order.back();
    (cells[i].cut ? cut : smooth) += cells[i].cut ? share[i] * share[i] : share[i];
    if (smooth + std::sqrt(cut) > allowed / 4) break;
    order.pop_back();
  }
  order.resize(std::min(order.size(), limit));
  return order;
}

void appendChildren(const Cell& cell, int directions, std::vector<Cell>& children) {
  for (int part = 0; part < (1 << directions); ++part) {
    Cell child = cell;
    ++child.depth;
    for (int k = 0; k < directions; ++k) {
      const auto d = static_cast<std::size_t>(k);
      const double middle = std::midpoint(cell.from[d], cell.to[d]);
      ((part >> k) & 1 ? child.from[d] : child.to[d]) = middle;
    }
    children.push_back(child);
  }
}

struct Totals {
  Figures value = Figures::Zero();
  double relativeError = 0;
};

// Adaptive integration from the cells given. `integrate` fills a cell's value, error and cut for `evaluations`
// evaluations. Sums are formed in the order of the cells, so threads do not change them.
template <class Integrate>
Totals integrateAdaptively(std::vector<Cell> fresh, int directions, Index evaluations, const FairnessOptions& options,
                           const Integrate& integrate) {
  std::vector<Cell> cells;
  Index left = options.maxEvaluations;
  Figures last = Figures::Constant(std::numeric_limits<double>::infinity());
  int growing = 0;
  while (true) {
    tbb::parallel_for(tbb::blocked_range<std::size_t>(0, fresh.size(), 4), [&](const auto& range) {
      for (std::size_t i = range.begin(); i < range.end(); ++i) integrate(fresh[i]);
    });
    left -= static_cast<Index>(fresh.size()) * evaluations;
    cells.insert(cells.end(), fresh.begin(), fresh.end());
    fresh.clear();

    Totals totals;
    Figures smoothError = Figures::Zero(), cutError = Figures::Zero();
    for (const Cell& cell : cells) {
      totals.value += cell.value;
      // A boundary that cuts a cell makes errors of random sign; others are bounds.
      if (cell.cut) {
        cutError += cell.error.square();
      } else {
        smoothError += cell.error;
      }
    }
    const Figures scale = totals.value.max(floors(totals.value, directions)).max(std::numeric_limits<double>::min());
    Index worstFigure = 0;
    totals.relativeError = ((smoothError + cutError.sqrt()) / scale).maxCoeff(&worstFigure);
    if (totals.relativeError <= options.relativeError || left <= 0) return totals;
    const bool grows = totals.relativeError > kLargeError && totals.value[worstFigure] > kGrows * last[worstFigure];
    growing = grows ? growing + 1 : 0;
    if (growing == kGrowingRounds) return totals;
    last = totals.value;

    const auto worst =
        worstCells(cells, scale, options.relativeError, static_cast<std::size_t>(left / (evaluations << directions)));
    if (worst.empty()) return totals;
    std::vector<bool> split(cells.size());
    for (const std::size_t i : worst) split[i] = true;
    std::vector<Cell> kept;
    kept.reserve(cells.size());
    for (std::size_t i = 0; i < cells.size(); ++i) {
      if (split[i]) {
        appendChildren(cells[i], directions, fresh);
      } else {
        kept.push_back(cells[i]);
      }
    }
    cells = std::move(kept);
  }
}

// The best pair of rules that allows one pass.
RulePair chooseRules(std::size_t cells, int directions, Index maxEvaluations) {
  RulePair rules;
  for (const auto& [coarse, fine] : {std::pair{4, 6}, std::pair{3, 4}, std::pair{2, 3}}) {
    rules = {gaussLegendre(coarse), gaussLegendre(fine)};
    if (static_cast<Index>(cells) * rules.evaluations(directions) <= maxEvaluations) break;
  }
  return rules;
}

std::vector<double> nodesOn(const GaussRule& rule, double from, double to) {
  std::vector<double> result = rule.nodes;
  for (double& x : result) x = (from + to) / 2 + x * (to - from) / 2;
  return result;
}

Figures surfaceDensity(const SurfaceJet& jet) {
  const Eigen::Map<const Net> d(jet[0].data(), 10, 3);
  const CurvatureRates at = curvatureRates(d);
  if (!at.regular) return Figures::Zero();
  const Eigen::Vector4d& c = at.derivative;
  const double plate = at.principal[0] * at.principal[0] + at.principal[1] * at.principal[1];
  const double own = c[0] * c[0] + c[3] * c[3];
  const double all = own + 3 * (c[1] * c[1] + c[2] * c[2]);
  const Figures density = Figures(1, plate, own, all) * at.area;
  return density.isFinite().all() ? density : Figures::Zero();
}

Figures curveDensity(const CurveJet& jet) {
  const double speed = jet[1].norm();
  if (!(speed > 0)) return Figures::Zero();
  const Eigen::Vector3d c = jet[1].cross(jet[2]), dc = jet[1].cross(jet[3]);
  const double cube = speed * speed * speed, length = c.norm();
  // The curvature is |c| / speed^3. Where c passes through zero its length has the slope |dc|.
  const double slope = length > 0 ? c.dot(dc) / length : dc.norm();
  const double k = length / cube;
  const double dk = (slope / cube - 3 * k * jet[1].dot(jet[2]) / (speed * speed)) / speed;
  const Figures density = Figures(1, k * k, dk * dk, 0) * speed;
  return density.isFinite().all() ? density : Figures::Zero();
}

}  // namespace

SurfaceFairness surfaceFairness(const Surface& surface, const FairnessOptions& options) {
  std::vector<Cell> cells;
  std::array<Index, 2> parts{1, 1};
  std::array<std::vector<Index>, 2> spans;
  for (std::size_t k = 0; k < 2; ++k) {
    spans[k] = surface.knots()[k].spans();
    const auto count = static_cast<Index>(spans[k].size());
    if (options.inside) parts[k] = (kTrimmedCells + count - 1) / count;
  }
  for (const Index u : spans[0]) {
    for (const Index v : spans[1]) {
      const SurfacePiece piece(surface, u, v);
      for (Index i = 0; i < parts[0] * parts[1]; ++i) {
        Cell cell{.spans = {u, v}};
        const std::array<Index, 2> part{i / parts[1], i % parts[1]};
        for (std::size_t k = 0; k < 2; ++k) {
          const double from = piece.from(static_cast<int>(k)), to = piece.to(static_cast<int>(k));
          cell.from[k] = std::lerp(from, to, static_cast<double>(part[k]) / static_cast<double>(parts[k]));
          cell.to[k] = std::lerp(from, to, static_cast<double>(part[k] + 1) / static_cast<double>(parts[k]));
        }
        cells.push_back(cell);
      }
    }
  }

  const RulePair rules = chooseRules(cells.size(), 2, options.maxEvaluations);
  const auto integrate = [&](Cell& cell) {
    const SurfacePiece piece(surface, cell.spans[0], cell.spans[1]);
    std::vector<SurfaceJet> jets;
    Index inside = 0;
    const auto apply = [&](const GaussRule& rule) {
      const auto us = nodesOn(rule, cell.from[0], cell.to[0]), vs = nodesOn(rule, cell.from[1], cell.to[1]);
      piece.grid(us, vs, 3, jets);
      Figures sum = Figures::Zero();
      for (std::size_t i = 0; i < us.size(); ++i) {
        for (std::size_t j = 0; j < vs.size(); ++j) {
          if (options.inside && !options.inside(us[i], vs[j], options.context)) continue;
          ++inside;
          sum += rule.weights[i] * rule.weights[j] * surfaceDensity(jets[i * vs.size() + j]);
        }
      }
      return Figures(sum * ((cell.to[0] - cell.from[0]) * (cell.to[1] - cell.from[1]) / 4));
    };
    cell.value = apply(rules.fine);
    cell.error = (cell.value - apply(rules.coarse)).abs();
    cell.cut = inside > 0 && inside < rules.evaluations(2);
  };
  const Totals totals = integrateAdaptively(std::move(cells), 2, rules.evaluations(2), options, integrate);
  return {totals.value[0], totals.value[1], totals.value[2], totals.value[3], totals.relativeError};
}

CurveFairness curveFairness(const Curve& curve, const FairnessOptions& options) {
  std::vector<Cell> cells;
  for (const Index span : curve.knots(0).spans()) {
    const CurvePiece piece(curve, span);
    cells.push_back({.spans = {span, 0}, .from = {piece.from(), 0}, .to = {piece.to(), 0}});
  }
  const RulePair rules = chooseRules(cells.size(), 1, options.maxEvaluations);
  const auto integrate = [&](Cell& cell) {
    const CurvePiece piece(curve, cell.spans[0]);
    const auto apply = [&](const GaussRule& rule) {
      const auto nodes = nodesOn(rule, cell.from[0], cell.to[0]);
      Figures sum = Figures::Zero();
      CurveJet jet;
      for (std::size_t i = 0; i < nodes.size(); ++i) {
        piece.at(nodes[i], 3, jet);
        sum += rule.weights[i] * curveDensity(jet);
      }
      return Figures(sum * ((cell.to[0] - cell.from[0]) / 2));
    };
    cell.value = apply(rules.fine);
    cell.error = (cell.value - apply(rules.coarse)).abs();
  };
  const Totals totals = integrateAdaptively(std::move(cells), 1, rules.evaluations(1), options, integrate);
  return {totals.value[0], totals.value[1], totals.value[2]};
}

}  // namespace strak
