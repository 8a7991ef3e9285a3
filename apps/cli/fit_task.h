#pragma once
//
// `strak fit` of points, step by step.

#include <string>

#include "apps/cli/fit_normals.h"
#include "apps/cli/fit_points.h"
#include "apps/cli/fit_report.h"
#include "apps/cli/fit_trim.h"

namespace strak::cli {

// The options as given.
struct FitArguments {
  std::string input, output, kind, columns, degree = "3", size, domain, smoothing = "auto", noise, tolerance,
                                            share = "100", energy, scale = "auto", conditions, start, hold, loss = "l2",
                                            correct, mostPoints = "40000", memory = "512", threads;
  NormalArguments normals;
  TrimArguments trim;
  bool json = false, quiet = false;
  std::string commandLine;
};

// Fits the points of the file, writes the spline and returns what there is to tell.
template <int D>
FitReport fitAndWrite(const FitArguments& arguments, const PointFile& file, const FitColumns& columns);

}  // namespace strak::cli
