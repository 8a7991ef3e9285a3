#include "strak/energy/curve_energy.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <numeric>

#include "strak/base/error.h"
#include "strak/spline/basis.h"

namespace strak {

namespace {

// A number with its derivatives by N variables.
template <int N>
struct Dual {
  double v = 0;
  Eigen::Matrix<double, N, 1> d = Eigen::Matrix<double, N, 1>::Zero();

  static Dual variable(double value, int number) {
    Dual x;
    x.v = value;
    x.d[number] = 1;
    return x;
  }
  friend Dual operator+(const Dual& a, const Dual& b) { return {a.v + b.v, a.d + b.d}; }
  friend Dual operator-(const Dual& a, const Dual& b) { return {a.v - b.v, a.d - b.d}; }
  friend Dual operator*(const Dual& a, const Dual& b) { return {a.v * b.v, a.v * b.d + b.v * a.d}; }
  friend Dual operator/(const Dual& a, const Dual& b) {
    const double q = a.v / b.v;
    return {q, (a.d - q * b.d) / b.v};
  }
  friend Dual operator*(double a, const Dual& b) { return {a * b.v, a * b.d}; }
};

template <int N>
Dual<N> sqrt(const Dual<N>& a) {
  const double root = std::sqrt(a.v);
  return {root, a.d / (2 * root)};
}

double sqrt(double x) { return std::sqrt(x); }
double value(double x) { return x; }
template <int N>
double value(const Dual<N>& x) {
  return x.v;
}

template <class T, int Dim>
using Vec = std::array<T, Dim>;

template <class T, std::size_t Dim>
T dot(const std::array<T, Dim>& a, const std::array<T, Dim>& b) {
  T sum = a[0] * b[0];
  for (std::size_t k = 1; k < Dim; ++k) sum = sum + a[k] * b[k];
  return sum;
}

template <class T>
T cross(const std::array<T, 2>& a, const std::array<T, 2>& b) {
  return a[0] * b[1] - a[1] * b[0];
}

// The part of a across v.
template <class T>
std::array<T, 3> across(const std::array<T, 3>& a, const std::array<T, 3>& v, const T& vv) {
  const T along = dot(a, v) / vv;
  return {a[0] - along * v[0], a[1] - along * v[1], a[2] - along * v[2]};
}

// K in the plane (one number) and in space (three).
template <class T>
std::array<T, 1> curvature(const std::array<T, 2>& v, const std::array<T, 2>& a) {
  const T vv = dot(v, v);
  return {cross(v, a) / (vv * sqrt(vv))};
}
template <class T>
std::array<T, 3> curvature(const std::array<T, 3>& v, const std::array<T, 3>& a) {
  const T vv = dot(v, v);
  auto k = across(a, v, vv);
  for (T& x : k) x = x / vv;
  return k;
}

// D_s K. With s = |X'|: the part of (X''' - 3 (X'.X'') / s^2 X'') across X', over s^3.
template <class T>
std::array<T, 1> variation(const std::array<T, 2>& v, const std::array<T, 2>& a, const std::array<T, 2>& j) {
  const T vv = dot(v, v);
  return {(cross(v, j) - 3.0 * (dot(v, a) / vv) * cross(v, a)) / (vv * vv)};
}
template <class T>
std::array<T, 3> variation(const std::array<T, 3>& v, const std::array<T, 3>& a, const std::array<T, 3>& j) {
  const T vv = dot(v, v), stretch = 3.0 * (dot(v, a) / vv);
  std::array<T, 3> q{j[0] - stretch * a[0], j[1] - stretch * a[1], j[2] - stretch * a[2]};
  q = across(q, v, vv);
  const T cube = vv * sqrt(vv);
  for (T& x : q) x = x / cube;
  return q;
}

// dk/ds from K and D_s K.
template <class T>
T slope(const std::array<T, 1>&, const std::array<T, 1>& change) {
  return change[0];
}
template <class T>
T slope(const std::array<T, 3>& k, const std::array<T, 3>& change) {
  const T kk = dot(k, k);
  if (!(value(kk) > 0)) return T{};
  return dot(k, change) / sqrt(kk);
}

template <class T>
T sum2(const std::array<T, 1>& a) {
  return a[0] * a[0];
}
template <class T>
T sum2(const std::array<T, 3>& a) {
  return dot(a, a);
}

template <int Dim>
std::array<Vec<double, Dim>, 3> plainJet(const Eigen::Matrix3d& jet) {
  std::array<Vec<double, Dim>, 3> rows{};
  for (std::size_t r = 0; r < 3; ++r) {
    for (std::size_t c = 0; c < Dim; ++c) rows[r][c] = jet(static_cast<Index>(r), static_cast<Index>(c));
  }
  return rows;
}

template <int Dim>
std::array<Vec<Dual<3 * Dim>, Dim>, 3> dualJet(const Eigen::Matrix3d& jet) {
  std::array<Vec<Dual<3 * Dim>, Dim>, 3> rows;
  for (std::size_t r = 0; r < 3; ++r) {
    for (std::size_t c = 0; c < Dim; ++c) {
      const int number = static_cast<int>(r * Dim + c);
      rows[r][c] = Dual<3 * Dim>::variable(jet(static_cast<Index>(r), static_cast<Index>(c)), number);
    }
  }
  return rows;
}

// Rows 0 to 3: the rational basis functions of a span and their derivatives.
Eigen::MatrixXd basisAt(const Curve& curve, Index span, double u) {
  const int p = curve.degree(0);
  Eigen::MatrixXd n = basisDerivatives(curve.knots(0), span, u, 3);
  if (!curve.isRational()) return n;
  const Eigen::RowVectorXd weights = curve.net().col(curve.net().cols() - 1).segment(span - p, p + 1).transpose();
  n = n.array().rowwise() * weights.array();
  const Eigen::VectorXd w = n.rowwise().sum();
  n.row(0) /= w[0];
  n.row(1) = (n.row(1) - w[1] * n.row(0)) / w[0];
  n.row(2) = (n.row(2) - 2 * w[1] * n.row(1) - w[2] * n.row(0)) / w[0];
  n.row(3) = (n.row(3) - 3 * w[1] * n.row(2) - 3 * w[2] * n.row(1) - w[3] * n.row(0)) / w[0];
  return n;
}

// Derivatives of the basis by the unknowns instead of the control points first, first + 1, ...
struct Reduced {
  std::vector<int> points;
  std::vector<std::pair<Index, std::pair<Index, double>>> entries;  // (function, (column, coefficient))

