#include "apps/cli/fit_conditions.h"

#include <fmt/format.h>

#include <algorithm>

#include "strak/base/error.h"

namespace strak::cli {

template <int D>
Net takeConditions(const ConditionArguments& arguments, const FitColumns& columns, FitOptions<D>& options) {
  if (arguments.file.empty()) return {};
  const PointFile file = pointFile(arguments.file, arguments.columns);
  const FitColumns own = fitColumns(file, kindName(columns.kind));
  const bool placed = own.parameters.empty();
  if (own.values.size() != columns.values.size() || own.directions != columns.directions ||
      (!placed && columns.parameters.empty())) {
    throw InvalidInput(fmt::format("'{}' must have the same columns as '{}'", arguments.file, arguments.points));
  }
  const Net rows = readPoints(file);
  const auto chosen = [&](const std::vector<Index>& numbers) {
    Net result(rows.rows(), static_cast<Index>(numbers.size()));
    for (std::size_t k = 0; k < numbers.size(); ++k) result.col(static_cast<Index>(k)) = rows.col(numbers[k]);
    return result;
  };
  if (placed) return chosen(own.values);
  options.conditionParameters = chosen(own.parameters);
  options.conditionValues = chosen(own.values);
  return {};
}

template <int D>
void includeConditions(const FitOptions<D>& options, FitInput<D>& input) {
  if (options.conditionParameters.rows() == 0) return;
  for (std::size_t k = 0; k < D; ++k) {
    const auto places = options.conditionParameters.col(static_cast<Index>(k));
    input.from[k] = std::min(input.from[k], places.minCoeff());
    input.to[k] = std::max(input.to[k], places.maxCoeff());
  }
}

template Net takeConditions<1>(const ConditionArguments&, const FitColumns&, FitOptions<1>&);
template Net takeConditions<2>(const ConditionArguments&, const FitColumns&, FitOptions<2>&);
template void includeConditions<1>(const FitOptions<1>&, FitInput<1>&);
template void includeConditions<2>(const FitOptions<2>&, FitInput<2>&);

}  // namespace strak::cli
