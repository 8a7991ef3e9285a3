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

// The range of a colour map for the values: without the lowest and highest percent, around zero as its middle if there
// are values of both signs, never empty.
std::pair<double, double> mapRange(std::vector<double> values);

// The values at the given fractions of the sorted list (0: least, 1: largest). The list must not be empty.
std::pair<double, double> quantiles(std::vector<double> values, double low, double high);

// About `count` round numbers inside the range, ascending.
std::vector<double> roundTicks(std::pair<double, double> range, int count);

}  // namespace strak
