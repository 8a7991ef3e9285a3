#include "strak/fitting/steady_points.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <iterator>
#include <numeric>

#include "strak/fitting/parametrization.h"

namespace strak {
namespace {

TEST(SteadyPoints, OutliersAlongACurveAreToldApart) {
  Net points(40, 2);
  for (Index r = 0; r < 40; ++r) points.row(r) << static_cast<double>(r), std::sin(0.3 * static_cast<double>(r));
  std::vector<Index> all(40);
  std::iota(all.begin(), all.end(), Index{0});
  EXPECT_EQ(steadyPoints(points), all);
  const Net lengths = chordLengthParameters(points);
  for (const Index far : {0, 11, 12, 39}) points(far, 1) += 50;
  std::vector<Index> rest;
  std::copy_if(all.begin(), all.end(), std::back_inserter(rest),
               [](Index r) { return r != 0 && r != 11 && r != 12 && r != 39; });
  EXPECT_EQ(steadyPoints(points), rest);
  Net steady(36, 2);
  for (std::size_t i = 0; i < rest.size(); ++i) steady.row(static_cast<Index>(i)) = points.row(rest[i]);
  const Net spread = spreadParameters(rest, chordLengthParameters(steady), 40);
  EXPECT_NEAR(spread(38, 0), lengths(38, 0) - lengths(1, 0), 0.2);
  EXPECT_EQ(spread(0, 0), 0);
  EXPECT_EQ(spread(39, 0), spread(38, 0));
  EXPECT_NEAR(spread(12, 0), (spread(10, 0) + 2 * spread(13, 0)) / 3, 1e-12);
  // A gap in the measurement is none, nor are few points.
  points.bottomRows(20).rowwise() += Eigen::RowVector2d(100, 0);
  EXPECT_EQ(steadyPoints(points).size(), 36U);
  EXPECT_EQ(steadyPoints(points.topRows(1)).size(), 1U);
}

}  // namespace
}  // namespace strak
