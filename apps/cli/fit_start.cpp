#include "apps/cli/fit_start.h"

#include <fmt/format.h>

#include "apps/cli/values.h"
#include "strak/base/error.h"
#include "strak/exchange/model.h"
#include "strak/fairing/held_points.h"
#include "strak/metrology/closest_points.h"
#include "strak/metrology/point_deviation.h"
#include "strak/spline/reparametrize.h"

namespace strak::cli {

namespace {

// The function whose graph the spline is: its first coordinates are its parameters. `where` names the file.
template <int D>
Spline<D> functionOf(const Spline<D>& graph, const std::string& where) {
  if (!isGraph<D>(graph)) {
    throw InvalidInput(
        fmt::format("{} is no graph of a function over its own parameters, as strak fit writes it: give such a "
                    "one, or --kind {}",
                    where, D == 1 ? "curve" : "surface"));
  }
  return {graph.knots(), Net(graph.net().col(D))};
}

}  // namespace

template <int D>
std::optional<Spline<D>> startSpline(const std::string& path, const FitColumns& columns) {
  if (path.empty()) return std::nullopt;
  const auto model = readModel(path);
  const bool function = columns.kind == FitKind::function;
  const Index dimension = static_cast<Index>(columns.values.size()) + (function ? D : 0);
  for (const Object& object : model->objects()) {
    const auto* spline = object.spline ? std::get_if<Spline<D>>(&*object.spline) : nullptr;
    if (spline == nullptr) continue;
    const std::string where = fmt::format("'{}' of '{}'", object.name, path);
    if (spline->isRational()) {
      throw InvalidInput(
          fmt::format("{} is rational, and a fit is not: strak convert --uniform-cubic makes it polynomial", where));
    }
    const Spline<D> start = clamped(*spline);
    // A file may keep curves of the plane in space.
    const bool flat = start.pointDimension() == dimension + 1 && start.net().rightCols(1).isZero(0);
    if (start.pointDimension() != dimension && !flat) {
      throw InvalidInput(fmt::format("{} has {} coordinates, but the points ask for {}: give another --start", where,
                                     start.pointDimension(), dimension));
    }
    const Spline<D> used(start.knots(), Net(start.net().leftCols(dimension)));
    return function ? functionOf<D>(used, where) : used;
  }
  throw InvalidInput(
      fmt::format("'{}' holds no B-spline {} to start from: see strak info", path, D == 1 ? "curve" : "surface"));
}

template <int D>
void holdBorder(const Spline<D>& start, const std::string& hold, FitOptions<D>& options) {
  const HeldPoints held = holdStrips<D>(start, rowsAtEnds<D>(holdRows(hold.empty() ? "1" : hold)));
  for (std::size_t r = 0; r < held.size(); ++r) {
    if (held[r] != 0) options.held.push_back(static_cast<Index>(r));
  }
  if (static_cast<Index>(options.held.size()) == start.net().rows()) {
    throw InvalidInput("--hold leaves no control point to fit: hold fewer rows");
  }
  options.heldNet = start.net();
}

template <int D>
void parametersOn(const Spline<D>& start, FitInput<D>& input) {
  input.parameters = closestPoints<D>(start, input.values).parameters;
}

template std::optional<Spline<1>> startSpline<1>(const std::string&, const FitColumns&);
template std::optional<Spline<2>> startSpline<2>(const std::string&, const FitColumns&);
template void holdBorder<1>(const Spline<1>&, const std::string&, FitOptions<1>&);
template void holdBorder<2>(const Spline<2>&, const std::string&, FitOptions<2>&);
template void parametersOn<1>(const Spline<1>&, FitInput<1>&);
template void parametersOn<2>(const Spline<2>&, FitInput<2>&);

}  // namespace strak::cli
