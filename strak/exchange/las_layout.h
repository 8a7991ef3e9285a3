#pragma once
//
// Point clouds of laser scanners (LAS 1.0 to 1.4): a binary head, then records that begin with x, y and z as integers.

#include "strak/exchange/cloud_layout.h"

namespace strak {

// The places of x, y and z, unscaled by the head's factors and offsets; what else a record holds (intensity, return,
// class) is passed by. Nothing if `head` does not begin as a LAS file. Throws InvalidInput, without the file's name, if
// the head is damaged or the points are compressed (LAZ).
//
// Source: ASPRS, LAS Specification 1.4 - R15, 2.4 (Public Header Block).
std::optional<CloudLayout> lasLayout(std::string_view head);

}  // namespace strak
