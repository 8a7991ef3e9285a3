#include "strak/metrology/closest_points.h"

#include <fmt/format.h>
#include <tbb/parallel_for.h>

#include <algorithm>
#include <atomic>
#include <cmath>
#include <memory>
#include <mutex>

#include "strak/base/error.h"
#include "strak/spline/evaluator.h"

namespace strak {

namespace {

constexpr Index kBlock = 256;       // points evaluated together
constexpr int kMostSteps = 8;       // more are a matter for the safeguarded search
constexpr double kLastStep = 1e-8;  // in parts of the stretch: after it Newton's error is its square, rounding
constexpr double kLeastCosine = 1e-14;

// Where a direction is C1 at least: the search stays within.
struct Stretch {
  double from, to;
};

std::vector<Stretch> stretchesOf(const KnotVector& knots) {
  std::vector<Stretch> result{{knots.from(), knots.to()}};
  for (const auto& knot : knots.innerKnots()) {
    if (knot.multiplicity < knots.degree()) continue;
    result.back().to = knot.value;
    result.push_back({knot.value, knots.to()});
  }
  return result;
}

const Stretch& stretchAt(const std::vector<Stretch>& stretches, double u) {
  std::size_t s = 0;
  while (s + 1 < stretches.size() && u >= stretches[s].to) ++s;
  return stretches[s];
}

template <int D>
void checkShapes(const Spline<D>& spline, const Eigen::Ref<const Net>& points) {
  if (points.cols() != spline.pointDimension()) {
    throw InvalidInput(fmt::format("the points have {} coordinates but the spline has {}: give as many", points.cols(),
                                   spline.pointDimension()));
  }
  if (!points.allFinite()) throw InvalidInput("a point is not finite: correct its coordinates");
}

// One point on its way.
template <int D>
struct Search {
  Index number = 0;
  std::array<double, D> u{};  // of the last evaluation, or to be evaluated
  std::array<Stretch, D> box{};
  double value = std::numeric_limits<double>::infinity();  // squared distance before
};

enum class Outcome { goOn, done, difficult };

// A Newton step from the derivatives d (rows of `columns` coordinates) at search.u; moves it. When it is the last, the
// point there is made of the derivatives, and no evaluation is needed.
template <int D>
Outcome step(const double* d, Index columns, const double* target, Search<D>& search, double* point) {
  double r[3], value = 0;
  for (Index c = 0; c < columns; ++c) {
    r[c] = d[c] - target[c];
    value += r[c] * r[c];
  }
  if (value > search.value) return Outcome::difficult;
  search.value = value;
  const auto dot = [&](const double* a, const double* b) {
    double sum = 0;
    for (Index c = 0; c < columns; ++c) sum += a[c] * b[c];
    return sum;
  };
  double gradient[D], hessian[D][D], tangent[D];
  bool stationary = true;
  const double* second = d + (D + 1) * columns;
  for (int a = 0; a < D; ++a) {
    gradient[a] = dot(r, d + (1 + a) * columns);
    for (int b = a; b < D; ++b, second += columns) {
      hessian[a][b] = hessian[b][a] = dot(d + (1 + a) * columns, d + (1 + b) * columns) + dot(r, second);
    }
    tangent[a] = dot(d + (1 + a) * columns, d + (1 + a) * columns);
  }
  for (std::size_t a = 0; a < D; ++a) {
    // At a bound with the derivative pointing outwards the parameter stays.
    if ((search.u[a] <= search.box[a].from && gradient[a] > 0) ||
        (search.u[a] >= search.box[a].to && gradient[a] < 0)) {
      gradient[a] = 0;
      for (std::size_t b = 0; b < D; ++b) hessian[a][b] = hessian[b][a] = 0;
      hessian[a][a] = 1;
    }
    stationary = stationary && gradient[a] * gradient[a] <= kLeastCosine * kLeastCosine * value * tangent[a];
  }
  double way[D];
  if constexpr (D == 1) {
    if (!(hessian[0][0] > 0)) return stationary ? Outcome::done : Outcome::difficult;
    way[0] = -gradient[0] / hessian[0][0];
  } else {
    const double determinant = hessian[0][0] * hessian[1][1] - hessian[0][1] * hessian[0][1];
    if (!stationary && !(hessian[0][0] > 0 && determinant > 1e-14 * hessian[0][0] * hessian[1][1])) {
      return Outcome::difficult;
    }
    way[0] = (hessian[0][1] * gradient[1] - hessian[1][1] * gradient[0]) / determinant;
    way[1] = (hessian[0][1] * gradient[0] - hessian[0][0] * gradient[1]) / determinant;
  }
  double largest = 0, change[D];
  for (std::size_t a = 0; a < D; ++a) {
    const double next =
        stationary ? search.u[a] : std::clamp(search.u[a] + way[a], search.box[a].from, search.box[a].to);
    change[a] = next - search.u[a];
    search.u[a] = next;
    largest = std::max(largest, std::abs(change[a]) / (search.box[a].to - search.box[a].from));
  }
  if (largest > kLastStep) return Outcome::goOn;
  for (Index c = 0; c < columns; ++c) {
    point[c] = d[c];
    for (int a = 0; a < D; ++a) point[c] += change[a] * d[(1 + a) * columns + c];
  }
  return Outcome::done;
}

template <int D>
class Batch {
 public:
  Batch(const Spline<D>& spline, const Eigen::Ref<const Net>& points, const Eigen::Ref<const Net>& starts)
      : spline_(spline), evaluator_(spline), points_(points), starts_(starts) {
    for (std::size_t k = 0; k < D; ++k) stretches_[k] = stretchesOf(spline.knots()[k]);
    result_.parameters.resize(points.rows(), D);
    result_.points.resize(points.rows(), points.cols());
    result_.distances.resize(points.rows());
  }

