#include "strak/exchange/json.h"

#include <nlohmann/json.hpp>

#include "tests/exchange/samples.h"

namespace strak {
namespace {

using namespace test;

const char* const kLine = R"({"strak": 1, "unit": "mm", "objects": [
  {"name": "rail", "kind": "curve", "degrees": [1], "knots": [[0, 0, 1, 1]], "points": [[0, 0, 0], [1, 2.5, 0]]}
]})";

TEST(JsonFormat, ReadsWhatItsPageSays) {
  const JsonContent content = parseJson(kLine);
  EXPECT_EQ(content.unit, "mm");
  ASSERT_EQ(content.objects.size(), 1U);
  EXPECT_EQ(content.objects[0].name, "rail");
  const Curve& curve = std::get<Curve>(*content.objects[0].spline);
  EXPECT_EQ(curve.degree(0), 1);
  EXPECT_EQ(curve.net()(1, 1), 2.5);
  EXPECT_FALSE(curve.isRational());
}

TEST(JsonFormat, RoundTripKeepsEveryBit) {
  std::mt19937 random(5);
  for (int trial = 0; trial < 30; ++trial) {
    const int dimension = 1 + static_cast<int>(random() % 4);
    const bool rational = random() % 2 == 0;
    JsonContent content;
    content.unit = "inch";
    content.objects = {{"a \"quoted\" n\xc3\xa4me", randomSpline<1>(random, dimension, rational), "", ""},
                       {"", randomSpline<2>(random, dimension, rational), "", ""},
                       {"block", randomSpline<3>(random, dimension, rational), "", ""}};
    const JsonContent back = parseJson(formatJson(content));
    EXPECT_EQ(back.unit, content.unit);
    ASSERT_EQ(back.objects.size(), 3U);
    for (std::size_t i = 0; i < 3; ++i) {
      EXPECT_EQ(back.objects[i].name, content.objects[i].name);
      EXPECT_EQ(*back.objects[i].spline, *content.objects[i].spline);
    }
  }
}

TEST(JsonFormat, BrokenNamesDoNotStopTheWriting) {
  std::mt19937 random(6);
  EXPECT_NO_THROW(parseJson(formatJson({{{"\xff\xfe", randomSpline<1>(random), "", ""}}, ""})));
}

TEST(JsonFormat, ErrorsNameTheLineOrTheObject) {
  const auto refused = [](std::string text, const std::string& from, const std::string& to) {
    text.replace(text.find(from), from.size(), to);
    return refusal([&] { parseJson(text); });
  };
  EXPECT_NE(refused(kLine, "\"curve\",", "\"curve\"").find("line 2"), std::string::npos);
  EXPECT_NE(refused(kLine, "\"strak\": 1", "\"strak\": 7").find("version"), std::string::npos);
  EXPECT_NE(refused(kLine, "\"strak\": 1, ", "").find("no splines of strak"), std::string::npos);
  EXPECT_NE(refused(kLine, "curve", "curl").find("object 1: \"kind\" is \"curl\""), std::string::npos);
  EXPECT_NE(refused(kLine, "[1, 2.5, 0]", "[1, 2.5]").find("point 2 has 2 coordinates"), std::string::npos);
  EXPECT_NE(refused(kLine, "2.5", "\"2.5\"").find("must be numbers"), std::string::npos);
  EXPECT_NE(refused(kLine, "2.5", "1e999").find("JSON"), std::string::npos);
  EXPECT_NE(refused(kLine, "[0, 0, 1, 1]", "[0, 2, 1, 1]").find("object 1"), std::string::npos);
  EXPECT_NE(refused(kLine, "\"degrees\": [1]", "\"degrees\": [1e9]").find("whole numbers"), std::string::npos);
  EXPECT_NE(refused(kLine, "\"degrees\": [1]", "\"degrees\": [-1]").find("whole numbers"), std::string::npos);
}

TEST(JsonFormat, DeepNestingAndMutationsAreRefusedWithoutACrash) {
  EXPECT_FALSE(refusal([] { parseJson(std::string(200000, '[')); }).empty());
  std::mt19937 random(8);
  const std::string text = formatJson({{{"s", randomSpline<2>(random), "", ""}}, "mm"});
  int refused = 0;
  for (int trial = 0; trial < 1500; ++trial) {
    try {
      parseJson(mutated(text, random));
    } catch (const InvalidInput&) {
      ++refused;
    }
  }
  EXPECT_GT(refused, 500);
}

}  // namespace
}  // namespace strak
