#include "strak/fitting/prescribed_normals.h"

#include <fmt/format.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <numeric>

#include "strak/base/error.h"
#include "strak/fitting/net_forms.h"
#include "strak/metrology/closest_points.h"
#include "strak/spline/basis.h"
#include "strak/spline/evaluate.h"

namespace strak {

namespace {

constexpr double kDegree = std::numbers::pi / 180;
// A condition alone leaves this part of its residual after one solution: small enough that few multipliers do, large
// enough that the factor keeps its digits.
constexpr double kLeft = 1e-4;
constexpr double kStrongest = 1e9;  // the stiffness of the strongest condition, in parts of its control point's
constexpr int kMultipliers = 40;    // solutions with one factor
constexpr double kExact = 1e-14;    // of the size: points that stay
constexpr double kEnough = 0.5;     // of the wished angle
constexpr double kStalled = 0.97;   // a solution that leaves more of the largest angle gains nothing
constexpr int kDecades = 14;        // the weight falls where the surface crumples
// Turned tangent planes keep |n . n0| of their area. What is left of more than that must not be less.
constexpr double kCrumpled = 0.7;
constexpr double kNoPlane = 1e-9;     // sine between tangents that make no plane
constexpr double kHorizontal = 1e-6;  // third coordinate of a function's normal
constexpr double kSamePlace = 1e-9;   // of the domain
constexpr double kSettled = 1e-7;     // of the angles, radians

double angleBetween(const Eigen::Vector3d& a, const Eigen::Vector3d& b) {
  return std::atan2(a.cross(b).norm(), std::abs(a.dot(b)));
}

struct Tangents {
  Eigen::Vector3d u, v;
  Eigen::Vector3d normal() const { return u.cross(v); }
  bool plane() const { return normal().norm() > kNoPlane * u.norm() * v.norm(); }
};

class Prescription {
 public:
  Prescription(const Fit<2>& fit, const WishedNormals& wished, const NormalOptions& options);
  NormalFit run();

 private:
  std::vector<Tangents> tangents(const Net& net) const;
  void checkTangents();
  void checkContradictions() const;
  void findPlaces(const Net& net, bool first);
  void addConditions();
  void makeForms(const std::vector<Tangents>& hats);
  NetForm formAt(double u, double v, const Eigen::Matrix2d& factors, const Point& direction) const;
  double strongestWeight() const;
  Net turned(double scale, bool withMultipliers);
  bool crumpled(const std::vector<Tangents>& now) const;
  Eigen::VectorXd angles(const std::vector<Tangents>& at) const;
  // The weight of a normal's form, in parts of the mean.
  double share(std::size_t form) const { return weights_[static_cast<Index>(form / 2)] / weights_.mean(); }
  bool exact() const { return options_.weight == 0; }

