#include "strak/report/colour_map.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

namespace strak {

const std::vector<Colour>& colourAnchors() {
  static const std::vector<Colour> anchors{{35, 62, 130},   {58, 113, 176},  {128, 176, 211},
                                           {200, 221, 232}, {246, 244, 239}, {241, 208, 180},
                                           {221, 144, 105}, {186, 76, 62},   {120, 24, 40}};
  return anchors;
}

Colour mapColour(double t) {
  const auto& anchors = colourAnchors();
  const double place = std::clamp(t, 0.0, 1.0) * static_cast<double>(anchors.size() - 1);
  const auto below = std::min(static_cast<std::size_t>(place), anchors.size() - 2);
  const double part = place - static_cast<double>(below);
  Colour colour{};
  for (std::size_t k = 0; k < 3; ++k)
    colour[k] = static_cast<int>(std::lround(anchors[below][k] * (1 - part) + anchors[below + 1][k] * part));
  return colour;
}

std::string hexColour(const Colour& c) { return fmt::format("#{:02x}{:02x}{:02x}", c[0], c[1], c[2]); }

std::pair<double, double> quantiles(std::vector<Weighted> values, double low, double high) {
  std::sort(values.begin(), values.end(), [](const Weighted& a, const Weighted& b) { return a.value < b.value; });
  double whole = 0;
  for (const Weighted& v : values) whole += v.weight;
  const auto at = [&](double fraction) {
    double sum = 0;
    for (const Weighted& v : values) {
      sum += v.weight;
      if (sum >= fraction * whole && sum > 0) return v.value;
    }
    return 0.0;
  };
  return {at(low), at(high)};
}

std::pair<double, double> mapRange(std::vector<Weighted> values) {
  auto [low, high] = quantiles(std::move(values), 0.01, 0.99);
  const double largest = std::max(std::abs(low), std::abs(high));
  if (largest == 0) return {-1, 1};
  if (low < 0 && high > 0) return {-largest, largest};
  // Nearly constant values: a range of a thousandth shows them as what they are.
  const double least = 1e-3 * largest;
  if (high - low < least) return {(low + high - least) / 2, (low + high + least) / 2};
  return {low, high};
}

std::vector<double> roundTicks(std::pair<double, double> range, int count) {
  const double raw = (range.second - range.first) / std::max(count, 1);
  if (!(raw > 0) || !std::isfinite(raw)) return {};
  const double power = std::pow(10.0, std::floor(std::log10(raw)));
  double step = 10 * power;
  for (double factor : {1.0, 2.0, 5.0})
    if (factor * power >= raw * 0.999) {
      step = factor * power;
      break;
    }
  std::vector<double> ticks;
  for (double k = std::ceil(range.first / step - 1e-9); k * step <= range.second + 1e-9 * step; ++k)
    ticks.push_back(k == 0 ? 0.0 : k * step);
  return ticks;
}

}  // namespace strak
