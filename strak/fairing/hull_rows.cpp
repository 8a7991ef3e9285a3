#include "strak/fairing/hull_rows.h"

#include <algorithm>
#include <cmath>
#include <map>

#include "strak/spline/knot_insertion.h"
#include "strak/spline/rational.h"

namespace strak {

namespace {

using Rows = Eigen::SparseMatrix<double, Eigen::RowMajor>;

struct Fine {
  KnotVector knots;
  Rows matrix;
};

Fine refined(const KnotVector& knots, const std::vector<int>& levels) {
  const std::vector<Index> spans = knots.spans();
  std::vector<double> added;
  for (std::size_t s = 0; s < spans.size(); ++s) {
    const double from = knots[spans[s]], to = knots[spans[s] + 1];
    const int parts = 1 << levels[s];
    for (int k = 1; k < parts; ++k) {
      const double value = from + (to - from) * k / parts;
      if (from < value && value < to) added.push_back(value);
    }
  }
  Fine fine{added.empty() ? knots : withKnots(knots, added), {}};
  fine.matrix = refinementMatrix(knots, fine.knots);
  return fine;
}

// Calls visit(i, j) for every row of the refined net that a free point moves, in the order of appendHullRows.
template <class Visit>
void visitRows(const Surface& surface, const std::vector<int>& unknownOf, const Rows& ru, const Rows& rv,
               const Visit& visit) {
  const Index columns = surface.size(1);
  for (Index i = 0; i < ru.outerSize(); ++i) {
    for (Index j = 0; j < rv.outerSize(); ++j) {
      bool moves = false;
      for (Rows::InnerIterator a(ru, i); a && !moves; ++a) {
        for (Rows::InnerIterator b(rv, j); b && !moves; ++b) {
          moves = unknownOf[static_cast<std::size_t>(a.col() * columns + b.col())] >= 0;
        }
      }
      if (moves) visit(i, j);
    }
  }
}

}  // namespace

SpanLevels evenLevels(const Surface& surface, int level) {
  SpanLevels levels;
  for (int k = 0; k < 2; ++k) levels[static_cast<std::size_t>(k)].assign(surface.knots(k).spans().size(), level);
  return levels;
}

void appendHullRows(const Surface& surface, const std::vector<int>& unknownOf, const SpanLevels& levels,
                    double tolerance, BallRows& rows) {
  const Fine u = refined(surface.knots(0), levels[0]), v = refined(surface.knots(1), levels[1]);
  const Index columns = surface.size(1);
  Eigen::VectorXd weight;
  if (surface.isRational()) weight = weights(surface);
  visitRows(surface, unknownOf, u.matrix, v.matrix, [&](Index i, Index j) {
    double total = 0;
    const std::size_t first = rows.weight.size();
    for (Rows::InnerIterator a(u.matrix, i); a; ++a) {
      for (Rows::InnerIterator b(v.matrix, j); b; ++b) {
        const Index row = a.col() * columns + b.col();
        const double w = a.value() * b.value() * (weight.size() > 0 ? weight[row] : 1);
        total += w;
        if (unknownOf[static_cast<std::size_t>(row)] < 0) continue;
        rows.point.push_back(unknownOf[static_cast<std::size_t>(row)]);
        rows.weight.push_back(w);
      }
    }
    if (weight.size() > 0) {
      for (std::size_t k = first; k < rows.weight.size(); ++k) rows.weight[k] /= total;
    }
    rows.start.push_back(static_cast<Index>(rows.point.size()));
    rows.radius.push_back(tolerance);
  });
}

void appendHullRows(const Curve& curve, const PointMap& map, int level, double tolerance, BallRows& rows) {
  const KnotVector& knots = curve.knots(0);
  const Fine fine = refined(knots, std::vector<int>(knots.spans().size(), level));
  Eigen::VectorXd weight = Eigen::VectorXd::Ones(knots.size());
  if (curve.isRational()) weight = weights(curve);
  const Eigen::VectorXd total = fine.matrix * weight;
  for (Index i = 0; i < fine.matrix.outerSize(); ++i) {
    std::map<Index, double> factors;  // of the unknowns; several control points may hang on one
    for (Rows::InnerIterator a(fine.matrix, i); a; ++a) {
      for (const auto& [unknown, factor] : map.rows[static_cast<std::size_t>(a.col())]) {
        factors[unknown] += a.value() * weight[a.col()] / total[i] * factor;
      }
    }
    if (factors.empty()) continue;
    for (const auto& [unknown, factor] : factors) {
      rows.point.push_back(static_cast<int>(unknown));
      rows.weight.push_back(factor);
    }
    rows.start.push_back(static_cast<Index>(rows.point.size()));
    rows.radius.push_back(tolerance);
  }
}

bool refineActive(const Surface& surface, const std::vector<int>& unknownOf, const BallRows& rows, Index first,
                  const Eigen::VectorXd& x, double share, int most, SpanLevels& levels) {
  const Fine u = refined(surface.knots(0), levels[0]), v = refined(surface.knots(1), levels[1]);
  SpanLevels finer = levels;
  const auto mark = [&](int k, const KnotVector& fine, Index i) {
    const KnotVector& knots = surface.knots(k);
    const std::vector<Index> spans = knots.spans();
    for (std::size_t s = 0; s < spans.size(); ++s) {
      // The fine function i lives on [fine[i], fine[i + p + 1]].
      if (knots[spans[s] + 1] <= fine[i] || knots[spans[s]] >= fine[i + fine.degree() + 1]) continue;
      auto& level = finer[static_cast<std::size_t>(k)][s];
      level = std::min(most, levels[static_cast<std::size_t>(k)][s] + 1);
    }
  };
  Index row = first;
  visitRows(surface, unknownOf, u.matrix, v.matrix, [&](Index i, Index j) {
    Eigen::Vector3d sum = Eigen::Vector3d::Zero();
    for (auto k = static_cast<std::size_t>(rows.start[static_cast<std::size_t>(row)]);
         k < static_cast<std::size_t>(rows.start[static_cast<std::size_t>(row) + 1]); ++k) {
      sum += rows.weight[k] * x.segment<3>(3 * rows.point[k]);
    }
    if (sum.norm() > share * rows.radius[static_cast<std::size_t>(row)]) {
      mark(0, u.knots, i);
      mark(1, v.knots, j);
    }
    ++row;
  });
  const bool changed = finer != levels;
  levels = finer;
  return changed;
}

}  // namespace strak
