#include "strak/fairing/kjellander.h"

#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <limits>

#include "strak/base/cpu_time.h"
#include "strak/base/error.h"
#include "strak/metrology/deviation.h"
#include "strak/spline/basis.h"

namespace strak {

namespace {

constexpr Index kMostRows = 2000;  // of a curve
constexpr Index kMostRowsSurface = 400;

// One direction: what a cubic spline is at its knots, as matrices on its control points.
struct Direction {
  Index inner = 0;                 // knots strictly inside
  std::vector<double> at;          // parameters of all breaks, ends included
  Eigen::MatrixXd values, slopes;  // at all breaks: rows of breaks, columns of control points
  Eigen::MatrixXd jumps;           // of the third derivative at the inner knots
  Eigen::MatrixXd unit;            // column i: control points that move inner knot point i by one and no other

  explicit Direction(const KnotVector& knots) {
    const Index n = knots.size();
    const auto spans = knots.spans();
    inner = static_cast<Index>(spans.size()) - 1;
    values = slopes = Eigen::MatrixXd::Zero(inner + 2, n);
    jumps = Eigen::MatrixXd::Zero(inner, n);
    for (std::size_t k = 0; k <= spans.size(); ++k) {
      const Index s = spans[std::min(k, spans.size() - 1)];
      const double u = k < spans.size() ? knots[s] : knots.to();
      const auto basis = basisDerivatives(knots, s, u, 3);
      const auto row = static_cast<Index>(k);
      at.push_back(u);
      values.row(row).segment(s - 3, 4) = basis.row(0);
      slopes.row(row).segment(s - 3, 4) = basis.row(1);
      if (k == 0 || k == spans.size()) continue;
      const Index before = spans[k - 1];
      jumps.row(row - 1).segment(s - 3, 4) += basis.row(3);
      jumps.row(row - 1).segment(before - 3, 4) -= basisDerivatives(knots, before, u, 3).row(3);
    }
    Eigen::MatrixXd conditions(n, n);
    conditions << values, slopes.row(0), slopes.row(inner + 1);
    unit = conditions.partialPivLu().inverse().middleCols(1, inner);
  }

  // Rows: the change of inner knot point i that puts it on the Hermite cubic between its neighbours.
  Eigen::MatrixXd targets() const {
    Eigen::MatrixXd result(inner, values.cols());
    for (Index i = 1; i <= inner; ++i) {
      const double a = at[static_cast<std::size_t>(i - 1)], b = at[static_cast<std::size_t>(i + 1)];
      const double h = b - a, t = (at[static_cast<std::size_t>(i)] - a) / h;
      result.row(i - 1) = (1 + 2 * t) * (1 - t) * (1 - t) * values.row(i - 1) +
                          t * t * (3 - 2 * t) * values.row(i + 1) + h * t * (1 - t) * (1 - t) * slopes.row(i - 1) -
                          h * t * t * (1 - t) * slopes.row(i + 1) - values.row(i);
    }
    return result;
  }
};

template <int D>
void check(const Spline<D>& spline, const KjellanderOptions& options) {
  for (int k = 0; k < D; ++k) {
    const auto inner = spline.knots(k).innerKnots();
    const bool simple =
        std::all_of(inner.begin(), inner.end(), [](const auto& knot) { return knot.multiplicity == 1; });
    if (spline.isRational() || spline.degree(k) != 3 || !simple || !spline.knots(k).isClamped()) {
      throw InvalidInput(
          "Kjellander's method is for cubic polynomial splines with clamped ends and simple inner knots: fair by the "
          "exact energy, or rebuild the spline first");
    }
    if (spline.size(k) > (D == 1 ? kMostRows : kMostRowsSurface)) {
      throw InvalidInput(
          "Kjellander's method redraws the whole spline in every step: this one has too many points for it");
    }
  }
  if (!(options.tolerance >= 0)) throw InvalidInput("the tolerance must not be negative");
  if (!options.held.empty() && static_cast<Index>(options.held.size()) != spline.net().rows()) {
    throw InvalidInput("the list of held points must have one entry a control point or be empty");
  }
}

// All quantities are linear in the net.
class CurveTask {
 public:
  explicit CurveTask(const Curve& curve) : u_(curve.knots(0)), targets_(u_.targets()), net_(curve.net()) {
    net_.rowwise() -= net_.row(0).eval();
    moves_ = targets_ * net_;
    jumps_ = u_.jumps * net_;
    targetsOfUnit_ = targets_ * u_.unit;
    jumpsOfUnit_ = u_.jumps * u_.unit;
  }
  Index places() const { return u_.inner; }
  Point move(Index i) const { return moves_.row(i); }
  double energy() const { return jumps_.squaredNorm(); }
  double change(Index i, const Point& step) const {
    return 2 * (jumpsOfUnit_.col(i).transpose() * jumps_).dot(step) +
           jumpsOfUnit_.col(i).squaredNorm() * step.squaredNorm();
  }
  void take(Index i, const Point& step) {
    moves_ += targetsOfUnit_.col(i) * step;
    jumps_ += jumpsOfUnit_.col(i) * step;
  }
  Net displacement(const Net& steps) const { return u_.unit * steps; }

