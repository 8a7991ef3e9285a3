#include "strak/solve/hull_minimizer.h"

#include <algorithm>
#include <cmath>

namespace strak {

using Eigen::Index;

Eigen::VectorXd BallRows::times(const Eigen::VectorXd& x) const {
  Eigen::VectorXd y(3 * count());
  for (Index i = 0; i < count(); ++i) {
    Eigen::Vector3d sum = Eigen::Vector3d::Zero();
    for (auto k = static_cast<std::size_t>(start[static_cast<std::size_t>(i)]);
         k < static_cast<std::size_t>(start[static_cast<std::size_t>(i) + 1]); ++k) {
      sum += weight[k] * x.segment<3>(3 * point[k]);
    }
    y.segment<3>(3 * i) = sum;
  }
  return y;
}

namespace {

double largestOf(const Eigen::VectorXd& sums, const std::vector<double>& radius) {
  double largest = 0;
  for (std::size_t i = 0; i < radius.size(); ++i) {
    largest = std::max(largest, sums.segment<3>(3 * static_cast<Index>(i)).norm() / radius[i]);
  }
  return largest;
}

}  // namespace

double BallRows::largestRatio(const Eigen::VectorXd& x) const { return largestOf(times(x), radius); }

Eigen::VectorXd BallRows::drawnIn(Eigen::VectorXd x) const {
  constexpr int kPasses = 100;
  constexpr double kInside = 1 - 1e-12;
  // One row's share moves its neighbours, so there are passes; what they leave is drawn in as a whole.
  for (int pass = 0; pass <= kPasses; ++pass) {
    const Eigen::VectorXd sums = times(x);
    const double largest = largestOf(sums, radius);
    if (!(largest > 1)) break;
    Eigen::VectorXd share = Eigen::VectorXd::Constant(x.size() / 3, pass < kPasses ? 1 : kInside / largest);
    for (Index i = 0; i < count() && pass < kPasses; ++i) {
      const auto row = static_cast<std::size_t>(i);
      const double ratio = sums.segment<3>(3 * i).norm() / radius[row];
      if (!(ratio > 1)) continue;
      for (auto k = static_cast<std::size_t>(start[row]); k < static_cast<std::size_t>(start[row + 1]); ++k) {
        share[point[k]] = std::min(share[point[k]], kInside / ratio);
      }
    }
    for (Index p = 0; p < share.size(); ++p) x.segment<3>(3 * p) *= share[p];
  }
  return x;
}

Eigen::VectorXd HullProblem::sums(const Eigen::VectorXd& x) const {
  Eigen::VectorXd sums = rows->times(x);
  if (offset) sums += *offset;
  return sums;
}

double HullProblem::largestRatio(const Eigen::VectorXd& x) const {
  return rows && rows->count() > 0 ? largestOf(sums(x), rows->radius) : 0;
}

namespace {

using Cone = Eigen::Vector4d;  // a point of the second-order cone: |last three| <= first
using Cones = Eigen::Matrix4Xd;

constexpr double kPullIn = 0.95;    // where the rows' sums are first taken to be, towards the middle of their balls
constexpr double kToBorder = 0.99;  // of the longest step
constexpr double kResidual = 2e-5;  // of the first one

inline double coneProduct(const Cone& a, const Cone& b) { return a[0] * b[0] - a.tail<3>().dot(b.tail<3>()); }

// The product of Jordan's algebra and its inverse.
Cone jordan(const Cone& a, const Cone& b) {
  Cone c;
  c[0] = a.dot(b);
  c.tail<3>() = a[0] * b.tail<3>() + b[0] * a.tail<3>();
  return c;
}
Cone jordanDivide(const Cone& d, const Cone& a) {
  Cone x;
  x[0] = (a[0] * d[0] - a.tail<3>().dot(d.tail<3>())) / coneProduct(a, a);
  x.tail<3>() = (d.tail<3>() - x[0] * a.tail<3>()) / a[0];
  return x;
}

// Nesterov and Todd's scaling of one cone, W z = W^-1 s:
// W = beta [w0, w1^T; w1, I + w1 w1^T / (1 + w0)], w0^2 - |w1|^2 = 1.
struct Scaling {
  Cone w;
  double beta = 1, inverse = 1, share = 0;  // inverse = 1 / beta, share = 1 / (1 + w0)

