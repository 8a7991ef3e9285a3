#include "apps/cli/fit_points.h"

#include <fmt/format.h>

#include <algorithm>
#include <limits>

#include "apps/cli/values.h"
#include "strak/base/error.h"
#include "strak/fitting/parametrization.h"
#include "strak/fitting/repeated_points.h"

namespace strak::cli {

namespace {

FitKind kindNamed(const std::string& word) {
  if (word == "function") return FitKind::function;
  if (word == "surface") return FitKind::surface;
  if (word == "curve") return FitKind::curve;
  throw InvalidInput(fmt::format("--kind cannot be '{}': choose function, surface or curve", word));
}

// The columns of these names, or the first ones from `first` on if the file names none.
std::vector<Index> columnsNamed(const PointFile& file, const std::vector<std::string>& names, Index first) {
  std::vector<Index> result;
  for (const auto& name : names) {
    const Index named = file.columnNamed(name);
    if (named >= 0) result.push_back(named);
  }
  if (result.size() == names.size()) return result;
  result.clear();
  for (std::size_t k = 0; k < names.size(); ++k) result.push_back(first + static_cast<Index>(k));
  if (result.back() >= file.columns()) {
    throw InvalidInput(
        fmt::format("the file has {} columns, but {} are needed ({}): give them, choose others with --columns, or take "
                    "another kind of spline",
                    file.columns(), result.back() + 1, fmt::join(names, ", ")));
  }
  return result;
}

bool areNeighbours(const std::vector<Index>& columns) {
  for (std::size_t k = 1; k < columns.size(); ++k) {
    if (columns[k] != columns[k - 1] + 1) return false;
  }
  return true;
}

Net chosen(const Net& block, const std::vector<Index>& columns) {
  if (areNeighbours(columns)) return block.middleCols(columns.front(), static_cast<Index>(columns.size()));
  Net result(block.rows(), static_cast<Index>(columns.size()));
  for (std::size_t k = 0; k < columns.size(); ++k) result.col(static_cast<Index>(k)) = block.col(columns[k]);
  return result;
}

}  // namespace

const char* kindName(FitKind kind) {
  return kind == FitKind::function ? "function" : kind == FitKind::surface ? "surface" : "curve";
}

PointFile pointFile(const std::filesystem::path& path, const std::string& columns) {
  PointFile file(path);
  if (columns.empty()) return file;
  const auto count = static_cast<std::size_t>(std::count(columns.begin(), columns.end(), ',')) + 1;
  std::vector<Index> chosen = wholeNumbers("--columns", columns, ',', 1, file.columns(), count);
  for (Index& column : chosen) --column;
  file.choose(chosen);
  return file;
}

FitColumns fitColumns(const PointFile& file, const std::string& kind) {
  FitColumns result;
  result.weight = file.columnNamed("weight") >= 0 ? file.columnNamed("weight") : file.columnNamed("w");
  const Index coordinates = file.columns() - (result.weight >= 0 ? 1 : 0);
  const bool hasParameters = file.columnNamed("u") >= 0 && file.columnNamed("v") >= 0;
  result.kind = !kind.empty()      ? kindNamed(kind)
                : hasParameters    ? FitKind::surface
                : coordinates == 2 ? FitKind::curve
                                   : FitKind::function;
  const std::vector<std::string> xyz{"x", "y", "z"};
  switch (result.kind) {
    case FitKind::function:
      if (coordinates == 2) {
        result.directions = 1;
        const auto xy = columnsNamed(file, {"x", "y"}, 0);
        result.parameters = {xy[0]};
        result.values = {xy[1]};
      } else {
        const auto all = columnsNamed(file, xyz, 0);
        result.parameters = {all[0], all[1]};
        result.values = {all[2]};
      }
      break;
    case FitKind::curve:
      result.directions = 1;
      if (file.columnNamed("t") >= 0) result.parameters = {file.columnNamed("t")};
      result.values = coordinates - static_cast<Index>(result.parameters.size()) == 2
                          ? columnsNamed(file, {"x", "y"}, 0)
                          : columnsNamed(file, xyz, 0);
      break;
    case FitKind::surface:
      if (hasParameters || (file.names().empty() && coordinates == 5)) {
        result.parameters = columnsNamed(file, {"u", "v"}, 0);
        result.values = columnsNamed(file, xyz, 2);
      } else {
        result.values = columnsNamed(file, xyz, 0);
      }
      break;
  }
  return result;
}

template <int D>
FitInput<D> fitInput(const PointFile& file, const FitColumns& columns, std::uintmax_t keptBytes) {
  FitInput<D> input;
  input.columns = static_cast<Index>(columns.values.size());
  input.streamed = file.bytes() > keptBytes;
  if (input.streamed && columns.parameters.empty()) {
    throw InvalidInput(
        fmt::format("the file has {} MB, too many for points that need parameters: thin them out, or use "
                    "--kind function",
                    file.bytes() >> 20));
  }
  if (input.streamed) {
    input.pass = [&file, columns](const std::function<void(const FitPoints<D>&)>& visit) {
      file.forEachBlock([&](const Net& block) {
        if (columns.weight < 0 && areNeighbours(columns.parameters) && areNeighbours(columns.values)) {
          // As they lie there: a copy would take as long as to read them.
          return visit({block.middleCols(columns.parameters.front(), D),
                        block.middleCols(columns.values.front(), static_cast<Index>(columns.values.size()))});
        }
        const Net parameters = chosen(block, columns.parameters), values = chosen(block, columns.values);
        if (columns.weight < 0) return visit({parameters, values});
        const Eigen::VectorXd weights = block.col(columns.weight);
        visit({parameters, values, weights});
      });
    };
  } else {
    const Net all = readPoints(file);
    input.values = chosen(all, columns.values);
    if (!columns.parameters.empty()) {
      input.parameters = chosen(all, columns.parameters);
    } else if (D == 1) {
      input.parameters = chordLengthParameters(input.values);
    } else {
      input.parameters = planeParameters(input.values);
    }
    if (columns.weight >= 0) input.weights = all.col(columns.weight);
    input.repeated = mergeRepeatedPoints(input.parameters, input.values, input.weights);
  }
  input.from.fill(std::numeric_limits<double>::infinity());
  input.to.fill(-std::numeric_limits<double>::infinity());
  const auto measure = [&](const FitPoints<D>& block) {
    input.count += block.count();
    for (std::size_t k = 0; k < D; ++k) {
      input.from[k] = std::min(input.from[k], block.parameters.col(static_cast<Index>(k)).minCoeff());
      input.to[k] = std::max(input.to[k], block.parameters.col(static_cast<Index>(k)).maxCoeff());
    }
  };
  if (input.streamed) {
    input.pass(measure);
  } else if (input.values.rows() > 0) {
    measure({input.parameters, input.values, input.weights});
  }
  if (input.count < 2) {
    throw InvalidInput(fmt::format("{} in the file: a fit needs at least two points, and many more to be of use",
                                   input.count == 0 ? "there is no point" : "there is a single point"));
  }
  return input;
}

template FitInput<1> fitInput<1>(const PointFile&, const FitColumns&, std::uintmax_t);
template FitInput<2> fitInput<2>(const PointFile&, const FitColumns&, std::uintmax_t);

}  // namespace strak::cli
