#include "strak/fairing/part_conversion.h"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "strak/base/error.h"
#include "strak/fairing/joints.h"
#include "strak/metrology/continuity.h"
#include "strak/spline/degree_elevation.h"
#include "strak/spline/evaluate.h"
#include "strak/spline/reparametrize.h"

namespace strak {
namespace {

constexpr double kTolerance = 1e-4;

// Waves over the unit square, more of them in either direction where u is large.
Surface waves() {
  const std::array<KnotVector, 2> knots{KnotVector::uniformClamped(5, 20), KnotVector::uniformClamped(5, 20)};
  const std::vector<double> across = knots[0].greville(), along = knots[1].greville();
  Net net(knots[0].size() * knots[1].size(), 3);
  for (Index i = 0; i < knots[0].size(); ++i) {
    for (Index j = 0; j < knots[1].size(); ++j) {
      const double x = across[static_cast<std::size_t>(i)], y = along[static_cast<std::size_t>(j)];
      net.row(i * knots[1].size() + j) << x, y, 0.1 * std::sin(3 * x + 14 * x * x * x) * std::cos(4 * y * (1 + 6 * x));
    }
  }
  return {knots, net};
}

Surface part(double u0, double u1, double v0, double v1) { return subPatch<2>(waves(), {u0, v0}, {u1, v1}); }

Eigen::Vector2d corner(const Surface& surface, bool u, bool v) {
  return {u ? surface.knots(0).to() : surface.knots(0).from(), v ? surface.knots(1).to() : surface.knots(1).from()};
}

std::vector<Eigen::Vector2d> lineOf(const Surface& surface, int side) {
  const bool high = side % 2 == 1;
  if (side < 2) return {corner(surface, high, false), corner(surface, high, true)};
  return {corner(surface, false, high), corner(surface, true, high)};
}

PartEdge wholeSides(const std::vector<PartFace>& faces, Index a, int sideA, Index b, int sideB) {
  return {a,
          b,
          lineOf(faces[static_cast<std::size_t>(a)].surface, sideA),
          lineOf(faces[static_cast<std::size_t>(b)].surface, sideB),
          sideA,
          sideB,
          sideA,
          sideB};
}

PartConversionOptions within(double tolerance, double joins) {
  PartConversionOptions options;
  options.each.tolerance = tolerance;
  options.joinTolerance = joins;
  return options;
}

double gapOf(const PartEdge& edge, const Surface& a, const Surface& b) {
  return edgeContinuity(a, parameterPolyline(edge.line), b, parameterPolyline(edge.otherLine)).gap.max;
}

// A quarter of a cylinder about y from y0 to y1, run through the more unevenly the farther `pace` is from 1; its low
// and high sides in v are arcs.
Surface cylinder(double y0, double y1, double pace) {
  const KnotVector round = KnotVector::uniformClamped(2, 1), straight = KnotVector::uniformClamped(1, 1, y0, y1);
  Net net(6, 4);
  for (Index i = 0; i < 3; ++i) {
    const double weight = std::pow(pace, static_cast<double>(i)) * (i == 1 ? std::numbers::sqrt2 / 2 : 1);
    for (Index j = 0; j < 2; ++j) {
      const double y = j == 0 ? y0 : y1;
      net.row(2 * i + j) << weight * (i < 2 ? 1 : 0), weight * y, weight * (i > 0 ? 1 : 0), weight;
    }
  }
  return {{round, straight}, net, true};
}

// Spans are handed on along the whole chain, from the face that needs the most.
TEST(PartConversion, WholeSidesStayOneCurve) {
  const std::vector<PartFace> faces{
      {"a", part(0, 0.3, 0, 0.5)}, {"b", part(0.3, 1, 0, 0.5)}, {"c", part(0.3, 1, 0.5, 1)}};
  const std::vector<PartEdge> edges{wholeSides(faces, 0, 1, 1, 0), wholeSides(faces, 1, 3, 2, 2)};
  std::vector<Index> alone;
  for (const PartFace& face : faces) {
    alone.push_back(convertSpline<2>(face.surface, within(kTolerance, 1).each).spline.size(1));
  }
  const ConvertedPart made = convertPart(faces, edges, within(kTolerance, kTolerance / 10));
  EXPECT_EQ(made.common, 2);
  EXPECT_EQ(made.near, 0);
  EXPECT_TRUE(made.loose.empty());
  for (const auto& face : made.faces) {
    EXPECT_TRUE(face.reached);
    EXPECT_LE(face.deviation.upper, kTolerance);
  }
  for (const PartEdge& edge : edges) {
    const Surface &a = made.faces[static_cast<std::size_t>(edge.face)].spline,
                  &b = made.faces[static_cast<std::size_t>(*edge.other)].spline;
    const BorderFit fit = fitBorders(a, *edge.side, b, *edge.otherSide, 1e-12);
    EXPECT_TRUE(fit.compatible) << fit.obstacle;
    EXPECT_LT(fit.gap, 1e-13);
  }
  EXPECT_NE(alone[0], alone[1]);
  EXPECT_EQ(made.faces[0].spline.size(1), std::max(alone[0], alone[1]));
}

TEST(PartConversion, SidesAtOtherParametersOpenByNoMoreThanAllowed) {
  const std::vector<PartFace> faces{{"a", cylinder(0, 1, 1)}, {"b", cylinder(1, 2, 2)}};
  const std::vector<PartEdge> edges{wholeSides(faces, 0, 3, 1, 2)};
  const ConvertedPart loose = convertPart(faces, edges, within(kTolerance, 10)),
                      made = convertPart(faces, edges, within(kTolerance, kTolerance / 50));
  EXPECT_EQ(made.common, 0);
  EXPECT_EQ(made.near, 1);
  EXPECT_GT(gapOf(edges[0], loose.faces[0].spline, loose.faces[1].spline), kTolerance / 50);
  EXPECT_LE(gapOf(edges[0], made.faces[0].spline, made.faces[1].spline), kTolerance / 50);
  for (const auto& face : made.faces) {
    EXPECT_TRUE(face.reached);
    EXPECT_LE(face.sides[&face == &made.faces[0] ? 3 : 2], kTolerance / 100);
  }
}

// Two short sides on a long one, and adapted knots: nothing can be shared, everything stays near.
TEST(PartConversion, PartsOfSidesAndAdaptedKnotsAreHeldByNearness) {
  for (const KnotSpacing spacing : {KnotSpacing::uniform, KnotSpacing::adapted}) {
    const std::vector<PartFace> faces{
        {"long", part(0, 1, 0, 0.5)}, {"left", part(0, 0.43, 0.5, 1)}, {"right", part(0.43, 1, 0.5, 1)}};
    std::vector<PartEdge> edges{wholeSides(faces, 1, 2, 0, 3), wholeSides(faces, 2, 2, 0, 3),
                                wholeSides(faces, 1, 1, 2, 0)};
    edges[0].otherSide = edges[1].otherSide = {};
    edges[0].otherLine[1][0] = edges[1].otherLine[0][0] = 0.43;
    PartConversionOptions options = within(kTolerance, kTolerance / 20);
    options.each.spacing = spacing;
    const ConvertedPart made = convertPart(faces, edges, options);
    EXPECT_EQ(made.common, spacing == KnotSpacing::uniform ? 1 : 0);
    for (const PartEdge& edge : edges) {
      EXPECT_LE(gapOf(edge, made.faces[static_cast<std::size_t>(edge.face)].spline,
                      made.faces[static_cast<std::size_t>(*edge.other)].spline),
                kTolerance / 20);
    }
  }
}

// Angles at smooth joins stay within what is allowed, if that is asked for; features may turn.
TEST(PartConversion, AnglesStayIfWished) {
  const std::vector<PartFace> faces{{"a", part(0, 1, 0, 0.5)}, {"b", part(0, 1, 0.5, 1)}};
  const std::vector<PartEdge> edges{wholeSides(faces, 0, 3, 1, 2)};
  const auto angle = [&](const std::vector<PartFace>& all, double wished) {
    PartConversionOptions options = within(kTolerance, kTolerance / 10);
    if (wished > 0) options.joinAngle = wished;
    const ConvertedPart made = convertPart(all, edges, options);
    const double radians = edgeContinuity(made.faces[0].spline, parameterPolyline(edges[0].line), made.faces[1].spline,
                                          parameterPolyline(edges[0].otherLine))
                               .angle.max;
    return std::pair{radians * 180 / std::numbers::pi, made.faces[0].spline.net().rows()};
  };
  const auto [free, few] = angle(faces, 0);
  const auto [held, many] = angle(faces, 0.05);
  EXPECT_GT(free, 0.05);
  EXPECT_LE(held, 0.05);
  EXPECT_GT(many, few);
  // The second face folded up along the join steeply: a feature.
  std::vector<PartFace> folded = faces;
  Net net = folded[1].surface.net();
  for (Index r = 0; r < net.rows(); ++r) net(r, 2) += 10 * (net(r, 1) - 0.5);
  folded[1].surface = Surface(faces[1].surface.knots(), net);
  EXPECT_EQ(angle(folded, 0.05).second, angle(folded, 0).second);
}

TEST(PartConversion, TrimmedEdgesAndNeighboursThatStay) {
  const std::vector<PartFace> faces{{"a", part(0, 1, 0, 1)}};
  PartEdge edge;
  for (int i = 0; i <= 100; ++i) edge.line.emplace_back(0.5 + 0.4 * std::sin(0.03 * i), 0.5 + 0.4 * std::cos(0.03 * i));
  const auto farthest = [&](const Surface& made) {
    double largest = 0;
    for (const auto& at : edge.line) {
      const Surface::Parameter here{at[0], at[1]};
      largest = std::max(largest, (evaluate<2>(made, here) - evaluate<2>(faces[0].surface, here)).norm());
    }
    return largest;
  };
  const double allowed = kTolerance / 20;
  EXPECT_GT(farthest(convertPart(faces, {}, within(kTolerance, allowed)).faces[0].spline), allowed);
  EXPECT_LE(farthest(convertPart(faces, {edge}, within(kTolerance, allowed)).faces[0].spline), allowed);
}

// A face that is a uniform cubic comes back to the bit; a neighbour that follows its side exactly is given its spans,
// and another one must come near.
TEST(PartConversion, UniformCubicsStay) {
  const Surface cubic = convertSpline<2>(part(0, 0.5, 0, 1), within(1e-2, 1).each).spline;
  const Surface mirrored = elevateDegree(elevateDegree(reversed(cubic, 0), 0, 1), 1, 1);
  const std::vector<PartFace> faces{{"a", cubic}, {"b", mirrored}, {"c", part(0.5, 1, 0, 1)}};
  const std::vector<PartEdge> edges{wholeSides(faces, 0, 1, 1, 0), wholeSides(faces, 0, 1, 2, 0)};
  const ConvertedPart made = convertPart(faces, edges, within(kTolerance, kTolerance / 10));
  EXPECT_TRUE(made.faces[0].unchanged);
  EXPECT_EQ(made.faces[0].spline, cubic);
  EXPECT_EQ(made.common, 1);
  EXPECT_LT((made.faces[1].spline.net() - reversed(cubic, 0).net()).cwiseAbs().maxCoeff(), 1e-12);
  EXPECT_LE(made.faces[2].sides[0], kTolerance / 20);
}

TEST(PartConversion, WhatTakesTooManyPointsIsLeftLooseAndSaid) {
  const std::vector<PartFace> faces{{"a", cylinder(0, 1, 1)}, {"b", cylinder(1, 2, 2)}};
  const std::vector<PartEdge> edges{wholeSides(faces, 0, 3, 1, 2)};
  PartConversionOptions options = within(kTolerance, 1e-11);
  options.each.mostPoints = 100;
  const ConvertedPart made = convertPart(faces, edges, options);
  EXPECT_EQ(made.loose, (std::vector<std::string>{"a", "b"}));
  for (const auto& face : made.faces) {
    EXPECT_TRUE(face.reached);
    EXPECT_LE(face.spline.net().rows(), 100);
  }
}

// A strip over [from, from + 1] x [0, 1] with waves along u or v; control points at the Greville places.
Surface strip(double from, Index spansU, Index spansV) {
  const std::array<KnotVector, 2> knots{KnotVector::uniformClamped(5, spansU), KnotVector::uniformClamped(5, spansV)};
  const std::vector<double> across = knots[0].greville(), along = knots[1].greville();
  Net net(knots[0].size() * knots[1].size(), 3);
  for (Index i = 0; i < knots[0].size(); ++i) {
    for (Index j = 0; j < knots[1].size(); ++j) {
      const double x = across[static_cast<std::size_t>(i)], y = along[static_cast<std::size_t>(j)];
      const double wave = spansU > spansV ? (1 - x) * (1 - x) * std::sin(40 * x) : x * x * std::sin(40 * y);
      net.row(i * knots[1].size() + j) << from + x, y, 0.1 * wave;
    }
  }
  return {knots, net};
}

TEST(PartConversion, ANeighboursWishThatTakesTooManyPointsRefusesNothing) {
  // The first face has many spans across the common side, the second one along it: both would be too many.
  std::vector<PartFace> faces;
  faces.push_back({"a", strip(0, 40, 1)});
  faces.push_back({"b", strip(1, 1, 40)});
  const std::vector<PartEdge> edges{wholeSides(faces, 0, 1, 1, 0)};
  PartConversionOptions options = within(kTolerance, kTolerance / 10);
  options.each.mostPoints = 1500;
  const ConvertedPart made = convertPart(faces, edges, options);
  EXPECT_FALSE(made.loose.empty());
  for (const auto& face : made.faces) {
    EXPECT_TRUE(face.reached);
    EXPECT_LE(face.spline.net().rows(), 1500);
    EXPECT_LE(face.deviation.upper, kTolerance);
  }
  // With room for them the side stays one.
  options.each.mostPoints = 20000;
  EXPECT_EQ(convertPart(faces, edges, options).common, 1);
}

TEST(PartConversion, BadInput) {
  const std::vector<PartFace> faces{{"a", part(0, 1, 0, 1)}};
  EXPECT_THROW(convertPart(faces, {}, within(kTolerance, 0)), InvalidInput);
  EXPECT_THROW(convertPart(faces, {}, within(kTolerance, std::nan(""))), InvalidInput);
  EXPECT_THROW(convertPart(faces, {}, within(-1, 1)), InvalidInput);
  PartConversionOptions turned = within(kTolerance, 1);
  turned.joinAngle = 0;
  EXPECT_THROW(convertPart(faces, {}, turned), InvalidInput);
  EXPECT_TRUE(convertPart({}, {}, within(1, 1)).faces.empty());
}

}  // namespace
}  // namespace strak
