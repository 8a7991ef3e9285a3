#include "strak/metrology/closest_points.h"

#include <tbb/global_control.h>

#include <limits>

#include "strak/base/error.h"
#include "strak/spline/evaluate.h"
#include "strak/spline/knot_insertion.h"
#include "tests/metrology/test_surfaces.h"

namespace strak {
namespace {

Surface wavy(bool crease) {
  std::array<KnotVector, 2> knots{KnotVector::uniformClamped(3, 12), KnotVector::uniformClamped(4, 9)};
  if (crease) knots[0] = withKnots(knots[0], {0.5, 0.5});
  const auto u = knots[0].greville(), v = knots[1].greville();
  Net net(knots[0].size() * knots[1].size(), 3);
  for (std::size_t i = 0; i < u.size(); ++i) {
    for (std::size_t j = 0; j < v.size(); ++j) {
      net.row(static_cast<Index>(i * v.size() + j)) << 3 * u[i], 2 * v[j],
          0.3 * std::sin(6 * u[i]) * std::cos(5 * v[j]);
    }
  }
  return Surface(knots, net);
}

struct Cloud {
  Net points, starts;
};

// Points near the surface, beyond its edges too, and starts near their feet.
Cloud around(const Surface& surface, Index count, double off) {
  std::mt19937_64 random(8);
  std::uniform_real_distribution<double> unit(-1, 1);
  Cloud cloud{Net(count, 3), Net(count, 2)};
  for (Index r = 0; r < count; ++r) {
    const double u = 0.5 + 0.5 * unit(random), v = 0.5 + 0.5 * unit(random);
    cloud.points.row(r) =
        evaluate<2>(surface, {u, v}) + off * Point(Eigen::RowVector3d(unit(random), unit(random), unit(random)));
    cloud.starts.row(r) << u + 0.01 * unit(random), v + 0.01 * unit(random);
  }
  return cloud;
}

TEST(ClosestPoints, AreThoseOfTheSafeguardedSearch) {
  for (const bool crease : {false, true}) {
    const Surface surface = wavy(crease);
    const Cloud cloud = around(surface, 3000, 0.05);
    const auto found = closestPointsFrom<2>(surface, cloud.points, cloud.starts);
    const ClosestPointFinder<2> finder(surface);
    for (Index r = 0; r < 3000; ++r) {
      const auto one = finder.findFrom(cloud.points.row(r), {cloud.starts(r, 0), cloud.starts(r, 1)});
      EXPECT_NEAR(found.distances[r], one.distance, 1e-12);
      EXPECT_NEAR(found.parameters(r, 0), one.parameters[0], 1e-6);
      EXPECT_NEAR(found.parameters(r, 1), one.parameters[1], 1e-6);
      const Point at = evaluate<2>(surface, {found.parameters(r, 0), found.parameters(r, 1)});
      EXPECT_NEAR((at - found.points.row(r)).norm(), 0, 1e-14);
    }
    EXPECT_LT(found.difficult, 100);
  }
}

TEST(ClosestPoints, MeetTheConditionsToRounding) {
  const Surface surface = wavy(false);
  const Cloud cloud = around(surface, 1000, 0.05);
  const auto found = closestPointsFrom<2>(surface, cloud.points, cloud.starts);
  const Net d = derivativesAt<2>(surface, found.parameters, 1);
  for (Index r = 0; r < 1000; ++r) {
    for (Index k = 0; k < 2; ++k) {
      const double slope = (found.points.row(r) - cloud.points.row(r)).dot(d.row(r).segment(3 + 3 * k, 3));
      const double u = found.parameters(r, k);
      if (u > 0) {
        EXPECT_LT(slope, 1e-12);
      }
      if (u < 1) {
        EXPECT_GT(slope, -1e-12);
      }
    }
  }
}

TEST(ClosestPoints, OfPointsOnTheSurfaceAreThePoints) {
  const Surface surface = wavy(false);
  const Cloud cloud = around(surface, 500, 0);
  const auto found = closestPointsFrom<2>(surface, cloud.points, cloud.starts);
  EXPECT_LT(found.distances.maxCoeff(), 1e-14);
}

TEST(ClosestPoints, FarAndBadStartsStillFindMinima) {
  const Surface surface = wavy(true);
  const Cloud cloud = around(surface, 300, 3);
  const Net starts = Net::Constant(300, 2, 0.2);
  const auto found = closestPointsFrom<2>(surface, cloud.points, starts);
  const auto global = closestPoints<2>(surface, cloud.points);
  for (Index r = 0; r < 300; ++r) {
    EXPECT_GE(found.distances[r], global.distances[r] - 1e-12);
    EXPECT_NEAR(global.distances[r], closestPoint<2>(surface, cloud.points.row(r)).distance, 1e-12);
    EXPECT_NEAR((found.points.row(r) - cloud.points.row(r)).norm(), found.distances[r], 1e-13);
  }
}

TEST(ClosestPoints, OfCurvesInThePlane) {
  Net net(6, 2);
  net << 0, 0, 1, 2, 2, -1, 3, 0, 4, 1, 5, 0;
  const Curve curve({KnotVector::uniformClamped(3, 3)}, net);
  Net points(200, 2), starts(200, 1);
  for (Index r = 0; r < 200; ++r) {
    const double t = static_cast<double>(r) / 199;
    points.row(r) = evaluate<1>(curve, {t}) + Point(Eigen::RowVector2d(0.05, -0.03));
    starts(r, 0) = t;
  }
  const auto found = closestPointsFrom<1>(curve, points, starts);
  for (Index r = 0; r < 200; ++r) {
    EXPECT_NEAR(found.distances[r], closestPoint<1>(curve, points.row(r)).distance, 1e-12);
  }
}

TEST(ClosestPoints, DoNotDependOnThreadsAndRefuseNonsense) {
  const Surface surface = wavy(false);
  const Cloud cloud = around(surface, 5000, 0.1);
  const auto with = [&](std::size_t threads) {
    const tbb::global_control limit(tbb::global_control::max_allowed_parallelism, threads);
    return closestPointsFrom<2>(surface, cloud.points, cloud.starts).parameters;
  };
  EXPECT_EQ(with(1), with(4));
  EXPECT_THROW(closestPointsFrom<2>(surface, cloud.points.leftCols(2), cloud.starts), InvalidInput);
  EXPECT_THROW(closestPointsFrom<2>(surface, cloud.points, cloud.starts.topRows(3)), InvalidInput);
  Net bad = cloud.points;
  bad(3, 1) = std::numeric_limits<double>::quiet_NaN();
  EXPECT_THROW(closestPointsFrom<2>(surface, bad, cloud.starts), InvalidInput);
  EXPECT_EQ(closestPointsFrom<2>(surface, Net(0, 3), Net(0, 2)).distances.size(), 0);
}

}  // namespace
}  // namespace strak
