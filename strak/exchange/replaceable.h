#pragma once
//
// Whether a spline may take the place of another one in a file.

#include <optional>

#include "strak/exchange/model.h"

namespace strak {

// Throws InvalidInput unless 0 <= index < number of objects.
void requireIndex(Index index, const std::vector<Object>& objects);

// Throws InvalidInput unless `object` may be changed and `next` has the kind, dimension, domain and degrees of
// `original` (the spline that the file has); where the ends are not clamped also its knots among its own.
void requireReplaceable(const Object& object, const std::optional<AnySpline>& original, const AnySpline& next);

// Throws InvalidInput unless `object` may be changed and `next` has the kind, dimension and domain of its spline.
void requireSameDomain(const Object& object, const AnySpline& next);

}  // namespace strak
