#include "strak/solve/hull_windows.h"

#include <tbb/parallel_for.h>

#include <algorithm>
#include <numeric>

#include "strak/solve/halves.h"

namespace strak {

using Eigen::Index;

namespace {

std::size_t at(Index i) { return static_cast<std::size_t>(i); }

// What a point is coupled with: the other point and the place of the block.
struct Coupling {
  int other;
  bool transposed;  // the block at `place` is that of (other, point)
  Index place;
};

struct Couplings {
  std::vector<Index> start;
  std::vector<Coupling> list;

  explicit Couplings(const BlockPattern& pattern) : start(at(pattern.size() + 1), 0) {
    const auto each = [&](const auto& visit) {
      for (Index j = 0; j < pattern.size(); ++j) {
        for (Index k = pattern.start[at(j)]; k < pattern.start[at(j + 1)]; ++k) {
          const int i = pattern.rows[at(k)];
          visit(i, Coupling{static_cast<int>(j), false, k});
          if (i != j) visit(static_cast<int>(j), Coupling{i, true, k});
        }
      }
    };
    each([&](int point, const Coupling&) { ++start[at(point) + 1]; });
    std::partial_sum(start.begin(), start.end(), start.begin());
    list.resize(at(start.back()));
    std::vector<Index> next(start.begin(), start.end() - 1);
    each([&](int point, const Coupling& coupling) { list[at(next[at(point)]++)] = coupling; });
  }
  const Coupling* begin(int point) const { return list.data() + start[at(point)]; }
  const Coupling* end(int point) const { return list.data() + start[at(point) + 1]; }
};

// The rows that each point takes part in.
struct RowsOfPoints {
  std::vector<Index> start;
  std::vector<int> row;

  RowsOfPoints(const BallRows& rows, Index points) : start(at(points + 1), 0), row(rows.point.size()) {
    for (int p : rows.point) ++start[at(p) + 1];
    std::partial_sum(start.begin(), start.end(), start.begin());
    std::vector<Index> next(start.begin(), start.end() - 1);
    for (Index i = 0; i < rows.count(); ++i) {
      for (Index k = rows.start[at(i)]; k < rows.start[at(i + 1)]; ++k) {
        row[at(next[at(rows.point[at(k)])]++)] = static_cast<int>(i);
      }
    }
  }
};

using Points = std::vector<int>;

void bisect(Points points, const Eigen::Ref<const Eigen::MatrixX3d>& places, Index most, std::vector<Points>& parts) {
  if (static_cast<Index>(points.size()) <= most) {
    std::sort(points.begin(), points.end());
    if (!points.empty()) parts.push_back(std::move(points));
    return;
  }
  const auto middle = points.begin() + halveByPlace(points, places);
  bisect(Points(points.begin(), middle), places, most, parts);
  bisect(Points(middle, points.end()), places, most, parts);
}

}  // namespace

struct HullWindows::Parts {
  std::shared_ptr<const BlockPattern> pattern;
  Eigen::MatrixX3d places;
  Couplings couplings;
  std::vector<Points> windows;
  std::vector<std::vector<std::size_t>> colours;  // windows that do not touch one another

  Parts(std::shared_ptr<const BlockPattern> coupled, const Eigen::Ref<const Eigen::MatrixX3d>& where)
      : pattern(std::move(coupled)), places(where), couplings(*pattern) {}

