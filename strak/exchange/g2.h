#pragma once
//
// The text format .g2 of GoTools: B-spline curves (class 100), surfaces (200) and volumes (700), rational ones too, any
// number of objects in a file. Numbers are written with 17 digits, so what is written is read back to the bit.

#include <string>
#include <string_view>
#include <vector>

#include "strak/exchange/plain_object.h"

namespace strak {

// The objects of a .g2 text in their order. Objects of other classes (point clouds, trimmed surfaces, ...) are kept as
// text, up to the next line that looks like the head of an object.
// Throws InvalidInput that names the line. Never allocates more than the text can fill.
std::vector<PlainObject> parseG2(std::string_view text);

// Whether a text begins with a point cloud (class 400) and is not a table that happens to begin with the same numbers.
bool beginsWithG2Cloud(std::string_view text);

// The points of all point clouds of a .g2 text, x, y, z a row; other objects are passed over. Throws InvalidInput that
// names the line, and if there is no point cloud.
Net parseG2Clouds(std::string_view text);

// The text of `objects`; kept texts are repeated as they were. Throws InvalidInput for a kept text of another format.
std::string formatG2(const std::vector<PlainObject>& objects);

}  // namespace strak