  Scaling(const Cone& s, const Cone& z) {
    const double ss = std::sqrt(coneProduct(s, s)), zz = std::sqrt(coneProduct(z, z));
    Cone mirrored = -z;
    mirrored[0] = z[0];
    const double inner = s.dot(z), both = ss * zz;
    w = (zz * s + ss * mirrored) / std::sqrt(2 * both * (both + inner));
    beta = std::sqrt(ss / zz);
    inverse = 1 / beta;
    share = 1 / (1 + w[0]);
  }
  Cone times(const Cone& x) const {
    const double along = w.tail<3>().dot(x.tail<3>());
    Cone y;
    y[0] = beta * (w[0] * x[0] + along);
    y.tail<3>() = beta * (x.tail<3>() + (x[0] + share * along) * w.tail<3>());
    return y;
  }
  Cone inverseTimes(const Cone& x) const {
    const double along = w.tail<3>().dot(x.tail<3>());
    Cone y;
    y[0] = inverse * (w[0] * x[0] - along);
    y.tail<3>() = inverse * (x.tail<3>() + (share * along - x[0]) * w.tail<3>());
    return y;
  }
  // W^-2 times (0, x).
  Cone inverseSquareTimes(const Eigen::Vector3d& x) const {
    const double along = 2 * w.tail<3>().dot(x), scale = inverse * inverse;
    Cone y;
    y[0] = -scale * along * w[0];
    y.tail<3>() = scale * (along * w.tail<3>() + x);
    return y;
  }
  // The block of W^-2 that belongs to the last three.
  Eigen::Matrix3d inverseSquare() const {
    return inverse * inverse * (2 * w.tail<3>() * w.tail<3>().transpose() + Eigen::Matrix3d::Identity());
  }
};

Cone atRest(const Eigen::Vector3d& x) { return {0, x[0], x[1], x[2]}; }

Eigen::Map<const Eigen::Matrix3Xd> asPoints(const Eigen::VectorXd& x) { return {x.data(), 3, x.size() / 3}; }

inline bool isInside(const Cone& x) { return x[0] > 0 && coneProduct(x, x) > 0; }

// The largest t, at most `most`, with x + t d in the cone; x lies inside.
double toBorder(const Cone& x, const Cone& d, double most) {
  const double a = coneProduct(d, d), b = coneProduct(x, d), c = coneProduct(x, x);
  double t = most;
  if (d[0] < 0) t = std::min(t, -x[0] / d[0]);
  const double root = b * b - a * c;
  if (root >= 0) {
    // The least positive zero of c + 2 b t + a t^2, c > 0, without cancellation.
    const double q = -(b + (b >= 0 ? std::sqrt(root) : -std::sqrt(root)));
    for (double zero : {q != 0 ? c / q : most, a != 0 ? q / a : most}) {
      if (zero > 0) t = std::min(t, zero);
    }
  }
  return t;
}

class InteriorPoints {
 public:
  InteriorPoints(const HullProblem& problem, NestedCholesky& factor, const Eigen::VectorXd& start, double firstGap)
      : p_(problem), rows_(*problem.rows), factor_(factor), newton_(*problem.hessian), x_(start) {
    findPlaces();
    const Index n = rows_.count();
    s_.resize(4, n);
    z_.resize(4, n);
    const Eigen::VectorXd y = kPullIn * p_.sums(x_);
    for (Index i = 0; i < n; ++i) {
      s_.col(i) << rows_.radius[static_cast<std::size_t>(i)], y.segment<3>(3 * i);
      Cone inverse = s_.col(i);
      inverse.tail<3>() *= -1;
      z_.col(i) = firstGap / static_cast<double>(n) / coneProduct(s_.col(i), s_.col(i)) * inverse;
    }
  }

  HullResult run(const HullOptions& options);
  const Eigen::VectorXd& x() const { return x_; }

 private:
  void findPlaces();
  void addTransposed(const Eigen::Matrix3Xd& y, double sign, Eigen::VectorXd& to) const;
  bool factorNewton(const std::vector<Scaling>& w);

