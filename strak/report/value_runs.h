#pragma once
//
// Measured points as coloured squares of a picture.

#include <vector>

#include "strak/report/picture.h"

namespace strak {

// Squares of the picture beside one another that have one colour, in whole pixels.
struct ValueRun {
  int x = 0, y = 0, width = 0, height = 0;
  int colour = 0;  // which of the steps of the colour map, lineCount() of them over the range
};

// The picture in squares of 3 to 7 pixels, the smaller the more points there are; of those with visible points the
// value that is farthest from zero; one without points between two with some has their mean. Squares of a row that have
// the same colour are one run.
std::vector<ValueRun> valueRuns(const Picture& picture, const RenderOptions& options, std::pair<double, double> range);

}  // namespace strak
