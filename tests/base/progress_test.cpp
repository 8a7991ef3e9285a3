#include "strak/base/progress.h"

#include <gtest/gtest.h>

#include <string>

namespace strak {
namespace {

TEST(Progress, WithoutAListenerNeverStops) { EXPECT_TRUE(Progress().report(0.5, "half")); }

TEST(Progress, PassesTheReportOnAndTheWishToStopBack) {
  double fraction = 0;
  std::string message;
  const Progress progress([&](double f, std::string_view m) {
    fraction = f;
    message = m;
    return f < 0.7;
  });
  EXPECT_TRUE(progress.report(0.25, "a quarter"));
  EXPECT_EQ(fraction, 0.25);
  EXPECT_EQ(message, "a quarter");
  EXPECT_FALSE(progress.report(0.75, "more"));
}

}  // namespace
}  // namespace strak