 private:
  Direction u_;
  Eigen::MatrixXd targets_;
  Net net_;
  Eigen::MatrixXd moves_, jumps_, targetsOfUnit_, jumpsOfUnit_;
};

class SurfaceTask {
 public:
  using Matrix = Eigen::MatrixXd;

  explicit SurfaceTask(const Surface& surface) : u_(surface.knots(0)), v_(surface.knots(1)) {
    const Index nu = surface.size(0), nv = surface.size(1);
    const Matrix targetU = u_.targets(), targetV = v_.targets();
    const Matrix innerU = u_.values.middleRows(1, u_.inner), innerV = v_.values.middleRows(1, v_.inner);
    for (Index c = 0; c < surface.net().cols(); ++c) {
      Matrix net(nu, nv);
      for (Index i = 0; i < nu; ++i) {
        for (Index j = 0; j < nv; ++j) net(i, j) = surface.net()(i * nv + j, c) - surface.net()(0, c);
      }
      moves_.push_back((targetU * net * innerV.transpose() + innerU * net * targetV.transpose()) / 2);
      jumpsU_.push_back(u_.jumps * net * innerV.transpose());
      jumpsV_.push_back(innerU * net * v_.jumps.transpose());
    }
    targetsU_ = targetU * u_.unit;
    targetsV_ = targetV * v_.unit;
    jumpU_ = u_.jumps * u_.unit;
    jumpV_ = v_.jumps * v_.unit;
    // Jumps in u count as if both directions had the same mean spacing: the sum has one unit.
    const double ratio = (u_.at.back() - u_.at.front()) / static_cast<double>(u_.inner + 1) /
                         ((v_.at.back() - v_.at.front()) / static_cast<double>(v_.inner + 1));
    weightU_ = std::pow(ratio, 6);
  }
  Index places() const { return u_.inner * v_.inner; }
  Point move(Index place) const {
    Point result(static_cast<Index>(moves_.size()));
    for (std::size_t c = 0; c < moves_.size(); ++c)
      result[static_cast<Index>(c)] = moves_[c](row(place), column(place));
    return result;
  }
  double energy() const {
    double sum = 0;
    for (std::size_t c = 0; c < moves_.size(); ++c)
      sum += weightU_ * jumpsU_[c].squaredNorm() + jumpsV_[c].squaredNorm();
    return sum;
  }
  // A unit move of one knot point changes the jumps in u along its row of knots only, and in v along its column.
  double change(Index place, const Point& step) const {
    const Index i = row(place), j = column(place);
    double sum = 0;
    for (std::size_t c = 0; c < moves_.size(); ++c) {
      const double s = step[static_cast<Index>(c)];
      sum += weightU_ * (2 * s * jumpU_.col(i).dot(jumpsU_[c].col(j)) + s * s * jumpU_.col(i).squaredNorm());
      sum += 2 * s * jumpV_.col(j).dot(jumpsV_[c].row(i).transpose()) + s * s * jumpV_.col(j).squaredNorm();
    }
    return sum;
  }
  void take(Index place, const Point& step) {
    const Index i = row(place), j = column(place);
    for (std::size_t c = 0; c < moves_.size(); ++c) {
      const double s = step[static_cast<Index>(c)];
      moves_[c].col(j) += s / 2 * targetsU_.col(i);
      moves_[c].row(i) += s / 2 * targetsV_.col(j).transpose();
      jumpsU_[c].col(j) += s * jumpU_.col(i);
      jumpsV_[c].row(i) += s * jumpV_.col(j).transpose();
    }
  }
  Net displacement(const Net& steps) const {
    const Index nu = u_.values.cols(), nv = v_.values.cols();
    Net result(nu * nv, steps.cols());
    for (Index c = 0; c < steps.cols(); ++c) {
      Matrix inner(u_.inner, v_.inner);
      for (Index place = 0; place < places(); ++place) inner(row(place), column(place)) = steps(place, c);
      const Matrix net = u_.unit * inner * v_.unit.transpose();
      for (Index i = 0; i < nu; ++i) result.col(c).segment(i * nv, nv) = net.row(i).transpose();
    }
    return result;
  }

