#pragma once
//
// Surfaces measured by interferometers: MetroPro files (.dat), a header of 834 or 4096 bytes, the intensities of the
// camera and the phases.

#include <string_view>

#include "strak/spline/spline.h"

namespace strak {

// Whether the file begins as MetroPro's do (88 1B 03 and 6F, 70 or 71).
bool isInterferogram(std::string_view head);

// A row x, y, z a valid sample, line by line from above. The height is
//   phase * scale * obliquity * wavelength / resolution (4096, 32768 or 131072 to the wave);
// all in millimetres, y upwards, the last line at y = 0; x and y count samples where the lateral resolution is not
// calibrated (zero). Throws InvalidInput, without the file's name, for damaged files and such without phases.
Net interferogramHeights(std::string_view bytes);

}  // namespace strak
