#pragma once
//
// `strak fit --normals`: prescribed normals, of fits and of surfaces that are there already.

#include <CLI/CLI.hpp>

#include "apps/cli/fit_points.h"
#include "apps/cli/json.h"

namespace strak::cli {

struct NormalArguments {
  std::string file, weight, angle = "0.001", hold;
  bool wanted() const { return !file.empty(); }
};

void addNormalOptions(CLI::App& command, NormalArguments& arguments);

// Turns the fit, made with `options` of this input, and measures its errors again. `correctionRounds`: of the
// parameters, 0 where the fit cannot be made again. Returns what there is to tell; what was not met is a warning.
Json turnNormals(const NormalArguments& arguments, const FitInput<2>& input, bool function, FitOptions<2> options,
                 int correctionRounds, Fit<2>& fit);

std::string describeNormals(const Json& normals);

// Whether the file holds splines, not points.
bool holdsSplines(const std::string& path);

struct SurfaceTask {
  std::string input, output, smoothing, commandLine;  // smoothing of the change, or "auto"
  bool json = false, quiet = false;
};

// Turns the only surface of such a file, which else stays as it is, writes the file and tells of it.
void turnSurface(const NormalArguments& arguments, const SurfaceTask& task);

}  // namespace strak::cli