  ClosestPoints<D> run() {
    const Index blocks = (points_.rows() + kBlock - 1) / kBlock;
    tbb::parallel_for(Index{0}, blocks,
                      [&](Index b) { runBlock(b * kBlock, std::min(kBlock, points_.rows() - b * kBlock)); });
    result_.difficult = difficult_;
    return std::move(result_);
  }

 private:
  void runBlock(Index begin, Index count) {
    const Index columns = points_.cols();
    std::vector<Search<D>> active(static_cast<std::size_t>(count));
    for (Index r = 0; r < count; ++r) {
      Search<D>& s = active[static_cast<std::size_t>(r)];
      s.number = begin + r;
      for (std::size_t k = 0; k < D; ++k) {
        s.u[k] =
            std::clamp(starts_(begin + r, static_cast<Index>(k)), spline_.knots()[k].from(), spline_.knots()[k].to());
        s.box[k] = stretchAt(stretches_[k], s.u[k]);
      }
    }
    Net parameters(count, D), d(count, derivativeCount(D, 2) * columns);
    for (int i = 0; i < kMostSteps && !active.empty(); ++i) {
      const auto now = static_cast<Index>(active.size());
      for (Index r = 0; r < now; ++r) {
        const Search<D>& s = active[static_cast<std::size_t>(r)];
        for (std::size_t k = 0; k < D; ++k) {
          // On the upper end of a stretch, the polynomial before it.
          const bool before = s.u[k] == s.box[k].to && s.box[k].to < spline_.knots()[k].to();
          parameters(r, static_cast<Index>(k)) = before ? std::nextafter(s.u[k], s.box[k].from) : s.u[k];
        }
      }
      evaluator_.derivativesAt(parameters.topRows(now), 2, d.topRows(now));
      std::size_t kept = 0;
      for (Index r = 0; r < now; ++r) {
        Search<D> s = active[static_cast<std::size_t>(r)];
        const double* target = points_.data() + s.number * points_.outerStride();
        const auto before = s.u;
        switch (step<D>(&d(r, 0), columns, target, s, &result_.points(s.number, 0))) {
          case Outcome::goOn:
            active[kept++] = s;
            break;
          case Outcome::done:
            finish(s);
            break;
          case Outcome::difficult:
            s.u = before;
            search(s);
            break;
        }
      }
      active.resize(kept);
    }
    for (const Search<D>& s : active) search(s);
  }

