#pragma once
//
// The colours of maps: blue below, pale in the middle, red above; told apart also by those who see no red or green.

#include <array>
#include <string>
#include <utility>
#include <vector>

namespace strak {

using Colour = std::array<int, 3>;  // red, green, blue, 0 to 255

// The colours at evenly spaced places that the map runs through.
const std::vector<Colour>& colourAnchors();

// The colour at t in [0, 1].
Colour mapColour(double t);
std::string hexColour(const Colour& colour);  // "#rrggbb"

// A number that counts as much as the area (or length) it stands for.
struct Weighted {
  double value = 0, weight = 1;
};

// The values below which the given fractions of the weight lie, e.g. 0.01 and 0.99. Zero and zero without weight.
std::pair<double, double> quantiles(std::vector<Weighted> values, double low, double high);

// The range of a colour map for the values: without the lowest and highest percent, around zero as its middle if there
// are values of both signs, never empty.
std::pair<double, double> mapRange(std::vector<Weighted> values);

// About `count` round numbers inside the range, ascending.
std::vector<double> roundTicks(std::pair<double, double> range, int count);

}  // namespace strak