  Points withNeighbours(const Points& points) const;
  void colour();
  HullResult minimize(const Points& window, const HullProblem& problem, const RowsOfPoints& rowsOf,
                      const HullOptions& options, Eigen::VectorXd& x) const;
};

Points HullWindows::Parts::withNeighbours(const Points& points) const {
  Points wider = points;
  for (int p : points) {
    for (const Coupling* c = couplings.begin(p); c != couplings.end(p); ++c) wider.push_back(c->other);
  }
  std::sort(wider.begin(), wider.end());
  wider.erase(std::unique(wider.begin(), wider.end()), wider.end());
  return wider;
}

void HullWindows::Parts::colour() {
  std::vector<std::vector<char>> taken;  // by colours: points that its windows move or look at
  for (std::size_t w = 0; w < windows.size(); ++w) {
    const Points seen = withNeighbours(windows[w]);
    std::size_t colour = 0;
    for (; colour < colours.size(); ++colour) {
      const auto& marks = taken[colour];
      if (std::none_of(seen.begin(), seen.end(), [&](int p) { return marks[at(p)] != 0; })) break;
    }
    if (colour == colours.size()) {
      colours.emplace_back();
      taken.emplace_back(at(pattern->size()), 0);
    }
    colours[colour].push_back(w);
    // What another one moves must not be seen by this one; what both only see does no harm.
    for (int p : windows[w]) taken[colour][at(p)] = 1;
  }
}

HullResult HullWindows::Parts::minimize(const Points& window, const HullProblem& problem, const RowsOfPoints& rowsOf,
                                        const HullOptions& options, Eigen::VectorXd& x) const {
  const Index n = static_cast<Index>(window.size());
  const auto localOf = [&](int p) {
    const auto found = std::lower_bound(window.begin(), window.end(), p);
    return found != window.end() && *found == p ? static_cast<int>(found - window.begin()) : -1;
  };
  // The matrix of the window, and what the points around it add to the linear part.
  BlockPattern own;
  own.start.assign(1, 0);
  std::vector<Index> blocks;
  Eigen::VectorXd linear(3 * n), start(3 * n);
  for (Index j = 0; j < n; ++j) {
    const int p = window[at(j)];
    start.segment<3>(3 * j) = x.segment<3>(3 * p);
    Eigen::Vector3d sum = problem.linear.segment<3>(3 * p);
    for (const Coupling* c = couplings.begin(p); c != couplings.end(p); ++c) {
      const int local = localOf(c->other);
      if (local < 0) {
        const Eigen::Map<const Eigen::Matrix<double, 3, 3, Eigen::RowMajor>> block(problem.hessian->at(c->place));
        const Eigen::Vector3d there = x.segment<3>(3 * c->other);
        if (c->transposed) {
          sum += block.transpose() * there;
        } else {
          sum += block * there;
        }
      } else if (c->other >= p) {
        // Windows are sorted, so the order of the rows of a column is that of the whole pattern.
        own.rows.push_back(local);
        blocks.push_back(c->place);
      }
    }
    own.start.push_back(static_cast<Index>(own.rows.size()));
    linear.segment<3>(3 * j) = sum;
  }
  const auto ownPattern = std::make_shared<const BlockPattern>(std::move(own));
  BlockMatrix matrix(ownPattern);
  for (std::size_t k = 0; k < blocks.size(); ++k) {
    std::copy_n(problem.hessian->at(blocks[k]), 9, matrix.at(static_cast<Index>(k)));
  }
  Eigen::MatrixX3d where(n, 3);
  for (Index j = 0; j < n; ++j) where.row(j) = places.row(window[at(j)]);
  NestedCholesky factor(ownPattern, where);

  // The rows that a point of the window moves; what the others give them does not change.
  BallRows rows;
  std::vector<double> offsets;
  if (problem.rows) {
    std::vector<int> touched;
    for (int p : window) {
      touched.insert(touched.end(), rowsOf.row.begin() + rowsOf.start[at(p)],
                     rowsOf.row.begin() + rowsOf.start[at(p) + 1]);
    }
    std::sort(touched.begin(), touched.end());
    touched.erase(std::unique(touched.begin(), touched.end()), touched.end());
    for (int i : touched) {
      Eigen::Vector3d offset = Eigen::Vector3d::Zero();
      if (problem.offset) offset = problem.offset->segment<3>(3 * i);
      for (Index k = problem.rows->start[at(i)]; k < problem.rows->start[at(i) + 1]; ++k) {
        const int p = problem.rows->point[at(k)], local = localOf(p);
        if (local < 0) {
          offset += problem.rows->weight[at(k)] * x.segment<3>(3 * p);
        } else {
          rows.point.push_back(local);
          rows.weight.push_back(problem.rows->weight[at(k)]);
        }
      }
      rows.start.push_back(static_cast<Index>(rows.point.size()));
      rows.radius.push_back(problem.rows->radius[at(i)]);
      offsets.insert(offsets.end(), offset.data(), offset.data() + 3);
    }
  }
  const Eigen::VectorXd offset = Eigen::Map<const Eigen::VectorXd>(offsets.data(), static_cast<Index>(offsets.size()));
  const HullProblem part{&matrix, std::move(linear), &rows, &offset};
  const HullResult result = minimizeInHull(part, factor, start, options);
  if (result.solved) {
    for (Index j = 0; j < n; ++j) x.segment<3>(3 * window[at(j)]) = start.segment<3>(3 * j);
  }
  return result;
}

HullWindows::HullWindows(std::shared_ptr<const BlockPattern> pattern, const Eigen::Ref<const Eigen::MatrixX3d>& places,
                         const WindowOptions& options, std::vector<int> points)
    : parts_(std::make_unique<Parts>(std::move(pattern), places)) {
  if (points.empty()) {
    points.resize(at(parts_->pattern->size()));
    std::iota(points.begin(), points.end(), 0);
  }
  bisect(std::move(points), parts_->places, options.points, parts_->windows);
  for (Points& window : parts_->windows) {
    for (int k = 0; k < options.overlap; ++k) window = parts_->withNeighbours(window);
  }
  parts_->colour();
}

HullWindows::~HullWindows() = default;
HullWindows::HullWindows(HullWindows&&) noexcept = default;
HullWindows& HullWindows::operator=(HullWindows&&) noexcept = default;

Index HullWindows::windows() const { return static_cast<Index>(parts_->windows.size()); }

HullResult HullWindows::sweep(const HullProblem& problem, Eigen::VectorXd& x, const HullOptions& options) const {
  // A window has its share of the value.
  HullOptions own = options;
  const double share = 1 / static_cast<double>(std::max<Index>(1, windows()));
  own.accuracy *= share;
  own.firstGap *= share;
  const RowsOfPoints rowsOf(problem.rows ? *problem.rows : BallRows{}, parts_->pattern->size());
  std::vector<HullResult> results(parts_->windows.size());
  for (const auto& colour : parts_->colours) {
    tbb::parallel_for(std::size_t{0}, colour.size(), [&](std::size_t k) {
      const std::size_t w = colour[k];
      results[w] = parts_->minimize(parts_->windows[w], problem, rowsOf, own, x);
    });
  }
  HullResult all;
  all.solved = true;
  for (const HullResult& result : results) {
    all.solved = all.solved && result.solved;
    all.factors += result.factors;
  }
  all.value = x.dot(0.5 * problem.hessian->times(x) + problem.linear);
  return all;
}

}  // namespace strak
