#include "strak/fitting/steady_points.h"

#include <algorithm>
#include <cmath>

namespace strak {

namespace {

// What the running median of a steady point may be away: so many times what is usual, and so many steps.
constexpr double kUsual = 10, kSteps = 3;
constexpr Index kWindow = 2;  // neighbours on each side

double median(std::vector<double> values) {
  const auto middle = values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2);
  std::nth_element(values.begin(), middle, values.end());
  return *middle;
}

}  // namespace

std::vector<Index> steadyPoints(const Net& points) {
  const Index count = points.rows();
  std::vector<Index> rows;
  std::vector<double> away, steps;
  for (Index r = 0; r < count; ++r) {
    const Index from = std::clamp<Index>(r - kWindow, 0, std::max<Index>(count - 2 * kWindow - 1, 0));
    const Index to = std::min(from + 2 * kWindow + 1, count);
    double squares = 0;
    for (Index c = 0; c < points.cols(); ++c) {
      std::vector<double> window;
      for (Index k = from; k < to; ++k) window.push_back(points(k, c));
      const double d = points(r, c) - median(window);
      squares += d * d;
    }
    away.push_back(std::sqrt(squares));
    if (r > 0) steps.push_back((points.row(r) - points.row(r - 1)).norm());
  }
  if (steps.empty()) return std::vector<Index>(static_cast<std::size_t>(count), 0);
  const double most = kUsual * median(away) + kSteps * median(steps);
  for (Index r = 0; r < count; ++r) {
    if (away[static_cast<std::size_t>(r)] <= most) rows.push_back(r);
  }
  return rows;
}

Net spreadParameters(const std::vector<Index>& rows, const Net& parameters, Index count) {
  Net result(count, parameters.cols());
  std::size_t next = 0;  // of the rows, the first that is not before the point
  for (Index r = 0; r < count; ++r) {
    while (next < rows.size() && rows[next] < r) ++next;
    const std::size_t after = std::min(next, rows.size() - 1),
                      before = next == 0 || rows[after] <= r ? after : next - 1;
    const double way = static_cast<double>(rows[after] - rows[before]);
    const double t = way > 0 ? static_cast<double>(r - rows[before]) / way : 0;
    result.row(r) =
        (1 - t) * parameters.row(static_cast<Index>(before)) + t * parameters.row(static_cast<Index>(after));
  }
  return result;
}

}  // namespace strak
