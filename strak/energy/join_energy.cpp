#include "strak/energy/join_energy.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>

#include "strak/base/error.h"
#include "strak/spline/basis.h"
#include "strak/spline/rational.h"

namespace strak {

namespace {

using RowMatrix = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>;
using Derivatives = Eigen::Matrix<double, 5, 3, Eigen::RowMajor>;  // T, C, TT, TC, CC

constexpr double kAngle = 12 * 400;  // see the header

// What one bank contributes at a point of the line: the unit normal, the unit direction across, the curvature across,
// and how they change with the derivatives.
struct Bank {
  Eigen::Vector3d t, c, n, across;
  double normalLength = 0, acrossLength = 0, curvature = 0;
  Derivatives byCurvature;
  bool regular = false;

  explicit Bank(const Derivatives& x) {
    t = x.row(0);
    c = x.row(1);
    const Eigen::Vector3d normal = t.cross(c);
    normalLength = normal.norm();
    const double e = t.squaredNorm(), f = t.dot(c), g = c.squaredNorm(), det = e * g - f * f;
    regular = det > 1e-20 * e * g && e > 0;
    if (!regular) return;
    n = normal / normalLength;
    const double k = f / e;
    across = c - k * t;
    acrossLength = across.norm();
    across /= acrossLength;
    // kappa = q e / det^(3/2), q = N . w, w = X_cc - 2 k X_tc + k^2 X_tt.
    const Eigen::Vector3d tt = x.row(2), tc = x.row(3), cc = x.row(4);
    const Eigen::Vector3d w = cc - 2 * k * tc + k * k * tt;
    const double q = normal.dot(w), root = std::pow(det, -1.5);
    curvature = q * e * root;
    const double byK = normal.dot(2 * k * tt - 2 * tc);
    // dk = (dt . c + t . dc) / e - 2 k (t . dt) / e; ddet = g de + e dg - 2 f df.
    const double byQ = e * root, byE = q * root, byDet = -1.5 * q * e * root / det;
    const Eigen::Vector3d kByT = (c - 2 * k * t) / e, kByC = t / e;
    byCurvature.row(0) = byQ * (c.cross(w) + byK * kByT) + 2 * byE * t + byDet * 2 * (g * t - f * c);
    byCurvature.row(1) = byQ * (w.cross(t) + byK * kByC) + byDet * 2 * (e * c - f * t);
    byCurvature.row(2) = byQ * k * k * normal;
    byCurvature.row(3) = -2 * byQ * k * normal;
    byCurvature.row(4) = byQ * normal;
  }