  Reduced(const PointMap& map, const std::vector<Index>& controlPoints) {
    for (const Index i : controlPoints) {
      for (const auto& [unknown, factor] : map.rows[static_cast<std::size_t>(i)])
        points.push_back(static_cast<int>(unknown));
    }
    std::sort(points.begin(), points.end());
    points.erase(std::unique(points.begin(), points.end()), points.end());
    for (std::size_t f = 0; f < controlPoints.size(); ++f) {
      for (const auto& [unknown, factor] : map.rows[static_cast<std::size_t>(controlPoints[f])]) {
        const Index column = std::lower_bound(points.begin(), points.end(), unknown) - points.begin();
        entries.push_back({static_cast<Index>(f), {column, factor}});
      }
    }
  }

  Eigen::MatrixXd operator()(const Eigen::MatrixXd& basis) const {
    Eigen::MatrixXd result = Eigen::MatrixXd::Zero(basis.rows(), static_cast<Index>(points.size()));
    for (const auto& [function, entry] : entries) result.col(entry.first) += entry.second * basis.col(function);
    return result;
  }
};

std::vector<Index> range(Index first, Index count) {
  std::vector<Index> numbers(static_cast<std::size_t>(count));
  std::iota(numbers.begin(), numbers.end(), first);
  return numbers;
}

Eigen::Matrix3d jetOf(const Eigen::MatrixXd& threeRows, const Net& points) {
  Eigen::Matrix3d jet = Eigen::Matrix3d::Zero();
  jet.leftCols(points.cols()) = threeRows * points;
  return jet;
}

}  // namespace

Net PointMap::apply(const Eigen::VectorXd& y) const {
  Net result = Net::Zero(static_cast<Index>(rows.size()), 3);
  for (std::size_t i = 0; i < rows.size(); ++i) {
    for (const auto& [unknown, factor] : rows[i]) {
      result.row(static_cast<Index>(i)) += factor * y.segment<3>(3 * unknown).transpose();
    }
  }
  return result;
}

CurveEnergy::CurveEnergy(const Curve& reference, const PointMap& map, bool closed)
    : dimension_(static_cast<int>(reference.pointDimension())) {
  const KnotVector& knots = reference.knots(0);
  const int p = knots.degree();
  if (dimension_ != 2 && dimension_ != 3)
    throw InvalidInput("exact curve energies need a curve of the plane or of space");
  if (p < 2) throw InvalidInput("a curve of degree 1 has no curvature to make fair: raise its degree to 3 first");
  const Net points = reference.euclideanNet();
  const GaussRule rule = gaussLegendre(p + 2);
  const auto spans = knots.spans();
  std::vector<double> lengths;
  for (const Index span : spans) {
    const Reduced reduced(map, range(span - p, p + 1));
    Element element{reduced.points, {}, parameters_.size(), false};
    const double half = (knots[span + 1] - knots[span]) / 2, middle = std::midpoint(knots[span], knots[span + 1]);
    double spanLength = 0;
    for (std::size_t q = 0; q < rule.nodes.size(); ++q) {
      const double u = middle + half * rule.nodes[q];
      const Eigen::MatrixXd basis = basisAt(reference, span, u).bottomRows(3);
      Place place;
      place.weight = rule.weights[q] * half;
      place.basis = reduced(basis);
      place.jet = jetOf(basis, points.middleRows(span - p, p + 1));
      place.speed = place.jet.row(0).norm();
      spanLength += place.weight * place.speed;
      parameters_.push_back(u);
      element.places.push_back(std::move(place));
    }
    lengths.push_back(spanLength);
    length_ += spanLength;
    elements_.push_back(std::move(element));
  }
  for (Element& element : elements_) {
    for (Place& place : element.places) {
      const Eigen::Vector3d v = place.jet.row(0).transpose(), a = place.jet.row(1).transpose();
      const double vv = v.squaredNorm();
      if (!(vv > 0)) continue;
      const double k = v.cross(a).norm() / (vv * place.speed);
      place.scale = k * k + 1 / (length_ * length_);
      place.slide = v / (vv * place.speed);
      place.slideChange = (a / vv - 2 * v * v.dot(a) / (vv * vv)) / place.speed;
    }
  }
  signs_.assign(parameters_.size(), 0);
  for (std::size_t s = 0; s + 1 < spans.size(); ++s) {
    if (spans[s + 1] - spans[s] != p - 1) continue;
    addJump(reference, map, spans[s], spans[s + 1]);
    elements_.back().places[0].weight = 2 / (lengths[s] + lengths[s + 1]);
  }
  if (closed) {
    addJump(reference, map, spans.back(), spans.front());
    elements_.back().places[0].weight = 2 / (lengths.back() + lengths.front());
  }
}

void CurveEnergy::addJump(const Curve& reference, const PointMap& map, Index left, Index right) {
  const KnotVector& knots = reference.knots(0);
  const int p = knots.degree();
  auto controlPoints = range(left - p, p + 1);
  const auto more = range(right - p, p + 1);
  controlPoints.insert(controlPoints.end(), more.begin(), more.end());
  const Eigen::MatrixXd before = basisAt(reference, left, knots[left + 1]),
                        after = basisAt(reference, right, knots[right]);
  Eigen::MatrixXd basis = Eigen::MatrixXd::Zero(3, 2 * (p + 1));
  // One tangent for both sides (they have the same): the mean.
  basis.row(0) << before.row(1) / 2, after.row(1) / 2;
  basis.row(1).head(p + 1) = before.row(2);
  basis.row(2).tail(p + 1) = after.row(2);
  const Reduced reduced(map, controlPoints);
  Net points(2 * (p + 1), dimension_);
  points << reference.euclideanNet().middleRows(left - p, p + 1), reference.euclideanNet().middleRows(right - p, p + 1);
  Place place;
  place.basis = reduced(basis);
  place.jet = jetOf(basis, points);
  Element element{reduced.points, {}, 0, true};
  element.places.push_back(std::move(place));
  elements_.push_back(std::move(element));
}

std::vector<std::vector<int>> CurveEnergy::cliques() const {
  std::vector<std::vector<int>> result;
  for (const Element& element : elements_) result.push_back(element.points);
  return result;
}

Eigen::Matrix3d CurveEnergy::jetAt(const Element& element, const Place& place, const Eigen::VectorXd& y) {
  Eigen::Matrix3d jet = place.jet;
  for (std::size_t k = 0; k < element.points.size(); ++k) {
    jet += place.basis.col(static_cast<Index>(k)) * y.segment<3>(3 * element.points[k]).transpose();
  }
  return jet;
}

template <int Dim>
CurveEnergyValues CurveEnergy::valuesIn(const Eigen::VectorXd& y) const {
  CurveEnergyValues sum;
  for (const Element& element : elements_) {
    for (std::size_t q = 0; q < element.places.size(); ++q) {
      const Place& place = element.places[q];
      const Eigen::Matrix3d full = jetAt(element, place, y);
      const auto jet = plainJet<Dim>(full);
      if (element.jump) {
        auto jump = curvature(jet[0], jet[1]);
        const auto other = curvature(jet[0], jet[2]);
        for (std::size_t c = 0; c < jump.size(); ++c) jump[c] -= other[c];
        sum.variation += place.weight * sum2(jump);
        continue;
      }
      const double ds = place.weight * std::sqrt(dot(jet[0], jet[0]));
      const auto k = curvature(jet[0], jet[1]);
      const auto change = variation(jet[0], jet[1], jet[2]);
      sum.bending += ds * sum2(k);
      sum.variation += ds * sum2(change);
      const double slide = full.row(1).dot(place.slide) + full.row(0).dot(place.slideChange);
      sum.sliding += place.weight * place.speed * slide * slide;
      const int sign = signs_[element.first + q];
      const double wrong = -sign * slope(k, change) / place.scale;
      if (wrong > 0) sum.wrongWay += place.weight * place.speed * wrong * wrong;
    }
  }
  const double all = sum.bending + sum.variation + sum.sliding + sum.wrongWay;
  if (!std::isfinite(all)) {
    constexpr double kBad = std::numeric_limits<double>::infinity();
    return {kBad, kBad, kBad, kBad};
  }
  return sum;
}

CurveEnergyValues CurveEnergy::values(const Eigen::VectorXd& y) const {
  return dimension_ == 2 ? valuesIn<2>(y) : valuesIn<3>(y);
}

template <int Dim>
void CurveEnergy::linearizeIn(const Eigen::VectorXd& y, const CurveEnergyValues& weights, BlockMatrix& h,
                              Eigen::VectorXd& gradient) const {
  constexpr int kVariables = 3 * Dim;
  using D = Dual<kVariables>;
  using Matrix = Eigen::Matrix<double, kVariables, kVariables>;
  using Vector = Eigen::Matrix<double, kVariables, 1>;
  using Block = Eigen::Matrix<double, Dim, Dim>;
  h.setZero();
  gradient = Eigen::VectorXd::Zero(3 * h.size());
  Matrix outer;
  Vector slant;
  const auto add = [&](double weight, const D& residual) {
    outer.noalias() += (2 * weight) * residual.d * residual.d.transpose();
    slant += (2 * weight * residual.v) * residual.d;
  };
  std::vector<double*> blocks;  // of the element's pairs, row by row of the lower triangle
  for (const Element& element : elements_) {
    const auto count = static_cast<Index>(element.points.size());
    if (count == 0) continue;
    blocks.clear();
    for (Index i = 0; i < count; ++i) {
      for (Index j = 0; j <= i; ++j) {
        blocks.push_back(
            h.block(element.points[static_cast<std::size_t>(i)], element.points[static_cast<std::size_t>(j)]));
      }
    }
    for (std::size_t q = 0; q < element.places.size(); ++q) {
      const Place& place = element.places[q];
      const Eigen::Matrix3d full = jetAt(element, place, y);
      const auto jet = dualJet<Dim>(full);
      outer.setZero();
      slant.setZero();
      if (element.jump) {
        auto jump = curvature(jet[0], jet[1]);
        const auto other = curvature(jet[0], jet[2]);
        for (std::size_t c = 0; c < jump.size(); ++c) add(weights.variation * place.weight, jump[c] - other[c]);
      } else {
        const D root = sqrt(sqrt(dot(jet[0], jet[0])));
        const auto k = curvature(jet[0], jet[1]);
        const auto change = variation(jet[0], jet[1], jet[2]);
        for (std::size_t c = 0; c < k.size(); ++c) {
          add(weights.bending * place.weight, root * k[c]);
          add(weights.variation * place.weight, root * change[c]);
        }
        D slide;
        slide.v = full.row(1).dot(place.slide) + full.row(0).dot(place.slideChange);
        slide.d.template segment<Dim>(0) = place.slideChange.template head<Dim>();
        slide.d.template segment<Dim>(Dim) = place.slide.template head<Dim>();
        add(weights.sliding * place.weight * place.speed, slide);
        const int sign = signs_[element.first + q];
        if (sign != 0 && weights.wrongWay > 0 && place.scale > 0) {
          const D wrong = (-sign / place.scale) * slope(k, change);
          if (wrong.v > 0) add(weights.wrongWay * place.weight * place.speed, wrong);
        }
      }
      // Derivative r of point i contributes basis(r, i): chain rule in both arguments.
      for (Index j = 0; j < count; ++j) {
        std::array<Block, 3> half;
        for (int r = 0; r < 3; ++r) {
          half[static_cast<std::size_t>(r)] = place.basis(0, j) * outer.template block<Dim, Dim>(r * Dim, 0) +
                                              place.basis(1, j) * outer.template block<Dim, Dim>(r * Dim, Dim) +
                                              place.basis(2, j) * outer.template block<Dim, Dim>(r * Dim, 2 * Dim);
        }
        for (Index i = j; i < count; ++i) {
          Eigen::Map<Eigen::Matrix<double, 3, 3, Eigen::RowMajor>>(
              blocks[static_cast<std::size_t>(i * (i + 1) / 2 + j)])
              .template topLeftCorner<Dim, Dim>() +=
              place.basis(0, i) * half[0] + place.basis(1, i) * half[1] + place.basis(2, i) * half[2];
        }
        gradient.segment<Dim>(3 * element.points[static_cast<std::size_t>(j)]) +=
            place.basis(0, j) * slant.template segment<Dim>(0) + place.basis(1, j) * slant.template segment<Dim>(Dim) +
            place.basis(2, j) * slant.template segment<Dim>(2 * Dim);
      }
    }
  }
}

void CurveEnergy::linearize(const Eigen::VectorXd& y, const CurveEnergyValues& weights, BlockMatrix& h,
                            Eigen::VectorXd& gradient) const {
  if (dimension_ == 3) {
    linearizeIn<3>(y, weights, h, gradient);
    return;
  }
  linearizeIn<2>(y, weights, h, gradient);
  for (int i = 0; i < static_cast<int>(h.size()); ++i) {
    double* diagonal = h.block(i, i);
    diagonal[8] = (diagonal[0] + diagonal[4]) / 2;
  }
}

}  // namespace strak
