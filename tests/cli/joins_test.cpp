// What info and fair say about the edges where faces meet.

#include "strak/spline/reparametrize.h"
#include "tests/cli/program.h"

namespace strak::test {
namespace {

class Joins : public Program {
 protected:
  // One surface cut into two along u, the second one perhaps lifted at its far end: a kink at the cut.
  std::string twoHalves(double lift) const {
    const Surface whole = wavySurface(3, 12, 10);
    const Surface left = subPatch(whole, 0, 0, 0.5);
    Surface right = subPatch(whole, 0, 0.5, 1);
    for (Index i = 1; i < right.size(0); ++i) {
      for (Index j = 0; j < right.size(1); ++j) right.net()(right.row({i, j}), 2) += lift * static_cast<double>(i);
    }
    return write("halves.g2", g2(left) + g2(right));
  }
};

TEST_F(Joins, InfoCountsThemByKind) {
  const Outcome smooth = strak({"info", twoHalves(0)});
  EXPECT_EQ(smooth.code, 0);
  EXPECT_NE(smooth.out.find("1 join: 1 G2;"), std::string::npos) << smooth.out;
  const Outcome kinked = strak({"info", twoHalves(0.002)});
  EXPECT_NE(kinked.out.find("1 join: 1 G0;"), std::string::npos) << kinked.out;
  EXPECT_NE(strak({"info", twoHalves(1)}).out.find("1 feature"), std::string::npos);
  write("one.g2", g2(wavySurface(3, 12, 10)));
  EXPECT_EQ(strak({"info", path("one.g2")}).out.find("join"), std::string::npos);
  const auto joins = json({"info", twoHalves(0.002)}).at("joins");
  ASSERT_EQ(joins.size(), 1U);
  EXPECT_EQ(joins[0].at("faces"), nlohmann::json({1, 2}));
  EXPECT_GT(joins[0].at("angle").get<double>(), 0.1);
  EXPECT_LT(joins[0].at("gap").get<double>(), 1e-12);
}

TEST_F(Joins, FairReportsThemBeforeAndAfter) {
  const std::string input = twoHalves(0.002);
  const auto joins = json({"fair", input, "-o", path("out.g2"), "--tolerance", "0.01"}).at("joins");
  ASSERT_EQ(joins.size(), 1U);
  const auto before = json({"info", input}).at("joins"), after = json({"info", path("out.g2")}).at("joins");
  for (const char* key : {"gap", "angle", "curvature"}) {
    EXPECT_EQ(joins[0].at(key).at("before"), before[0].at(key)) << key;
    EXPECT_NEAR(joins[0].at(key).at("after").get<double>(), after[0].at(key).get<double>(), 1e-9) << key;
  }
  const Outcome text = strak({"fair", input, "-o", path("out.g2"), "--tolerance", "0.01"});
  EXPECT_NE(text.out.find("1 join: largest angle"), std::string::npos) << text.out;
}

}  // namespace
}  // namespace strak::test