  // The derivative of n . y by t and c, y fixed.
  void normalBy(const Eigen::Vector3d& y, Derivatives& d) const {
    const Eigen::Vector3d p = (y - y.dot(n) * n) / normalLength;
    d.setZero();
    d.row(0) = c.cross(p);
    d.row(1) = p.cross(t);
  }
  // The derivative of across . y by t and c, y fixed.
  void acrossBy(const Eigen::Vector3d& y, Derivatives& d) const {
    const double e = t.squaredNorm(), k = t.dot(c) / e;
    const Eigen::Vector3d z = (y - y.dot(across) * across) / acrossLength;
    d.setZero();
    d.row(0) = -k * z - z.dot(t) * (c - 2 * k * t) / e;
    d.row(1) = z - z.dot(t) * t / e;
  }
};

// The derivatives' basis functions at one point: rows as in Derivatives, columns over the (p + 1)(q + 1) points.
RowMatrix basisOf(const Surface& surface, const JoinBank& bank, Index spanAlong, double along, Index spanAcross,
                  const Eigen::VectorXd& weight, const std::vector<Index>& rows) {
  const int across = bank.direction, other = 1 - across;
  const RowMatrix a = basisDerivatives(surface.knots(other), spanAlong, along, 2);
  const RowMatrix c = basisDerivatives(surface.knots(across), spanAcross, bank.at, 2);
  // (along, across) orders; the value itself first, for weights.
  constexpr int orders[6][2] = {{0, 0}, {1, 0}, {0, 1}, {2, 0}, {1, 1}, {0, 2}};
  RowMatrix b(6, a.cols() * c.cols());
  for (int k = 0; k < 6; ++k) {
    for (Index i = 0; i < (across == 0 ? c : a).cols(); ++i) {
      for (Index j = 0; j < (across == 0 ? a : c).cols(); ++j) {
        const double u = across == 0 ? c(orders[k][1], i) : a(orders[k][0], i);
        const double v = across == 0 ? a(orders[k][0], j) : c(orders[k][1], j);
        b(k, i * (across == 0 ? a : c).cols() + j) = u * v;
      }
    }
  }
  if (weight.size() > 0) {
    double total[6];
    for (int k = 0; k < 6; ++k) {
      for (std::size_t r = 0; r < rows.size(); ++r) b(k, static_cast<Index>(r)) *= weight[rows[r]];
      total[k] = b.row(k).sum();
    }
    b.row(0) /= total[0];
    b.row(1) = (b.row(1) - total[1] * b.row(0)) / total[0];
    b.row(2) = (b.row(2) - total[2] * b.row(0)) / total[0];
    b.row(3) = (b.row(3) - 2 * total[1] * b.row(1) - total[3] * b.row(0)) / total[0];
    b.row(4) = (b.row(4) - total[1] * b.row(2) - total[2] * b.row(1) - total[4] * b.row(0)) / total[0];
    b.row(5) = (b.row(5) - 2 * total[2] * b.row(2) - total[5] * b.row(0)) / total[0];
  }
  return b.bottomRows(5);
}

// The span of the bank's cells.
Index spanBehind(const Surface& surface, const JoinBank& bank) {
  const KnotVector& knots = surface.knots(bank.direction);
  for (Index s : knots.spans()) {
    if (bank.above ? knots[s] == bank.at : knots[s + 1] == bank.at) return s;
  }
  throw InvalidInput("a join must lie on a knot line: this one does not");
}

std::vector<Index> cellRows(const Surface& surface, Index spanU, Index spanV) {
  std::vector<Index> rows;
  for (Index i = spanU - surface.degree(0); i <= spanU; ++i) {
    for (Index j = spanV - surface.degree(1); j <= spanV; ++j) rows.push_back(i * surface.size(1) + j);
  }
  return rows;
}

Eigen::MatrixX3d gathered(const Net& points, const std::vector<Index>& rows) {
  Eigen::MatrixX3d part(static_cast<Index>(rows.size()), 3);
  for (std::size_t r = 0; r < rows.size(); ++r) part.row(static_cast<Index>(r)) = points.row(rows[r]);
  return part;
}

double sign(double x) { return x < 0 ? -1 : 1; }

}  // namespace

JoinBank bankOfSide(const Surface& surface, int side) {
  const int direction = side / 2;
  const bool low = side % 2 == 0;
  return {direction, low ? surface.knots(direction).from() : surface.knots(direction).to(), low};
}

JoinEnergy::JoinEnergy(const Surface& a, const std::vector<int>& unknownA, const JoinBank& bankA, const Surface& b,
                       const std::vector<int>& unknownB, const JoinBank& bankB, bool reversed) {
  const KnotVector &alongA = a.knots(1 - bankA.direction), &alongB = b.knots(1 - bankB.direction);
  const Index behindA = spanBehind(a, bankA), behindB = spanBehind(b, bankB);
  Eigen::VectorXd weightA, weightB;
  if (a.isRational()) weightA = weights(a);
  if (b.isRational()) weightB = weights(b);
  const Net pointsA = a.euclideanNet(), pointsB = b.euclideanNet();
  const KnotVector &acrossA = a.knots(bankA.direction), &acrossB = b.knots(bankB.direction);
  const GaussRule rule = gaussLegendre(std::max(alongA.degree(), alongB.degree()) + 1);
  const double fromB = bankB.part ? bankB.part->front() : alongB.from();
  const double lengthB = bankB.part ? bankB.part->back() - fromB : alongB.length();
  for (Index spanA : alongA.spans()) {
    const double half = (alongA[spanA + 1] - alongA[spanA]) / 2, middle = (alongA[spanA + 1] + alongA[spanA]) / 2;
    const auto onB = [&](double t) {
      const double share = (t - alongA.from()) / alongA.length();
      return fromB + (reversed ? 1 - share : share) * lengthB;
    };
    const Index spanB = alongB.findSpan(onB(middle));
    Stretch stretch;
    stretch.rowsA = bankA.direction == 0 ? cellRows(a, behindA, spanA) : cellRows(a, spanA, behindA);
    stretch.rowsB = bankB.direction == 0 ? cellRows(b, behindB, spanB) : cellRows(b, spanB, behindB);
    for (Index row : stretch.rowsA) stretch.unknown.push_back(unknownA[static_cast<std::size_t>(row)]);
    for (Index row : stretch.rowsB) stretch.unknown.push_back(unknownB[static_cast<std::size_t>(row)]);
    if (*std::max_element(stretch.unknown.begin(), stretch.unknown.end()) < 0) continue;
    for (std::size_t q = 0; q < rule.nodes.size(); ++q) {
      const double t = middle + half * rule.nodes[q];
      Sample sample;
      sample.basisA = basisOf(a, bankA, spanA, t, behindA, weightA, stretch.rowsA);
      sample.basisB = basisOf(b, bankB, spanB, onB(t), behindB, weightB, stretch.rowsB);
      const Derivatives xa = sample.basisA * gathered(pointsA, stretch.rowsA);
      const Derivatives xb = sample.basisB * gathered(pointsB, stretch.rowsB);
      // The widths of the cells and the length of the line are those of the input: constants.
      const double width = 0.5 * (xa.row(1).norm() * (acrossA[behindA + 1] - acrossA[behindA]) +
                                  xb.row(1).norm() * (acrossB[behindB + 1] - acrossB[behindB]));
      const double length = half * rule.weights[q] * xa.row(0).norm();
      if (!(width > 0)) continue;
      sample.length = length;
      sample.angleWeight = kAngle * length / (width * width * width);
      sample.jumpWeight = length / width;
      stretch.samples.push_back(std::move(sample));
    }
    if (!stretch.samples.empty()) stretches_.push_back(std::move(stretch));
  }
}

JoinEnergy::JoinEnergy(const Surface& surface, const std::vector<int>& unknownOf, const JoinBank& bank,
                       const Eigen::Vector3d& normal)
    : JoinEnergy(surface, unknownOf, bank, surface, unknownOf, bank, false) {
  mirror_ = normal;
  for (Stretch& stretch : stretches_) {
    stretch.unknown.resize(stretch.rowsA.size());
    stretch.rowsB.clear();
    for (Sample& sample : stretch.samples) sample.basisB.resize(0, 0);
  }
}

std::vector<std::vector<int>> JoinEnergy::cliques() const {
  std::vector<std::vector<int>> result;
  for (const Stretch& stretch : stretches_) result.push_back(stretch.unknown);
  return result;
}

JoinFigures JoinEnergy::figures(const Net& pointsA, const Net& pointsB) const {
  JoinFigures sum;
  double length = 0;
  for (const Stretch& stretch : stretches_) {
    const Eigen::MatrixX3d a = gathered(pointsA, stretch.rowsA), b = gathered(pointsB, stretch.rowsB);
    for (const Sample& sample : stretch.samples) {
      const Bank p(sample.basisA * a);
      const Bank q = mirror_ ? p : Bank(sample.basisB * b);
      if (!p.regular || !q.regular) continue;
      const double angle = mirror_ ? 2 * p.n.dot(*mirror_) : p.n.dot(q.across);
      const double jump = p.curvature - sign(p.n.dot(q.n)) * q.curvature;
      sum.ofAngle += sample.angleWeight * angle * angle;
      sum.ofJump += sample.jumpWeight * jump * jump;
      length += sample.length;
      sum.meanAngle += sample.length * angle * angle;
      sum.meanJump += sample.length * jump * jump;
      sum.angle = std::max(sum.angle, std::abs(angle));
      sum.jump = std::max(sum.jump, std::abs(jump));
      sum.curvature = std::max({sum.curvature, std::abs(p.curvature), std::abs(q.curvature)});
    }
  }
  if (length > 0) {
    sum.meanAngle = std::sqrt(sum.meanAngle / length);
    sum.meanJump = std::sqrt(sum.meanJump / length);
  }
  return sum;
}

void JoinEnergy::addStep(const Net& pointsA, const Net& pointsB, double angleWeight, double jumpWeight,
                         BlockMatrix& matrix, Eigen::VectorXd& gradient) const {
  for (const Stretch& stretch : stretches_) {
    const Eigen::MatrixX3d a = gathered(pointsA, stretch.rowsA), b = gathered(pointsB, stretch.rowsB);
    const Index ma = a.rows(), mb = b.rows(), m = ma + mb;
    const Index figures = mirror_ ? 1 : 2;
    RowMatrix jacobian = RowMatrix::Zero(figures * static_cast<Index>(stretch.samples.size()), 3 * m);
    Eigen::VectorXd residual = Eigen::VectorXd::Zero(jacobian.rows());
    Index row = 0;
    // Columns: coordinate c of point k at c * m + k.
    const auto put = [&](Index r, const Derivatives& dA, const Derivatives& dB, const Sample& sample, double factor) {
      for (Index c = 0; c < 3; ++c) {
        jacobian.row(r).segment(c * m, ma) = factor * dA.col(c).transpose() * sample.basisA;
        if (mb > 0) jacobian.row(r).segment(c * m + ma, mb) = factor * dB.col(c).transpose() * sample.basisB;
      }
    };
    for (const Sample& sample : stretch.samples) {
      const Bank p(sample.basisA * a);
      const double angleFactor = std::sqrt(2 * angleWeight * sample.angleWeight);
      Derivatives dA, dB = Derivatives::Zero();
      if (mirror_) {
        if (p.regular) {
          p.normalBy(2 * *mirror_, dA);
          put(row, dA, dB, sample, angleFactor);
          residual[row] = angleFactor * 2 * p.n.dot(*mirror_);
        }
        ++row;
        continue;
      }
      const Bank q(sample.basisB * b);
      if (p.regular && q.regular) {
        p.normalBy(q.across, dA);
        q.acrossBy(p.n, dB);
        put(row, dA, dB, sample, angleFactor);
        residual[row] = angleFactor * p.n.dot(q.across);
        const double jumpFactor = std::sqrt(2 * jumpWeight * sample.jumpWeight), side = sign(p.n.dot(q.n));
        put(row + 1, p.byCurvature, -side * q.byCurvature, sample, jumpFactor);
        residual[row + 1] = jumpFactor * (p.curvature - side * q.curvature);
      }
      row += 2;
    }
    const Eigen::MatrixXd element = jacobian.transpose() * jacobian;
    const Eigen::VectorXd force = jacobian.transpose() * residual;
    for (Index i = 0; i < m; ++i) {
      const int ui = stretch.unknown[static_cast<std::size_t>(i)];
      if (ui < 0) continue;
      for (Index c = 0; c < 3; ++c) gradient[3 * ui + c] += force[c * m + i];
      for (Index j = 0; j < m; ++j) {
        const int uj = stretch.unknown[static_cast<std::size_t>(j)];
        if (uj < 0 || ui < uj) continue;
        double* block = matrix.block(ui, uj);
        for (Index c = 0; c < 3; ++c) {
          for (Index d = 0; d < 3; ++d) block[3 * c + d] += element(c * m + i, d * m + j);
        }
      }
    }
  }
}

}  // namespace strak