 private:
  Index row(Index place) const { return place / v_.inner; }
  Index column(Index place) const { return place % v_.inner; }

  Direction u_, v_;
  std::vector<Matrix> moves_, jumpsU_, jumpsV_;  // a matrix a coordinate
  Matrix targetsU_, targetsV_, jumpU_, jumpV_;
  double weightU_ = 1;
};

// Moves the knot points one by one; returns how far each went.
template <class T>
Net moveGreedily(T& task, Index columns, const KjellanderOptions& options, FairingSummary& summary) {
  constexpr double kLeast = 1e-9;  // of the energy at the start
  Net steps = Net::Zero(task.places(), columns);
  std::vector<bool> asleep(static_cast<std::size_t>(task.places()), false);
  while (summary.stopReason == StopReason::steps && summary.steps < options.maxSteps) {
    double farthest = 0;
    Index place = -1;
    for (Index i = 0; i < task.places(); ++i) {
      const double distance = asleep[static_cast<std::size_t>(i)] ? 0 : task.move(i).norm();
      if (distance > farthest) {
        farthest = distance;
        place = i;
      }
    }
    if (place < 0) {
      summary.stopReason = StopReason::gain;
      break;
    }
    asleep[static_cast<std::size_t>(place)] = true;
    Point target = steps.row(place) + task.move(place);
    if (target.norm() > options.tolerance) target *= options.tolerance / target.norm();
    const Point step = target - steps.row(place);
    if (!(task.change(place, step) < -kLeast * summary.energyBefore)) continue;
    task.take(place, step);
    steps.row(place) = target;
    std::fill(asleep.begin(), asleep.end(), false);
    asleep[static_cast<std::size_t>(place)] = true;
    ++summary.steps;
    if (summary.steps % 64 == 0 && !options.progress.report(-1, "moving points one by one")) {
      summary.stopReason = StopReason::cancelled;
    }
  }
  return steps;
}

}  // namespace

template <int D>
Faired<D> fairByKjellander(const Spline<D>& spline, const KjellanderOptions& options) {
  const double begun = threadSeconds();
  check(spline, options);
  Faired<D> result{spline, {}};
  FairingSummary& summary = result.summary;
  summary.gap = std::numeric_limits<double>::infinity();
  bool any = options.tolerance > 0;
  for (int k = 0; k < D; ++k) any = any && !spline.knots(k).innerKnots().empty();
  summary.stopReason = any ? StopReason::steps : StopReason::nothingFree;
  if (!any) return result;
  std::conditional_t<D == 1, CurveTask, SurfaceTask> task(spline);
  summary.freePoints = task.places();
  summary.energyBefore = task.energy();
  const Net steps = moveGreedily(task, spline.net().cols(), options, summary);
  summary.energyAfter = task.energy();
  Net displacement = task.displacement(steps);
  for (Index r = 0; r < displacement.rows(); ++r) {
    if (!options.held.empty() && options.held[static_cast<std::size_t>(r)] != 0) displacement.row(r).setZero();
  }
  // The spline between the points may have gone further than they did.
  for (int attempt = 0; attempt < 3; ++attempt) {
    result.spline.net() = spline.net() + displacement;
    const double deviation = certifyDeviation(spline, result.spline).upper;
    if (deviation <= options.tolerance) break;
    displacement *= (1 - 1e-9) * options.tolerance / deviation;
  }
  summary.largestMove = displacement.rowwise().norm().maxCoeff();
  summary.seconds = threadSeconds() - begun;
  return result;
}

template Faired<1> fairByKjellander(const Spline<1>&, const KjellanderOptions&);
template Faired<2> fairByKjellander(const Spline<2>&, const KjellanderOptions&);

}  // namespace strak
