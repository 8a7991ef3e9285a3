#include "strak/exchange/cad_geometry_occ.h"

#include <Precision.hxx>
#include <TColStd_Array1OfInteger.hxx>
#include <TColStd_Array1OfReal.hxx>
#include <TColStd_Array2OfReal.hxx>
#include <TColgp_Array1OfPnt.hxx>
#include <TColgp_Array2OfPnt.hxx>

#include <fmt/format.h>

#include <algorithm>

#include "strak/base/error.h"

namespace strak::cad {
namespace {

// Knot values with their multiplicities, as Open CASCADE keeps them.
struct Knots {
  std::vector<double> values;
  std::vector<int> multiplicities;
};

Knots split(const KnotVector& knots) {
  Knots result;
  for (double knot : knots.knots()) {
    if (!result.values.empty() && result.values.back() == knot) {
      ++result.multiplicities.back();
    } else {
      result.values.push_back(knot);
      result.multiplicities.push_back(1);
    }
  }
  return result;
}

KnotVector join(int degree, const TColStd_Array1OfReal& values, const TColStd_Array1OfInteger& multiplicities,
                const char* name) {
  std::vector<double> flat;
  for (int i = values.Lower(); i <= values.Upper(); ++i) {
    flat.insert(flat.end(), static_cast<std::size_t>(multiplicities(i)), values(i));
  }
  return KnotVector(degree, std::move(flat), name);
}

KnotVector knotsOf(const Geom_BSplineCurve& curve) {
  return join(curve.Degree(), curve.Knots(), curve.Multiplicities(), "u");
}
KnotVector knotsOf(const Geom_BSplineSurface& surface, int direction) {
  return direction == 0 ? join(surface.UDegree(), surface.UKnots(), surface.UMultiplicities(), "u")
                        : join(surface.VDegree(), surface.VKnots(), surface.VMultiplicities(), "v");
}

void setRow(Net& net, Index row, const gp_Pnt& pole, double weight, double unitLength, bool rational) {
  net.row(row).head(3) << pole.X() / unitLength, pole.Y() / unitLength, pole.Z() / unitLength;
  if (!rational) return;
  net.row(row).head(3) *= weight;
  net(row, 3) = weight;
}

gp_Pnt poleOf(const Net& euclidean, Index row, double unitLength) {
  gp_Pnt pole;
  for (int c = 0; c < 3; ++c) {
    pole.SetCoord(c + 1, c < euclidean.cols() ? euclidean(row, c) * unitLength : 0.0);
  }
  return pole;
}

// What the net of a spline has in row `row` or should have there.
template <int D>
gp_Pnt poleOf(const Spline<D>& spline, Index row, double unitLength) {
  const Net& net = spline.net();
  if (!spline.isRational()) return poleOf(net, row, unitLength);
  return poleOf(net.row(row).head(3) / net(row, 3), 0, unitLength);
}

template <int D>
double weightOf(const Spline<D>& spline, Index row) {
  return spline.isRational() ? spline.net()(row, 3) : 1.0;
}

// Whether a pole and its weight give the row of the target's net to the bit. No spline is made of the poles: right
// after knots were taken out their weights may be anything.
template <int D>
bool gives(const gp_Pnt& pole, double weight, const Spline<D>& target, Index row, double unitLength) {
  Net has(1, target.net().cols());
  setRow(has, 0, pole, weight, unitLength, target.isRational());
  return has.row(0) == target.net().row(row);
}

TColStd_Array1OfReal array(const std::vector<double>& values) {
  TColStd_Array1OfReal result(1, static_cast<int>(values.size()));
  for (int i = 1; i <= result.Upper(); ++i) result(i) = values[static_cast<std::size_t>(i - 1)];
  return result;
}
TColStd_Array1OfInteger array(const std::vector<int>& values) {
  TColStd_Array1OfInteger result(1, static_cast<int>(values.size()));
  for (int i = 1; i <= result.Upper(); ++i) result(i) = values[static_cast<std::size_t>(i - 1)];
  return result;
}

template <int D>
void requireSpace(const Spline<D>& spline) {
  if (spline.pointDimension() > 3) throw InvalidInput("CAD files hold points with at most 3 coordinates");
}

// One direction of a curve or surface under one name each for what Open CASCADE calls differently.
struct CurveDirection {
  Geom_BSplineCurve& g;
  int count() const { return g.NbKnots(); }
  double knot(int i) const { return g.Knot(i); }
  int multiplicity(int i) const { return g.Multiplicity(i); }
  bool remove(int i, int m) const { return g.RemoveKnot(i, m, Precision::Infinite()); }
  void insert(const TColStd_Array1OfReal& k, const TColStd_Array1OfInteger& m) const {
    g.InsertKnots(k, m, 0.0, false);
  }
};
struct UDirection {
  Geom_BSplineSurface& g;
  int count() const { return g.NbUKnots(); }
  double knot(int i) const { return g.UKnot(i); }
  int multiplicity(int i) const { return g.UMultiplicity(i); }
  bool remove(int i, int m) const { return g.RemoveUKnot(i, m, Precision::Infinite()); }
  void insert(const TColStd_Array1OfReal& k, const TColStd_Array1OfInteger& m) const {
    g.InsertUKnots(k, m, 0.0, false);
  }
};
struct VDirection {
  Geom_BSplineSurface& g;
  int count() const { return g.NbVKnots(); }
  double knot(int i) const { return g.VKnot(i); }
  int multiplicity(int i) const { return g.VMultiplicity(i); }
  bool remove(int i, int m) const { return g.RemoveVKnot(i, m, Precision::Infinite()); }
  void insert(const TColStd_Array1OfReal& k, const TColStd_Array1OfInteger& m) const {
    g.InsertVKnots(k, m, 0.0, false);
  }
};

// Makes the knots of one direction inside the domain those of `target`. The shape between may be anything: all poles
// are set afterwards.
template <typename Direction>
void assignKnots(const Direction& live, const KnotVector& target) {
  const std::vector<KnotVector::InnerKnot> wanted = target.innerKnots();
  for (int i = live.count(); i >= 1; --i) {
    if (live.knot(i) <= target.from() || live.knot(i) >= target.to()) continue;
    const auto at =
        std::find_if(wanted.begin(), wanted.end(), [&](const auto& knot) { return knot.value == live.knot(i); });
    const int keep = at == wanted.end() ? 0 : at->multiplicity;
    if (live.multiplicity(i) > keep && !live.remove(i, keep)) throw Failure("Open CASCADE does not take a knot out");
  }
  if (wanted.empty()) return;
  TColStd_Array1OfReal values(1, static_cast<int>(wanted.size()));
  TColStd_Array1OfInteger multiplicities(1, values.Upper());
  for (int i = 1; i <= values.Upper(); ++i) {
    values(i) = wanted[static_cast<std::size_t>(i - 1)].value;
    multiplicities(i) = wanted[static_cast<std::size_t>(i - 1)].multiplicity;
  }
  live.insert(values, multiplicities);  // leaves those alone that are there already
}

void requireSameKnots(const KnotVector& has, const KnotVector& wanted, int direction) {
  if (has == wanted) return;
  throw Failure(fmt::format("Open CASCADE did not take over the knots of direction {} as given: nothing was written",
                            directionName(direction)));
}

void requireSameWeights(bool same) {
  if (!same) throw Failure("Open CASCADE did not take over the weights as given: nothing was written");
}

}  // namespace

Curve toSpline(const Geom_BSplineCurve& curve, double unitLength) {
  if (curve.IsPeriodic()) {
    const Handle(Geom_BSplineCurve) open = Handle(Geom_BSplineCurve)::DownCast(curve.Copy());
    open->SetNotPeriodic();
    return toSpline(*open, unitLength);
  }
  const bool rational = curve.IsRational();
  Net net(curve.NbPoles(), rational ? 4 : 3);
  for (int i = 1; i <= curve.NbPoles(); ++i) setRow(net, i - 1, curve.Pole(i), curve.Weight(i), unitLength, rational);
  return Curve({knotsOf(curve)}, std::move(net), rational);
}

Surface toSpline(const Geom_BSplineSurface& surface, double unitLength) {
  if (surface.IsUPeriodic() || surface.IsVPeriodic()) {
    const Handle(Geom_BSplineSurface) open = Handle(Geom_BSplineSurface)::DownCast(surface.Copy());
    if (open->IsUPeriodic()) open->SetUNotPeriodic();
    if (open->IsVPeriodic()) open->SetVNotPeriodic();
    return toSpline(*open, unitLength);
  }
  const bool rational = surface.IsURational() || surface.IsVRational();
  const Index columns = surface.NbVPoles();
  Net net(surface.NbUPoles() * columns, rational ? 4 : 3);
  for (int i = 1; i <= surface.NbUPoles(); ++i) {
    for (int j = 1; j <= surface.NbVPoles(); ++j) {
      setRow(net, (i - 1) * columns + j - 1, surface.Pole(i, j), surface.Weight(i, j), unitLength, rational);
    }
  }
  return Surface({knotsOf(surface, 0), knotsOf(surface, 1)}, std::move(net), rational);
}

Handle(Geom_BSplineCurve) fromSpline(const Curve& curve, double unitLength) {
  requireSpace(curve);
  const Knots knots = split(curve.knots(0));
  const Net points = curve.euclideanNet();
  TColgp_Array1OfPnt poles(1, static_cast<int>(points.rows()));
  TColStd_Array1OfReal weights(1, poles.Upper());
  for (int i = 1; i <= poles.Upper(); ++i) {
    poles(i) = poleOf(points, i - 1, unitLength);
    weights(i) = curve.isRational() ? curve.net()(i - 1, curve.net().cols() - 1) : 1.0;
  }
  return new Geom_BSplineCurve(poles, weights, array(knots.values), array(knots.multiplicities), curve.degree(0));
}

Handle(Geom_BSplineSurface) fromSpline(const Surface& surface, double unitLength) {
  requireSpace(surface);
  const Knots u = split(surface.knots(0));
  const Knots v = split(surface.knots(1));
  const Net points = surface.euclideanNet();
  TColgp_Array2OfPnt poles(1, static_cast<int>(surface.size(0)), 1, static_cast<int>(surface.size(1)));
  TColStd_Array2OfReal weights(1, poles.UpperRow(), 1, poles.UpperCol());
  for (int i = 1; i <= poles.UpperRow(); ++i) {
    for (int j = 1; j <= poles.UpperCol(); ++j) {
      const Index row = surface.row({i - 1, j - 1});
      poles(i, j) = poleOf(points, row, unitLength);
      weights(i, j) = surface.isRational() ? surface.net()(row, surface.net().cols() - 1) : 1.0;
    }
  }
  return new Geom_BSplineSurface(poles, weights, array(u.values), array(v.values), array(u.multiplicities),
                                 array(v.multiplicities), surface.degree(0), surface.degree(1));
}

void assign(Geom_BSplineCurve& live, const Geom_BSplineCurve& original, const Curve& target, double unitLength) {
  const bool back = target == toSpline(original, unitLength);
  assignKnots(CurveDirection{live}, target.knots(0));
  requireSameKnots(knotsOf(live), target.knots(0), 0);
  const auto weight = [&](int i) { return back ? original.Weight(i) : weightOf(target, i - 1); };
  for (int i = 1; i <= live.NbPoles(); ++i) {
    if (back) {
      live.SetPole(i, original.Pole(i));
    } else if (!gives(live.Pole(i), live.Weight(i), target, i - 1, unitLength)) {
      live.SetPole(i, poleOf(target, i - 1, unitLength));
    }
  }
  // Weights that are all alike for a moment are forgotten by the kernel: then the second round sets them again.
  constexpr int kRounds = 2;
  bool same = false;
  for (int round = 0; round < kRounds && !same; ++round) {
    same = true;
    for (int i = 1; i <= live.NbPoles(); ++i) {
      if (live.Weight(i) != weight(i)) live.SetWeight(i, weight(i));
    }
    for (int i = 1; i <= live.NbPoles(); ++i) same = same && live.Weight(i) == weight(i);
  }
  requireSameWeights(same);
}

void assign(Geom_BSplineSurface& live, const Geom_BSplineSurface& original, const Surface& target, double unitLength) {
  const bool back = target == toSpline(original, unitLength);
  assignKnots(UDirection{live}, target.knots(0));
  assignKnots(VDirection{live}, target.knots(1));
  requireSameKnots(knotsOf(live, 0), target.knots(0), 0);
  requireSameKnots(knotsOf(live, 1), target.knots(1), 1);
  TColStd_Array1OfReal rowWeights(1, live.NbVPoles());
  for (int i = 1; i <= live.NbUPoles(); ++i) {
    bool otherWeights = false;
    for (int j = 1; j <= live.NbVPoles(); ++j) {
      const Index row = target.row({i - 1, j - 1});
      rowWeights(j) = back ? original.Weight(i, j) : weightOf(target, row);
      otherWeights = otherWeights || live.Weight(i, j) != rowWeights(j);
      if (back) {
        live.SetPole(i, j, original.Pole(i, j));
      } else if (!gives(live.Pole(i, j), live.Weight(i, j), target, row, unitLength)) {
        live.SetPole(i, j, poleOf(target, row, unitLength));
      }
    }
    // A whole row at a time: after each call the kernel looks through all weights.
    if (otherWeights) live.SetWeightRow(i, rowWeights);
  }
  bool same = true;
  for (int i = 1; i <= live.NbUPoles(); ++i) {
    for (int j = 1; j <= live.NbVPoles(); ++j) {
      same = same && live.Weight(i, j) == (back ? original.Weight(i, j) : weightOf(target, target.row({i - 1, j - 1})));
    }
  }
  requireSameWeights(same);
}

AnySpline placed(const AnySpline& spline, const gp_Trsf& placement, double unitLength) {
  AnySpline moved = spline;
  std::visit(
      [&](auto& s) {
        for (Index r = 0; r < s.net().rows(); ++r) {
          const double weight = s.isRational() ? s.net()(r, 3) : 1.0;
          gp_XYZ point(s.net()(r, 0) / weight * unitLength, s.net()(r, 1) / weight * unitLength,
                       s.net()(r, 2) / weight * unitLength);
          placement.Transforms(point);
          s.net().row(r).head(3) << point.X() / unitLength * weight, point.Y() / unitLength * weight,
              point.Z() / unitLength * weight;
        }
      },
      moved);
  return moved;
}

}  // namespace strak::cad
