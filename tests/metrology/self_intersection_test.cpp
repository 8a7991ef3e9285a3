#include "strak/metrology/self_intersection.h"

#include <tbb/global_control.h>

#include <Eigen/Geometry>
#include <cmath>

#include "strak/base/error.h"
#include "strak/spline/evaluate.h"
#include "strak/spline/knot_insertion.h"
#include "tests/metrology/test_surfaces.h"

namespace strak {
namespace {

using testing::randomKnots;
using testing::randomSpline;

Curve planar(int degree, const std::vector<std::array<double, 2>>& points) {
  Net net(static_cast<Index>(points.size()), 2);
  for (Index i = 0; i < net.rows(); ++i) {
    net.row(i) << points[static_cast<std::size_t>(i)][0], points[static_cast<std::size_t>(i)][1];
  }
  return {{KnotVector::uniformClamped(degree, net.rows() - degree)}, net};
}

// The curve (x, z) drawn along y; a slight cone, so that nothing is by accident exact.
Surface drawn(const Curve& curve) {
  const KnotVector v = KnotVector::uniformClamped(2, 3, 0, 2);
  const auto y = v.greville();
  Net net(curve.net().rows() * v.size(), 3);
  for (Index i = 0; i < curve.net().rows(); ++i) {
    for (Index j = 0; j < v.size(); ++j) {
      const double h = y[static_cast<std::size_t>(j)];
      net.row(i * v.size() + j) << (1 + 0.1 * h) * curve.net()(i, 0), h, (1 + 0.1 * h) * curve.net()(i, 1);
    }
  }
  return {{curve.knots(0), v}, net};
}

Curve loop() { return planar(3, {{0, 0}, {3, 2}, {-2, 2}, {1, 0}}); }
// A sheet folded once, its two halves `gap` apart.
Curve fold(double gap) {
  return planar(3, {{0, 0}, {1, 0}, {2, 0}, {3, 0}, {4, -1}, {4, gap + 1}, {3, gap}, {2, gap}, {1, gap}, {0, gap}});
}

template <int D>
void expectShown(const Spline<D>& spline, const std::string& what) {
  SCOPED_TRACE(what);
  const auto found = findSelfIntersection(spline);
  ASSERT_EQ(found.answer, SelfMeeting::intersects);
  Net parameters(2, D);
  double apart = 0;
  for (int k = 0; k < D; ++k) {
    const auto at = static_cast<std::size_t>(k);
    parameters(0, k) = found.a[at];
    parameters(1, k) = found.b[at];
    apart = std::max(apart, std::abs(found.a[at] - found.b[at]));
  }
  const Net places = derivativesAt<D>(spline, parameters, 0);
  EXPECT_LT((places.row(0) - places.row(1)).norm(), 1e-10 * spline.euclideanNet().cwiseAbs().maxCoeff());
  EXPECT_GT(apart, 1e-3);
}

template <int D>
SelfMeeting answerOf(const Spline<D>& spline) {
  return findSelfIntersection(spline).answer;
}

TEST(SelfIntersection, ProvesKnownSurfacesFree) {
  EXPECT_EQ(answerOf(testing::paraboloid(1, 0.3, -2)), SelfMeeting::free);
  EXPECT_EQ(answerOf(testing::torus(2, 0.7)), SelfMeeting::free);
  EXPECT_EQ(answerOf(testing::cylinder(1, 30)), SelfMeeting::free);
  EXPECT_EQ(answerOf(drawn(planar(2, {{0, 0}, {1, 2}, {2, 0}}))), SelfMeeting::free);
  for (double gap : {0.5, 1e-2, 1e-3}) EXPECT_EQ(answerOf(drawn(fold(gap))), SelfMeeting::free) << gap;
}

TEST(SelfIntersection, ShowsKnownOnes) {
  expectShown(drawn(loop()), "a loop drawn along a line");
  Net profile(4, 3);
  profile << 5, 0, 1, 8, 2, 1, 3, 2, 1, 6, 0, 1;
  expectShown(testing::revolved(profile, KnotVector::uniformClamped(3, 1)), "a loop that turns around an axis");
  expectShown(drawn(fold(-0.1)), "a fold that goes through itself");
  // Whitney's umbrella (uv, u, v^2): u = 0 is crossed by +-v.
  const double t[3] = {-1, 0, 1}, square[3] = {1, -1, 1};
  Net net(9, 3);
  for (Index i = 0; i < 3; ++i) {
    for (Index j = 0; j < 3; ++j) net.row(i * 3 + j) << t[i] * t[j], t[i], square[j];
  }
  const KnotVector knots(2, {-1, -1, -1, 1, 1, 1});
  expectShown(Surface({knots, knots}, net), "Whitney's umbrella");
}

TEST(SelfIntersection, OfCurves) {
  EXPECT_EQ(answerOf(fold(1e-6)), SelfMeeting::free);
  EXPECT_EQ(answerOf(planar(1, {{0, 0}, {1, 0}, {1, 1}, {0, 1}, {0, 0}})), SelfMeeting::free) << "a square, closed";
  expectShown(loop(), "a loop");
  expectShown(planar(1, {{0, 0}, {2, 2}, {2, 0}, {0, 2}}), "a polygon");
  expectShown(planar(2, {{0, 0}, {2, 1}, {2, -1}, {-2, 1}, {-2, -1}, {0.3, 0.1}}), "an eight, not quite closed");
  // In space the loop opens.
  Net net(4, 3);
  net << 0, 0, 0, 3, 2, 0, -2, 2, 0.3, 1, 0, 0.3;
  EXPECT_EQ(answerOf(Curve({KnotVector::uniformClamped(3, 1)}, net)), SelfMeeting::free);
  expectShown(Curve(
                  {testing::circleKnots()},
                  [] {
                    Net turned = testing::circleNet();
                    turned.row(4).head(2) *= -2;
                    return turned;
                  }(),
                  true),
              "rational");
}

TEST(SelfIntersection, SaysWhatItCannotDecide) {
  const auto sphere = findSelfIntersection(testing::sphere(2));
  EXPECT_EQ(sphere.answer, SelfMeeting::undecided);
  EXPECT_TRUE(sphere.onlyAtPoles);
  EXPECT_GT(sphere.undecided, 0);
  // A cusp is met by no pair, but near it no direction holds.
  const auto cusp = findSelfIntersection(planar(3, {{0, 0}, {1, 1}, {0, 1}, {1, 0}}));
  EXPECT_EQ(cusp.answer, SelfMeeting::undecided);
  EXPECT_FALSE(cusp.onlyAtPoles);
  // Too little work allowed.
  SelfIntersectionOptions<2> few;
  few.maxPairs = 10;
  EXPECT_EQ(findSelfIntersection(drawn(fold(1e-3)), few).answer, SelfMeeting::undecided);
  // All in one point.
  EXPECT_EQ(answerOf(Curve({KnotVector::uniformClamped(2, 2)}, Net::Ones(4, 3))), SelfMeeting::undecided);
}

TEST(SelfIntersection, JumpsAreNotCrossed) {
  // Two arcs of one curve with a jump between them: the second lies over the first.
  Net net(4, 2);
  net << 0, 0, 2, 0, 1, -1, 1, 1;
  expectShown(Curve({KnotVector(1, {0, 0, 1, 1, 2, 2})}, net), "crossing");
  net.row(3) << 1, -0.5;
  EXPECT_EQ(answerOf(Curve({KnotVector(1, {0, 0, 1, 1, 2, 2})}, net)), SelfMeeting::free);
}

TEST(SelfIntersection, IsTheSameForMovedScaledAndTurnedSurfaces) {
  std::mt19937_64 random(7);
  std::uniform_real_distribution<double> unit(-1, 1);
  int free = 0, meeting = 0;
  for (int i = 0; i < 60; ++i) {
    const double roughness = std::pow(10, -1.5 * (i % 4) / 3.0);
    const auto u = randomKnots(random, 1 + i % 3, 3), v = randomKnots(random, 2 + i % 2, 2);
    const auto gu = u.greville(), gv = v.greville();
    Net net(u.size() * v.size(), 3);
    for (Index r = 0; r < net.rows(); ++r) {
      net.row(r) << gu[static_cast<std::size_t>(r / v.size())] + roughness * unit(random),
          gv[static_cast<std::size_t>(r % v.size())] + roughness * unit(random), roughness * unit(random);
    }
    const Surface surface({u, v}, net);
    const SelfMeeting answer = answerOf(surface);
    free += answer == SelfMeeting::free;
    meeting += answer == SelfMeeting::intersects;
    const Eigen::Quaterniond q(unit(random), unit(random), unit(random), unit(random));
    const Eigen::Matrix3d turn = q.normalized().toRotationMatrix();
    const Net moved = (25.4 * net * turn.transpose()).rowwise() + Eigen::RowVector3d(3, 1, -2);
    EXPECT_EQ(answerOf(Surface({u, v}, moved)), answer) << i;
    EXPECT_EQ(answerOf(insertKnots(surface, 0, {0.4321})), answer) << i;
  }
  EXPECT_GT(free, 15);
  EXPECT_GT(meeting, 15);
}

// What a triangulation shows, of cells that lie apart, is never called free.
TEST(SelfIntersection, NeverCallsACrossingFree) {
  std::mt19937_64 random(11);
  int crossings = 0;
  for (int i = 0; i < 40; ++i) {
    const Curve curve = randomSpline<1>(random, {randomKnots(random, 1 + i % 4, 3)}, 2, i % 3 == 0);
    std::vector<double> us;
    for (int s = 0; s <= 400; ++s) us.push_back(std::lerp(curve.knots(0).from(), curve.knots(0).to(), s / 400.0));
    const Net p = derivativesOnGrid(curve, {us}, 0);
    bool crosses = false;
    for (Index a = 0; a < 400 && !crosses; ++a) {
      for (Index b = a + 5; b < 400 && !crosses; ++b) {
        const auto side = [&](Index line, Index x) {
          return (p(line + 1, 0) - p(line, 0)) * (p(x, 1) - p(line, 1)) -
                 (p(line + 1, 1) - p(line, 1)) * (p(x, 0) - p(line, 0));
        };
        crosses = side(a, b) * side(a, b + 1) < 0 && side(b, a) * side(b, a + 1) < 0;
      }
    }
    crossings += crosses;
    const SelfMeeting answer = answerOf(curve);
    if (crosses) {
      EXPECT_EQ(answer, SelfMeeting::intersects) << i;
    }
  }
  EXPECT_GT(crossings, 5);
}

TEST(SelfIntersection, LooksAtWhatAMoveChanged) {
  const Surface free = drawn(fold(0.1)), through = drawn(fold(-0.1));
  EXPECT_TRUE(meetingAfterMove(free, through).isNew);
  EXPECT_FALSE(meetingAfterMove(through, free).isNew);
  EXPECT_FALSE(meetingAfterMove(free, free).isNew);
  // It met itself before, and at the same place.
  Surface moved = through;
  moved.net().row(0).array() += 0.01;
  EXPECT_FALSE(meetingAfterMove(through, moved).isNew);
  SelfIntersectionOptions<2> nothing;
  nothing.unchangedFrom = &through;
  EXPECT_EQ(findSelfIntersection(through, nothing).answer, SelfMeeting::free);
}

TEST(SelfIntersection, DoesNotDependOnThreads) {
  const Surface surface = drawn(fold(-0.1));
  const auto many = findSelfIntersection(surface);
  const tbb::global_control one(tbb::global_control::max_allowed_parallelism, 1);
  const auto single = findSelfIntersection(surface);
  EXPECT_EQ(many.a, single.a);
  EXPECT_EQ(many.b, single.b);
}

TEST(SelfIntersection, RefusesWhatIsNotInSpace) {
  EXPECT_THROW((void)findSelfIntersection(Curve({KnotVector::uniformClamped(1, 1)}, Net::Random(2, 1))), InvalidInput);
  const KnotVector knots = KnotVector::uniformClamped(1, 1);
  EXPECT_THROW((void)findSelfIntersection(Surface({knots, knots}, Net::Random(4, 2))), InvalidInput);
}

}  // namespace
}  // namespace strak