  const Fit<2>& fit_;
  const NormalOptions& options_;
  const Surface& start_;
  const Index columns_;
  Net parameters_, places_;
  Eigen::Matrix<double, Eigen::Dynamic, 3> normals_;
  Eigen::VectorXd weights_;
  std::vector<Tangents> before_;  // of the start, at the present places
  std::vector<NetForm> forms_;    // two a normal, then those that hold points
  FormSystem system_;
  double area_ = 1, goal_ = 0, used_ = 0;
};

Prescription::Prescription(const Fit<2>& fit, const WishedNormals& wished, const NormalOptions& options)
    : fit_(fit),
      options_(options),
      start_(fit.spline),
      columns_(fit.spline.net().cols()),
      parameters_(wished.parameters),
      places_(wished.places),
      weights_(wished.weights),
      system_(fit.system, columns_, options.held) {
  if (start_.isRational() || (columns_ != 1 && columns_ != 3)) {
    throw InvalidInput("normals are prescribed to functions and to surfaces in space without weights");
  }
  const Index count = wished.normals.rows();
  if (count == 0) throw InvalidInput("there are no normals to prescribe");
  if (wished.normals.cols() != 3) throw InvalidInput("a normal needs three coordinates");
  if (places_.size() > 0 && (columns_ != 3 || places_.rows() != count || places_.cols() != 3)) {
    throw InvalidInput("the places of normals need a row of three coordinates each, and a surface in space");
  }
  if (parameters_.size() == 0 && places_.size() > 0) {
    if (!places_.allFinite()) throw InvalidInput("the place of a normal is not finite: correct or remove it");
  } else if (parameters_.rows() != count || parameters_.cols() != 2) {
    throw InvalidInput("every normal needs its two parameters, or a place in space");
  }
  if (weights_.size() == 0) weights_ = Eigen::VectorXd::Ones(count);
  if (weights_.size() != count || !weights_.allFinite() || weights_.minCoeff() < 0 || !(weights_.sum() > 0)) {
    throw InvalidInput("normals need finite weights that are not negative, and not all zero");
  }
  normals_.resize(count, 3);
  for (Index k = 0; k < count; ++k) {
    const double length = wished.normals.row(k).stableNorm();
    if (!(length > 0) || !std::isfinite(length)) {
      throw InvalidInput(fmt::format("normal {} is zero or not finite: correct or remove it", k + 1));
    }
    normals_.row(k) = wished.normals.row(k) / length;
    if (columns_ == 1 && !(std::abs(normals_(k, 2)) > kHorizontal)) {
      throw InvalidInput(fmt::format("normal {} is horizontal: the graph of a function is nowhere upright", k + 1));
    }
    if (parameters_.size() == 0) continue;
    for (int d = 0; d < 2; ++d) {
      const double at = parameters_(k, d);
      const KnotVector& knots = start_.knots(d);
      if (!(at >= knots.from() && at <= knots.to())) {
        throw InvalidInput(fmt::format("normal {} lies at {} = {:g}, outside the domain [{:g}, {:g}]", k + 1,
                                       directionName(d), at, knots.from(), knots.to()));
      }
    }
  }
  if (!(options.weight >= 0) || !std::isfinite(options.weight) || !(options.degrees > 0)) {
    throw InvalidInput("the weight of normals must be a finite number >= 0, and the wished angle positive");
  }
  goal_ = options.degrees * kDegree;
  for (const KnotVector& knots : scaledKnots<2>(start_, ParameterScale::lengths)) area_ *= knots.length();
}

std::vector<Tangents> Prescription::tangents(const Net& net) const {
  const Net jets = derivativesAt<2>(Surface(start_.knots(), net), parameters_, 1);
  std::vector<Tangents> result(static_cast<std::size_t>(jets.rows()));
  for (Index k = 0; k < jets.rows(); ++k) {
    Tangents& t = result[static_cast<std::size_t>(k)];
    if (columns_ == 1) {
      t = {{1, 0, jets(k, 1)}, {0, 1, jets(k, 2)}};
    } else {
      t = {jets.row(k).segment<3>(3).transpose(), jets.row(k).segment<3>(6).transpose()};
    }
  }
  return result;
}

// The rows are those of (5.15) with tangents of some surface: all must have a plane.
void Prescription::checkTangents() {
  before_ = tangents(start_.net());
  for (std::size_t k = 0; k < before_.size(); ++k) {
    if (before_[k].plane()) continue;
    throw InvalidInput(fmt::format("the surface has no tangent plane where normal {} is wished: ({:g}, {:g})", k + 1,
                                   parameters_(static_cast<Index>(k), 0), parameters_(static_cast<Index>(k), 1)));
  }
}

// Two normals at one place can only hold where the surface has none.
void Prescription::checkContradictions() const {
  std::vector<Index> order(static_cast<std::size_t>(normals_.rows()));
  std::iota(order.begin(), order.end(), 0);
  std::sort(order.begin(), order.end(), [&](Index a, Index b) { return parameters_(a, 0) < parameters_(b, 0); });
  const double nearU = kSamePlace * start_.knots(0).length(), nearV = kSamePlace * start_.knots(1).length();
  for (std::size_t i = 0; i < order.size(); ++i) {
    for (std::size_t j = i + 1; j < order.size() && parameters_(order[j], 0) - parameters_(order[i], 0) <= nearU; ++j) {
      const Index a = std::min(order[i], order[j]), b = std::max(order[i], order[j]);
      if (std::abs(parameters_(a, 1) - parameters_(b, 1)) > nearV || !(weights_[a] > 0 && weights_[b] > 0)) continue;
      const double angle = angleBetween(normals_.row(a).transpose(), normals_.row(b).transpose());
      if (angle <= 2 * goal_) continue;
      throw InvalidInput(
          fmt::format("normals {} and {} contradict one another: they are {:.3g} degrees apart at one place; remove "
                      "one, or give the normals a weight",
                      a + 1, b + 1, angle / kDegree));
    }
  }
}

void Prescription::findPlaces(const Net& net, bool first) {
  if (places_.size() == 0) return;
  const Surface surface(start_.knots(), net);
  parameters_ = first && parameters_.size() == 0 ? closestPoints<2>(surface, places_).parameters
                                                 : closestPointsFrom<2>(surface, places_, parameters_).parameters;
}

// The sum of factors(a, b) times the derivative of order a by u and b by v, along the direction.
NetForm Prescription::formAt(double u, double v, const Eigen::Matrix2d& factors, const Point& direction) const {
  const std::array<double, 2> at{u, v};
  std::array<Index, 2> first;
  std::array<Net, 2> basis;
  for (std::size_t d = 0; d < 2; ++d) {
    const KnotVector& knots = start_.knots()[d];
    const Index span = knots.findSpan(at[d]);
    first[d] = span - knots.degree();
    basis[d] = basisDerivatives(knots, span, at[d], 1);
  }
  return {first[0], first[1], basis[0].transpose() * factors * basis[1], direction};
}

// Points that stay: a form a coordinate.
void Prescription::addConditions() {
  if (options_.conditions.rows() > 0 && options_.conditions.cols() != 2) {
    throw InvalidInput("points that stay need two parameters each");
  }
  for (Index r = 0; r < options_.conditions.rows(); ++r) {
    for (Index c = 0; c < columns_; ++c) {
      Point direction = Point::Zero(columns_);
      direction[c] = 1;
      NetForm form = formAt(options_.conditions(r, 0), options_.conditions(r, 1),
                            Eigen::Vector2d(1, 0).asDiagonal().toDenseMatrix(), direction);
      const double strength = system_.strength(form);
      form.weight = strength > 0 ? 1 / (kLeft * strength) : 0;
      forms_.push_back(std::move(form));
    }
  }
}

void Prescription::makeForms(const std::vector<Tangents>& hats) {
  forms_.clear();
  for (Index k = 0; k < normals_.rows(); ++k) {
    const Tangents& hat = hats[static_cast<std::size_t>(k)];
    const Tangents& start = before_[static_cast<std::size_t>(k)];
    const Eigen::Vector3d n = normals_.row(k).transpose();
    const Point direction = columns_ == 1 ? Point(Point::Constant(1, n[2])) : Point(n.transpose());
    const double a = 1 / hat.u.norm(), b = 1 / hat.v.norm();
    for (const double sign : {1.0, -1.0}) {
      const double length = (a * hat.u + sign * b * hat.v).norm();
      Eigen::Matrix2d factors;
      factors << 0, sign * b / length, a / length, 0;
      forms_.push_back(formAt(parameters_(k, 0), parameters_(k, 1), factors, direction));
      forms_.back().offset = n.dot(factors(1, 0) * start.u + factors(0, 1) * start.v);
    }
  }
  addConditions();
}

// The weight with which every normal alone would be left kLeft of its angle, at most.
double Prescription::strongestWeight() const {
  double least = std::numeric_limits<double>::infinity(), most = 0;
  for (std::size_t k = 0; k < static_cast<std::size_t>(2 * normals_.rows()); ++k) {
    const double strength = share(k) * system_.strength(forms_[k]);
    if (!(strength > 0)) continue;
    least = std::min(least, strength);
    most = std::max(most, strength);
  }
  return most > 0 ? std::min(1 / (kLeft * least), kStrongest / most) : 0;
}

// The change of the net that costs least with this weight; with multipliers that make the planes hold, and without
// only near to them. Empty if the weight is more than the factor's digits bear.
Net Prescription::turned(double scale, bool withMultipliers) {
  const auto ofNormals = static_cast<std::size_t>(2 * normals_.rows());
  for (std::size_t k = 0; k < ofNormals; ++k) forms_[k].weight = scale * share(k);
  if (!system_.factor(forms_)) return Net();
  std::vector<double> multipliers(forms_.size(), 0.0);
  Net change;
  double last = std::numeric_limits<double>::infinity();
  for (int round = 0; round < kMultipliers; ++round) {
    change = system_.solve(forms_, multipliers);
    double largest = 0, apart = 0;  // of the normals and of the points that stay
    for (std::size_t k = 0; k < forms_.size(); ++k) {
      const double left = valueOf(forms_[k], change, start_.size(1));
      if (k >= ofNormals || withMultipliers) multipliers[k] += left;
      double& most = k < ofNormals ? largest : apart;
      if (forms_[k].weight > 0) most = std::max(most, std::abs(left));
    }
    // The forms' values are sines while the lengths of the tangents stay: half of the angle leaves room for those.
    const bool enough = !withMultipliers || largest < kEnough * goal_ || largest > kStalled * last;
    if (enough && apart <= kExact * start_.net().cwiseAbs().maxCoeff()) break;
    last = largest;
  }
  return change;
}

// Whether tangent planes have vanished rather than turned.
bool Prescription::crumpled(const std::vector<Tangents>& now) const {
  if (columns_ == 1) return false;
  for (std::size_t k = 0; k < now.size(); ++k) {
    const double kept = std::abs(before_[k].normal().dot(normals_.row(static_cast<Index>(k)).transpose()));
    if (weights_[static_cast<Index>(k)] > 0 && !(now[k].normal().norm() >= kCrumpled * kept && now[k].plane())) {
      return true;
    }
  }
  return false;
}

Eigen::VectorXd Prescription::angles(const std::vector<Tangents>& at) const {
  Eigen::VectorXd result(normals_.rows());
  for (Index k = 0; k < normals_.rows(); ++k) {
    const Tangents& t = at[static_cast<std::size_t>(k)];
    result[k] = t.plane() ? angleBetween(t.normal(), normals_.row(k).transpose()) : std::numbers::pi / 2;
  }
  return result;
}

NormalFit Prescription::run() {
  NormalFit result;
  const Net& net = start_.net();
  findPlaces(net, true);
  checkTangents();
  if (exact()) checkContradictions();
  const auto largestOf = [this](const Eigen::VectorXd& a) {
    return (weights_.array() > 0).select(a.array(), 0.0).maxCoeff();
  };
  Net change = Net::Zero(net.rows(), columns_);
  Eigen::VectorXd now = angles(before_);
  result.anglesBefore = now / kDegree;
  std::vector<Tangents> reached = before_;
  result.stop = NormalStop::met;
  const auto count = static_cast<double>(normals_.rows());
  double soft = options_.weight * area_ / count;
  bool whole = true;
  bool going = !exact() || largestOf(now) > goal_;
  while (going) {
    if (result.rounds == options_.rounds) {
      result.stop = NormalStop::rounds;
      break;
    }
    if (!options_.progress.report(static_cast<double>(result.rounds) / options_.rounds, "turning the normals")) {
      result.stop = NormalStop::cancelled;
      break;
    }
    makeForms(reached);
    double scale = exact() ? strongestWeight() : soft;
    Net tried = scale > 0 ? turned(scale, exact()) : change;
    std::vector<Tangents> at = tried.size() > 0 ? tangents(net + tried) : before_;
    for (int k = 0; k < kDecades && (tried.size() == 0 || crumpled(at)); ++k) {
      whole = false;
      soft = scale /= 10;
      tried = turned(scale, false);
      if (tried.size() > 0) at = tangents(net + tried);
    }
    if (tried.size() == 0) {
      throw Failure("the weight of the normals leaves the fit no digits: give a smaller weight");
    }
    change = std::move(tried);
    used_ = scale * count / area_;
    ++result.rounds;
    findPlaces(net + change, false);
    if (places_.size() > 0) checkTangents();
    reached = tangents(net + change);
    const Eigen::VectorXd before = now;
    now = angles(reached);
    if (exact()) {
      const bool met = largestOf(now) <= goal_;
      // What is linear is solved at once; only places that move along the surface need rounds.
      going =
          !met && whole && places_.size() > 0 && (result.rounds == 1 || largestOf(now) < kStalled * largestOf(before));
      if (!met && !going) result.stop = NormalStop::contradictory;
    } else {
      going = !((now - before).cwiseAbs().maxCoeff() <= kSettled);
      if (!going) result.stop = whole ? NormalStop::settled : NormalStop::contradictory;
    }
  }
  Net turnedNet = net + change;
  // What is held is held to the bit.
  for (Index r : options_.held) turnedNet.row(r) = net.row(r);
  result.fit = fit_;
  result.fit.spline = Surface(start_.knots(), std::move(turnedNet));
  result.energyBefore = fit_.summary.energy;
  const Net& after = result.fit.spline.net();
  result.fit.summary.energy = after.cwiseProduct(fit_.energy.times(after)).sum();
  result.parameters = parameters_;
  result.angles = now / kDegree;
  const auto counted = (weights_.array() > 0).select(result.angles.array(), 0.0);
  result.largest = counted.maxCoeff(&result.worst);
  result.rms = std::sqrt(weights_.dot(now.cwiseAbs2()) / weights_.sum()) / kDegree;
  result.weight = used_;
  Index behind = 0;
  for (Index k = 0; k < normals_.rows(); ++k) {
    behind += reached[static_cast<std::size_t>(k)].normal().dot(normals_.row(k).transpose()) < 0;
  }
  result.opposite = std::min(behind, normals_.rows() - behind);
  return result;
}

}  // namespace

const char* normalStopName(NormalStop stop) {
  switch (stop) {
    case NormalStop::met:
      return "met";
    case NormalStop::settled:
      return "settled";
    case NormalStop::contradictory:
      return "contradictory";
    case NormalStop::rounds:
      return "rounds";
    case NormalStop::cancelled:
      return "cancelled";
  }
  return "";
}

NormalFit prescribeNormals(const Fit<2>& fit, const WishedNormals& wished, const NormalOptions& options) {
  return Prescription(fit, wished, options).run();
}

Fit<2> fitOfSurface(const Surface& surface, double smoothing) {
  if (surface.isRational()) {
    throw InvalidInput("the surface is rational: normals are prescribed to surfaces without weights");
  }
  if (!(smoothing >= 0) || !std::isfinite(smoothing)) {
    throw InvalidInput("the smoothing weight must be a finite number that is not negative");
  }
  const std::array<KnotVector, 2> knots = normalisedKnots<2>(surface, ParameterScale::lengths);
  const QuadraticEnergy<2> energy = fitEnergy<2>(knots);
  Fit<2> fit;
  fit.spline = surface;
  fit.energy = energyMatrixOf<2>(energy, knots);
  fit.system = combined(energyMatrixOf<2>({"mean square", {{1, {}, {}}}}, knots), smoothing, fit.energy);
  fit.summary.energyName = energy.name;
  fit.summary.lambda = smoothing;
  fit.summary.energy = surface.net().cwiseProduct(fit.energy.times(surface.net())).sum();
  return fit;
}

double naturalSmoothing(const Surface& surface) {
  double cells = 1;
  for (const KnotVector& knots : surface.knots()) cells *= static_cast<double>(knots.spans().size());
  return std::pow(cells, -fitEnergy<2>(surface.knots()).order());
}

}  // namespace strak
