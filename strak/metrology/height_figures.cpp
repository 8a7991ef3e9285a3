#include "strak/metrology/height_figures.h"

#include <Eigen/QR>
#include <cmath>

#include "strak/base/error.h"

namespace strak {

namespace {

constexpr int kHighestDegree = 8;
constexpr int kMostSteps = 100;
constexpr double kSettled = 1e-14;  // of the radius
constexpr double kLargest = 1e8;    // radius of a sphere that is told from a plane, in sizes of the points
constexpr Index kBlock = 4096;      // points whose terms are kept at once

void check(const Eigen::Ref<const Net>& points) {
  if (points.cols() != 2 && points.cols() != 3) throw InvalidInput("figures of heights need two or three columns");
  if (points.rows() < 1) throw InvalidInput("there is no point to take figures of");
  if (!points.allFinite()) throw InvalidInput("a coordinate is not a finite number: leave the point out");
}

void measure(HeightFigures& figures) {
  const Eigen::VectorXd& r = figures.residuals;
  figures.peakToValley = r.maxCoeff() - r.minCoeff();
  figures.rms = std::sqrt(r.squaredNorm() / static_cast<double>(r.size()));
}

// Coordinates from -1 to 1: (points - middle) / half.
struct Box {
  Point middle, half;
  explicit Box(const Eigen::Ref<const Net>& points) {
    const Point low = points.colwise().minCoeff(), high = points.colwise().maxCoeff();
    middle = low + (high - low) / 2;
    half = (high - low) / 2;
    for (Index c = 0; c < half.size(); ++c) {
      if (!(half[c] > 0)) half[c] = 1;
    }
  }
};

// Products of powers up to the total degree at some points, a row each.
Eigen::MatrixXd termsAt(const Eigen::Ref<const Net>& places, const Box& box, int degree) {
  const bool two = places.cols() == 2;
  const Index count = two ? (degree + 1) * (degree + 2) / 2 : degree + 1;
  Eigen::MatrixXd terms(places.rows(), count);
  for (Index r = 0; r < places.rows(); ++r) {
    const double x = (places(r, 0) - box.middle[0]) / box.half[0],
                 y = two ? (places(r, 1) - box.middle[1]) / box.half[1] : 0;
    Index k = 0;
    double powerX = 1;
    for (int i = 0; i <= degree; ++i, powerX *= x) {
      double term = powerX;
      for (int j = 0; j <= (two ? degree - i : 0); ++j, term *= y) terms(r, k++) = term;
    }
  }
  return terms;
}

}  // namespace

HeightFigures figuresWithoutPolynomial(const Eigen::Ref<const Net>& points, int degree) {
  check(points);
  if (degree < 0 || degree > kHighestDegree) throw InvalidInput("the degree of what is removed must be 0 to 8");
  const Index rows = points.rows(), last = points.cols() - 1;
  const auto places = points.leftCols(last);
  const Box box(places);
  HeightFigures figures;
  figures.residuals = points.col(last);
  // The second time the errors of the first are what is fitted.
  for (int pass = 0; pass < 2; ++pass) {
    Eigen::MatrixXd normal;
    Eigen::VectorXd right;
    for (Index begin = 0; begin < rows; begin += kBlock) {
      const Index count = std::min(kBlock, rows - begin);
      const Eigen::MatrixXd terms = termsAt(places.middleRows(begin, count), box, degree);
      if (begin == 0) {
        normal = Eigen::MatrixXd::Zero(terms.cols(), terms.cols());
        right = Eigen::VectorXd::Zero(terms.cols());
      }
      normal += terms.transpose() * terms;
      right += terms.transpose() * figures.residuals.segment(begin, count);
    }
    const Eigen::VectorXd coefficients = normal.completeOrthogonalDecomposition().solve(right);
    for (Index begin = 0; begin < rows; begin += kBlock) {
      const Index count = std::min(kBlock, rows - begin);
      figures.residuals.segment(begin, count) -= termsAt(places.middleRows(begin, count), box, degree) * coefficients;
    }
  }
  measure(figures);
  return figures;
}

HeightFigures figuresWithoutSphere(const Eigen::Ref<const Net>& points) {
  check(points);
  const char* none = "the points do not determine a sphere or circle: they are too few, or lie in a plane or on a line";
  const Index n = points.rows(), columns = points.cols();
  if (n <= columns) throw InvalidInput(none);
  const Box box(points);
  const double size = box.half.maxCoeff();
  const Net own = (points.rowwise() - box.middle) / size;
  // |p|^2 = 2 p.c + (R^2 - |c|^2): linear, and near enough for a start.
  Eigen::MatrixXd system(n, columns + 1);
  system.leftCols(columns) = 2 * own;
  system.col(columns).setOnes();
  const Eigen::ColPivHouseholderQR<Eigen::MatrixXd> algebraic(system);
  if (algebraic.rank() <= columns) throw InvalidInput(none);
  const Eigen::VectorXd start = algebraic.solve(own.rowwise().squaredNorm());
  Eigen::RowVectorXd centre = start.head(columns).transpose();
  double radius = std::sqrt(std::max(start[columns] + centre.squaredNorm(), 0.0));
  Eigen::VectorXd distances;
  for (int step = 0; step < kMostSteps; ++step) {
    if (!(radius > 0 && radius < kLargest)) throw InvalidInput(none);
    const Net from = own.rowwise() - centre;
    distances = from.rowwise().norm();
    system.leftCols(columns) = -(from.array().colwise() / distances.array().max(1e-300)).matrix();
    system.col(columns).setConstant(-1);
    const Eigen::VectorXd move = system.colPivHouseholderQr().solve(-(distances.array() - radius).matrix());
    centre += move.head(columns).transpose();
    radius += move[columns];
    if (move.norm() <= kSettled * radius) break;
  }
  if (!(radius > 0 && radius < kLargest)) throw InvalidInput(none);
  HeightFigures figures;
  figures.residuals = size * ((own.rowwise() - centre).rowwise().norm().array() - radius).matrix();
  figures.centre = box.middle + size * centre;
  figures.radius = size * radius;
  measure(figures);
  return figures;
}

}  // namespace strak
