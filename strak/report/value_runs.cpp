#include "strak/report/value_runs.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>

namespace strak {

namespace {

constexpr double kSmallest = 3, kLargest = 7;  // pixels a square
constexpr int kPasses = 2;                     // gaps two squares wide are closed crosswise

// An empty square between two opposite neighbours with values gets their mean: points at wider steps than the squares
// would else make a pattern of their own.
void closeGaps(std::vector<double>& values, int columns, int rows) {
  const std::vector<double> had = values;
  const auto at = [&](int column, int row) -> double {
    if (column < 0 || column >= columns || row < 0 || row >= rows) return std::numeric_limits<double>::quiet_NaN();
    return had[static_cast<std::size_t>(row) * static_cast<std::size_t>(columns) + static_cast<std::size_t>(column)];
  };
  constexpr int kSteps[4][2] = {{1, 0}, {0, 1}, {1, 1}, {1, -1}};
  for (int row = 0; row < rows; ++row) {
    for (int column = 0; column < columns; ++column) {
      double& value =
          values[static_cast<std::size_t>(row) * static_cast<std::size_t>(columns) + static_cast<std::size_t>(column)];
      for (const auto& step : kSteps) {
        if (!std::isnan(value)) break;
        value = std::midpoint(at(column - step[0], row - step[1]), at(column + step[0], row + step[1]));
      }
    }
  }
}

}  // namespace

std::vector<ValueRun> valueRuns(const Picture& picture, const RenderOptions& options, std::pair<double, double> range) {
  const double area = 0.5 * options.width * options.height;
  const double perPoint = std::sqrt(area / static_cast<double>(std::max<Index>(options.points.rows(), 1)));
  const int side = static_cast<int>(std::clamp(perPoint, kSmallest, kLargest));
  const int columns = (options.width + side - 1) / side, rows = (options.height + side - 1) / side;
  constexpr double kNone = std::numeric_limits<double>::quiet_NaN();
  std::vector<double> values(static_cast<std::size_t>(columns) * static_cast<std::size_t>(rows), kNone);
  for (Index r = 0; r < options.points.rows(); ++r) {
    if (!std::isfinite(options.values[r])) continue;
    const Eigen::Vector3d p = picture.camera.project(options.points.row(r).transpose());
    const double column = std::floor(p.x() / side), row = std::floor(p.y() / side);
    if (!(column >= 0 && column < columns && row >= 0 && row < rows)) continue;
    if (options.hideLines && !picture.depth.visible(p)) continue;
    double& value =
        values[static_cast<std::size_t>(row) * static_cast<std::size_t>(columns) + static_cast<std::size_t>(column)];
    if (!(std::abs(value) >= std::abs(options.values[r]))) value = options.values[r];
  }
  for (int pass = 0; pass < kPasses; ++pass) closeGaps(values, columns, rows);
  const int colours = lineCount(options, picture.scene);
  const auto colourOf = [&](double value) {
    if (std::isnan(value)) return -1;
    const double place = (value - range.first) / (range.second - range.first) * colours;
    return static_cast<int>(std::clamp(place, 0.0, colours - 0.5));
  };
  std::vector<ValueRun> runs;
  for (int row = 0; row < rows; ++row) {
    int before = -1;
    for (int column = 0; column < columns; ++column) {
      const double value =
          values[static_cast<std::size_t>(row) * static_cast<std::size_t>(columns) + static_cast<std::size_t>(column)];
      const int colour = colourOf(value);
      if (colour >= 0 && colour == before) {
        runs.back().width += side;
      } else if (colour >= 0) {
        runs.push_back({column * side, row * side, side, side, colour});
      }
      before = colour;
    }
  }
  return runs;
}

}  // namespace strak
