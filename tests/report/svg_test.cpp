#include "strak/report/svg.h"

#include <gtest/gtest.h>
#include <rapidcheck.h>
#include <rapidcheck/gtest.h>

#include <algorithm>
#include <cmath>

#include "strak/report/colour_map.h"
#include "tests/report/shapes.h"

namespace strak {
namespace {

TEST(Svg, TextIsSafeAndValid) {
  EXPECT_EQ(escaped("a<b> & \"c\" 'd'"), "a&lt;b&gt; &amp; &quot;c&quot; &#39;d&#39;");
  EXPECT_EQ(escaped("M\xC3\xBCller \xE2\x82\xAC"), "M\xC3\xBCller \xE2\x82\xAC");
  EXPECT_EQ(escaped("bad \xFF\xC3 end\x01"), "bad \xEF\xBF\xBD\xEF\xBF\xBD end\xEF\xBF\xBD");
}

RC_GTEST_PROP(Svg, AnyBytesMakeAWellFormedDocument, (const std::string& text)) {
  SvgWriter svg(100, 50, text);
  svg.open("fill=\"none\"");
  svg.text(1, 2, text, "font-size=\"9\"");
  svg.close();
  RC_ASSERT(test::xmlFault(std::move(svg).finish()) == "");
}

TEST(Svg, NumbersAreShort) {
  EXPECT_EQ(shortNumber(1.0), "1");
  EXPECT_EQ(shortNumber(-0.001), "0");
  EXPECT_EQ(shortNumber(1234.5678), "1234.57");
  EXPECT_EQ(figure(0.0000123), "1.23\u00B710\u207B\u2075");
  EXPECT_EQ(figure(-2.5), "\u22122.5");
  EXPECT_EQ(figure(std::nan("")), "\u2013");
}

double distanceToSegment(const Eigen::Vector2d& p, const Eigen::Vector2d& a, const Eigen::Vector2d& b) {
  const Eigen::Vector2d d = b - a;
  const double t = d.squaredNorm() > 0 ? std::clamp((p - a).dot(d) / d.squaredNorm(), 0.0, 1.0) : 0;
  return (a + t * d - p).norm();
}

// The least distance of a point from a path of cubic Bezier curves, lines and moves.
double distanceToPath(const Eigen::Vector2d& point, const std::string& path) {
  double least = 1e9;
  Eigen::Vector2d last(0, 0);
  std::vector<double> numbers;
  char command = 'M';
  const auto flush = [&] {
    const auto p = [&](std::size_t i) { return Eigen::Vector2d(numbers[2 * i], numbers[2 * i + 1]); };
    if (command == 'C') {
      Eigen::Vector2d before = last;
      for (int k = 1; k <= 50; ++k) {
        const double t = k / 50.0, r = 1 - t;
        const Eigen::Vector2d x =
            last * (r * r * r) + p(0) * (3 * r * r * t) + p(1) * (3 * r * t * t) + p(2) * (t * t * t);
        least = std::min(least, distanceToSegment(point, before, x));
        before = x;
      }
    } else if (command == 'L') {
      least = std::min(least, distanceToSegment(point, last, p(0)));
    }
    if (!numbers.empty()) last = p(numbers.size() / 2 - 1);
    numbers.clear();
  };
  for (std::size_t i = 0; i < path.size();) {
    if (std::isalpha(static_cast<unsigned char>(path[i]))) {
      flush();
      command = path[i++];
    } else if (path[i] == ' ') {
      ++i;
    } else {
      std::size_t used = 0;
      numbers.push_back(std::stod(path.substr(i, 24), &used));
      i += used;
    }
  }
  flush();
  return least;
}

RC_GTEST_PROP(Svg, SmoothPathsStayWithATenthOfAPixel, ()) {
  const double a = *rc::gen::inRange(1, 60), b = *rc::gen::inRange(1, 9), corner = *rc::gen::inRange(0, 100);
  PicturePolyline line;
  for (int i = 0; i <= 160; ++i)
    line.emplace_back(2.0 * i, 100 + a * std::sin(b * i / 40.0) + std::max(0.0, i - corner) * 1.5);
  const std::string path = smoothPath(line);
  for (std::size_t i = 0; i < line.size(); i += 7) RC_ASSERT(distanceToPath(line[i], path) < 0.1);
  RC_ASSERT(path.size() < 40 * line.size());
  // No loops or spikes between the points either.
  double length = 0;
  for (std::size_t i = 1; i < line.size(); ++i) length += (line[i] - line[i - 1]).norm();
  RC_ASSERT(test::pathSize("class=\"x\" d=\"" + path + "\"", "x").length < 1.01 * length + 0.1);
}

TEST(Svg, UnevenlySpacedPointsMakeNoSpikes) {
  // A line that the tracer of isophotes left: long steps beside short ones.
  for (double step : {0.02, 0.3, 2.0, 9.0}) {
    PicturePolyline line;
    double x = 0;
    for (int i = 0; i < 120; ++i) {
      x += i % 7 == 0 ? step : i % 3 == 0 ? 11.0 : 0.7;
      line.emplace_back(x, 40 * std::exp(-x * x / 2e4) + 1e-3 * (i % 2));
    }
    double length = 0;
    for (std::size_t i = 1; i < line.size(); ++i) length += (line[i] - line[i - 1]).norm();
    const std::string path = smoothPath(line);
    EXPECT_LT(test::pathSize("class=\"x\" d=\"" + path + "\"", "x").length, 1.01 * length) << step;
    for (const auto& p : line) EXPECT_LT(distanceToPath(p, path), 0.1);
  }
}

TEST(Svg, AHalfCircleNeedsFewCurves) {
  PicturePolyline line;
  for (int i = 0; i <= 200; ++i) line.emplace_back(300 * std::cos(M_PI * i / 200), 300 * std::sin(M_PI * i / 200));
  const std::string path = smoothPath(line);
  EXPECT_LE(std::count(path.begin(), path.end(), 'C'), 4);
  for (const auto& p : line) EXPECT_LT(distanceToPath(p, path), 0.1);
}

TEST(ColourMap, RangesLeaveOutOutliersAndKeepZeroInTheMiddle) {
  std::vector<Weighted> values;
  for (int i = 0; i <= 1000; ++i) values.push_back({i / 1000.0 - 0.25, 1});
  values.push_back({1e9, 1});
  const auto [low, high] = mapRange(values);
  EXPECT_DOUBLE_EQ(low, -high);
  EXPECT_NEAR(high, 0.74, 0.01);
  const auto [flatLow, flatHigh] = mapRange({{5, 1}, {5, 1}});
  EXPECT_LT(flatLow, 5);
  EXPECT_GT(flatHigh, 5);
  EXPECT_EQ(mapRange({}), std::pair(-1.0, 1.0));
}

TEST(ColourMap, WeightsCount) { EXPECT_EQ(quantiles({{1, 98}, {2, 1}, {3, 1}}, 0.5, 0.985), std::pair(1.0, 2.0)); }

TEST(ColourMap, TicksAreRoundAndInside) {
  EXPECT_EQ(roundTicks({-1, 1}, 5), (std::vector<double>{-1, -0.5, 0, 0.5, 1}));
  for (double tick : roundTicks({0.0131, 0.0478}, 6)) {
    EXPECT_GE(tick, 0.0131);
    EXPECT_LE(tick, 0.0478);
  }
}

}  // namespace
}  // namespace strak
