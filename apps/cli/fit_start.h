#pragma once
//
// strak fit --start FILE --hold ROWS: a given spline is where the fit begins; rows of its border stay.

#include <optional>
#include <string>

#include "apps/cli/fit_points.h"

namespace strak::cli {

// The spline of the file for a fit of that kind with so many coordinates: the first curve or surface there, of a
// function the heights over its parameters. Nothing if `path` is empty. Throws InvalidInput if there is none, it is
// rational, has another dimension, or for a function is no graph (as `strak fit` writes it).
template <int D>
std::optional<Spline<D>> startSpline(const std::string& path, const FitColumns& columns);

// Holds the rows (`hold` as in holdRows(), empty: one everywhere) of `start` in the fit.
template <int D>
void holdBorder(const Spline<D>& start, const std::string& hold, FitOptions<D>& options);

// Points that came without parameters get those of their closest points on `start`.
template <int D>
void parametersOn(const Spline<D>& start, FitInput<D>& input);

}  // namespace strak::cli
