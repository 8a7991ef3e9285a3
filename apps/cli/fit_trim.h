#pragma once
//
// `strak fit --trim`: the borders of the cloud as trimming curves of the surface.

#include <CLI/CLI.hpp>
#include <string>
#include <vector>

#include "apps/cli/json.h"
#include "strak/fitting/normal_equations.h"

namespace strak::cli {

struct TrimArguments {
  std::string gap, tolerance;  // as given: "" for no trimming, "auto" or a length
};

void addTrimOptions(CLI::App& command, TrimArguments& arguments);

// Throws InvalidInput if trimming is asked for and the output cannot hold it, or for a curve.
void requireTrimmable(const TrimArguments& arguments, const std::string& output, int directions);

// Writes the surface with a face for each part of the points with these parameters, reads the file again and checks it.
// `function`: the graph of one, whose parameters are lengths; other parameters count with the median length of a unit
// at the points, and a tolerance is kept in space. Adds to the warnings what is worth a word; returns what the report
// says.
Json writeTrimmedFit(const TrimArguments& arguments, const std::string& output, const Surface& surface,
                     const Eigen::Ref<const Net>& parameters, bool function, const std::string& name,
                     std::vector<std::string>& warnings);

void printTrimming(const Json& trimming);

}  // namespace strak::cli