  const HullProblem& p_;
  const BallRows& rows_;
  NestedCholesky& factor_;
  BlockMatrix newton_;
  Eigen::VectorXd x_;
  Cones s_, z_;
  std::vector<int> places_;  // of the blocks that the rows touch, in the order of factorNewton
};

void InteriorPoints::findPlaces() {
  for (std::size_t i = 0; i + 1 < rows_.start.size(); ++i) {
    for (auto a = static_cast<std::size_t>(rows_.start[i]); a < static_cast<std::size_t>(rows_.start[i + 1]); ++a) {
      for (auto b = static_cast<std::size_t>(rows_.start[i]); b < static_cast<std::size_t>(rows_.start[i + 1]); ++b) {
        if (rows_.point[a] < rows_.point[b]) continue;
        places_.push_back(static_cast<int>(newton_.pattern().place(rows_.point[a], rows_.point[b])));
      }
    }
  }
}

bool InteriorPoints::factorNewton(const std::vector<Scaling>& w) {
  newton_ = *p_.hessian;
  auto place = places_.begin();
  for (std::size_t i = 0; i + 1 < rows_.start.size(); ++i) {
    const Eigen::Matrix3d d = w[i].inverseSquare();
    for (auto a = static_cast<std::size_t>(rows_.start[i]); a < static_cast<std::size_t>(rows_.start[i + 1]); ++a) {
      for (auto b = static_cast<std::size_t>(rows_.start[i]); b < static_cast<std::size_t>(rows_.start[i + 1]); ++b) {
        if (rows_.point[a] < rows_.point[b]) continue;
        Eigen::Map<Eigen::Matrix3d>(newton_.at(*place++)) += rows_.weight[a] * rows_.weight[b] * d;
      }
    }
  }
  return factor_.factor(newton_);
}

// to += sign R^T y
void InteriorPoints::addTransposed(const Eigen::Matrix3Xd& y, double sign, Eigen::VectorXd& to) const {
  for (Index i = 0; i < rows_.count(); ++i) {
    for (auto k = static_cast<std::size_t>(rows_.start[static_cast<std::size_t>(i)]);
         k < static_cast<std::size_t>(rows_.start[static_cast<std::size_t>(i) + 1]); ++k) {
      to.segment<3>(3 * rows_.point[k]) += sign * rows_.weight[k] * y.col(i);
    }
  }
}

HullResult InteriorPoints::run(const HullOptions& options) {
  HullResult result;
  const Index n = rows_.count();
  double residualLeft = 1;
  Eigen::VectorXd ax = p_.hessian->times(x_);
  // Of one iteration; out here so that memory is not fetched anew in each.
  std::vector<Scaling> w;
  w.reserve(static_cast<std::size_t>(n));
  Cones lambda(4, n), wished(4, n), dz(4, n);
  Eigen::Matrix3Xd ds(3, n), apart(3, n);
  Eigen::VectorXd residual, dx;
  while (true) {
    result.gap = s_.cwiseProduct(z_).sum();
    result.value = x_.dot(0.5 * ax + p_.linear);
    if (result.gap <= options.accuracy && residualLeft <= kResidual) {
      result.solved = true;
      return result;
    }
    if (result.factors >= options.maxFactors) return result;
    w.clear();
    for (Index i = 0; i < n; ++i) {
      w.emplace_back(s_.col(i), z_.col(i));
      lambda.col(i) = w.back().times(z_.col(i));
    }
    ++result.factors;
    if (!lambda.allFinite() || !factorNewton(w)) return result;
    // The stationarity A x + b - R^T z = 0, and s = (radius, R x + offset).
    residual = ax + p_.linear;
    addTransposed(z_.bottomRows<3>(), -1, residual);
    apart = asPoints(p_.sums(x_)) - s_.bottomRows<3>();

    // Complementarity as dz = wished - W^-2 ds. The first entry of ds is zero, the radius stays.
    wished = -z_;
    const auto solve = [&](double share) {
      for (Index i = 0; i < n; ++i) {
        const Scaling& scale = w[static_cast<std::size_t>(i)];
        ds.col(i) = (wished.col(i) - scale.inverseSquareTimes(share * apart.col(i))).tail<3>();
      }
      Eigen::VectorXd right = -share * residual;
      addTransposed(ds, 1, right);
      dx = factor_.solve(right);
      ds = asPoints(rows_.times(dx)) + share * apart;
      for (Index i = 0; i < n; ++i) {
        dz.col(i) = wished.col(i) - w[static_cast<std::size_t>(i)].inverseSquareTimes(ds.col(i));
      }
    };
    const auto longest = [&] {
      double t = 1 / kToBorder;
      for (Index i = 0; i < n; ++i) {
        const Cone moves = atRest(ds.col(i));
        if (!isInside(s_.col(i) + t * moves)) t = toBorder(s_.col(i), moves, t);
        if (!isInside(z_.col(i) + t * dz.col(i))) t = toBorder(z_.col(i), dz.col(i), t);
      }
      return t;
    };
    solve(1);
    const double reach = std::min(1.0, longest());
    const double sigma = std::pow(1 - reach, 3), mean = result.gap / static_cast<double>(n);
    for (Index i = 0; i < n; ++i) {
      const Scaling& scale = w[static_cast<std::size_t>(i)];
      // Mehrotra's correction: W^-1 ds times W dz of the step just solved, W dz = -lambda - W^-1 ds.
      const Cone first = scale.inverseTimes(atRest(ds.col(i)));
      Cone correction = jordan(first, -lambda.col(i) - first);
      correction[0] -= sigma * mean;
      wished.col(i) = -z_.col(i) - scale.inverseTimes(jordanDivide(correction, lambda.col(i)));
    }
    solve(1 - sigma);
    const double t = kToBorder * longest();
    if (!(t > 1e-8) || !dx.allFinite()) return result;
    x_ += t * dx;
    ax = p_.hessian->times(x_);
    s_.bottomRows<3>() += t * ds;
    z_ += t * dz;
    residualLeft *= 1 - t * (1 - sigma);
  }
}

}  // namespace

HullResult minimizeInHull(const HullProblem& problem, NestedCholesky& factor, Eigen::VectorXd& x,
                          const HullOptions& options) {
  HullResult result;
  result.factors = 1;
  if (!factor.factor(*problem.hessian)) return result;
  const Eigen::VectorXd free = factor.solve(-problem.linear);
  if (problem.largestRatio(free) <= 1) {
    x = free;
    result.solved = true;
    result.value = 0.5 * x.dot(problem.linear);
    return result;
  }
  InteriorPoints method(problem, factor, x, options.firstGap);
  result = method.run(options);
  ++result.factors;
  x = method.x();
  return result;
}

}  // namespace strak