  void finish(const Search<D>& s) {
    for (std::size_t k = 0; k < D; ++k) result_.parameters(s.number, static_cast<Index>(k)) = s.u[k];
    result_.distances[s.number] = (result_.points.row(s.number) - points_.row(s.number)).norm();
  }

  // The safeguarded search from the same start.
  void search(const Search<D>& s) {
    std::call_once(made_, [&] {
      finder_ = std::make_unique<ClosestPointFinder<D>>(spline_, ClosestPointOptions{1, 64});
    });
    ++difficult_;
    std::array<double, D> start;
    for (std::size_t k = 0; k < D; ++k) start[k] = starts_(s.number, static_cast<Index>(k));
    const auto found = finder_->findFrom(points_.row(s.number), start);
    for (std::size_t k = 0; k < D; ++k) result_.parameters(s.number, static_cast<Index>(k)) = found.parameters[k];
    result_.points.row(s.number) = found.point;
    result_.distances[s.number] = found.distance;
  }

  const Spline<D>& spline_;
  Evaluator<D> evaluator_;
  const Eigen::Ref<const Net>& points_;
  const Eigen::Ref<const Net>& starts_;
  std::array<std::vector<Stretch>, D> stretches_;
  ClosestPoints<D> result_;
  std::atomic<Index> difficult_{0};
  std::once_flag made_;
  std::unique_ptr<ClosestPointFinder<D>> finder_;
};

}  // namespace

template <int D>
ClosestPoints<D> closestPointsFrom(const Spline<D>& spline, const Eigen::Ref<const Net>& points,
                                   const Eigen::Ref<const Net>& starts) {
  checkShapes<D>(spline, points);
  if (points.cols() > 3) throw InvalidInput("closest points are looked for among points of up to three coordinates");
  if (starts.rows() != points.rows() || starts.cols() != D || !starts.allFinite()) {
    throw InvalidInput(
        fmt::format("{} points need as many rows of {} finite parameters to start from", points.rows(), D));
  }
  return Batch<D>(spline, points, starts).run();
}

template <int D>
ClosestPoints<D> closestPoints(const Spline<D>& spline, const Eigen::Ref<const Net>& points,
                               const ClosestPointOptions& options) {
  checkShapes<D>(spline, points);
  const ClosestPointFinder<D> finder(spline, options);
  ClosestPoints<D> result;
  result.parameters.resize(points.rows(), D);
  result.points.resize(points.rows(), points.cols());
  result.distances.resize(points.rows());
  result.difficult = points.rows();
  tbb::parallel_for(Index{0}, points.rows(), [&](Index r) {
    const auto found = finder.find(points.row(r));
    for (std::size_t k = 0; k < D; ++k) result.parameters(r, static_cast<Index>(k)) = found.parameters[k];
    result.points.row(r) = found.point;
    result.distances[r] = found.distance;
  });
  return result;
}

template ClosestPoints<1> closestPointsFrom<1>(const Spline<1>&, const Eigen::Ref<const Net>&,
                                               const Eigen::Ref<const Net>&);
template ClosestPoints<2> closestPointsFrom<2>(const Spline<2>&, const Eigen::Ref<const Net>&,
                                               const Eigen::Ref<const Net>&);
template ClosestPoints<1> closestPoints<1>(const Spline<1>&, const Eigen::Ref<const Net>&, const ClosestPointOptions&);
template ClosestPoints<2> closestPoints<2>(const Spline<2>&, const Eigen::Ref<const Net>&, const ClosestPointOptions&);

}  // namespace strak
