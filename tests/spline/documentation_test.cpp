// The code of docs/splines.md, so that the page stays true.

#include <gtest/gtest.h>

#include "strak/spline/evaluator.h"
#include "strak/spline/knot_insertion.h"
#include "strak/spline/knot_removal.h"
#include "strak/spline/reparametrize.h"

namespace strak {
namespace {

TEST(Documentation, SplinesPageIsTrue) {
  Net net(9, 3);  // a bi-quadratic patch over the unit square: z = u v
  for (int i = 0; i < 3; ++i) {
    for (int j = 0; j < 3; ++j) net.row(3 * i + j) << i / 2.0, j / 2.0, i * j / 4.0;
  }
  const auto knots = KnotVector::uniformClamped(2, 1);
  const Surface surface({knots, knots}, net);

  const Point x = evaluate(surface, {0.25, 0.5});
  EXPECT_EQ(x, Eigen::RowVector3d(0.25, 0.5, 0.125));
  const Net d = derivatives(surface, {0.25, 0.5}, 2);
  EXPECT_EQ(d.rows(), 6);
  EXPECT_EQ(d(4, 2), 1);  // z_uv

  const Evaluator<2> evaluator(surface);
  const Net grid = evaluator.derivativesOnGrid({{{0, 0.5, 1}, {0, 0.5, 1}}}, 2);
  EXPECT_EQ(grid.rows(), 9);
  EXPECT_NEAR(grid(5, 1), 1, 1e-15);  // row (u, v) = (0.5, 1): v fastest

  const auto finer = insertKnots(surface, 0, {0.25, 0.5});
  EXPECT_EQ(finer.size(0), 5);
  const auto removal = removeKnots(finer, 0, {0.25, 0.5});
  EXPECT_LT(removal.bound, 1e-15);
  const auto thinned = removeKnotsWithin(finer, 0, 1e-6);
  EXPECT_EQ(thinned.spline.size(0), 3);
  const auto refinement = refinementMatrix(surface.knots(0), finer.knots(0));
  EXPECT_EQ(refinement.rows(), 5);
  EXPECT_EQ(refinement.cols(), 3);

  const Surface part = subPatch(surface, {0.25, 0.5}, {0.5, 1});
  EXPECT_EQ(evaluate(part, {0.25, 0.5}), evaluate(surface, {0.25, 0.5}));
}

}  // namespace
}  // namespace strak
