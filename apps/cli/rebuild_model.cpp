#include "apps/cli/rebuild_model.h"

#include <fmt/format.h>

#include <algorithm>
#include <limits>

#include "apps/cli/console.h"
#include "apps/cli/values.h"
#include "strak/base/error.h"
#include "strak/fairing/rebuild.h"

namespace strak::cli {

namespace {

std::vector<Index> numbersOf(const std::string& wish) {
  std::vector<Index> numbers;
  for (std::size_t from = 0; from <= wish.size();) {
    const std::size_t comma = std::min(wish.find(',', from), wish.size());
    numbers.push_back(wholeNumber("--rebuild", wish.substr(from, comma - from), 1));
    from = comma + 1;
  }
  if (numbers.size() != 2 && numbers.size() != 4 && numbers.size() != 6) {
    throw InvalidInput(
        fmt::format("--rebuild '{}' is not understood: give DEGREE,SPANS, or one of each a direction, like "
                    "DU,DV,SU,SV",
                    wish));
  }
  return numbers;
}

template <int D>
RebuildOptions<D> optionsFor(const std::vector<Index>& numbers, const std::string& name) {
  if (numbers.size() != 2 && numbers.size() != 2 * D) {
    throw InvalidInput(fmt::format("--rebuild gives {} numbers, but '{}' has {} direction{}: give DEGREE,SPANS",
                                   numbers.size(), name, D, D == 1 ? "" : "s"));
  }
  RebuildOptions<D> options;
  for (std::size_t k = 0; k < D; ++k) {
    constexpr Index kTooHigh = 1000;  // the library names the limit
    options.degree[k] = static_cast<int>(std::min(numbers.size() == 2 ? numbers[0] : numbers[k], kTooHigh));
    options.spans[k] = numbers.size() == 2 ? numbers[1] : numbers[D + k];
  }
  return options;
}

}  // namespace

RebuiltModel rebuildModel(const Model& model, const std::string& wish, const std::string& tolerance) {
  const std::vector<Index> numbers = numbersOf(wish);
  const double most =
      tolerance.empty() ? std::numeric_limits<double>::infinity() : lengthOf("--tolerance", tolerance, model.size());
  RebuiltModel result;
  std::vector<AnySpline> splines;
  std::vector<std::string> names;
  for (const Object& object : model.objects()) {
    if (!object.spline) continue;
    std::visit(
        [&]<int D>(const Spline<D>& original) {
          auto rebuilt = rebuild(original, optionsFor<D>(numbers, object.name));
          const std::string unit = model.unit().empty() ? "" : " " + model.unit();
          if (rebuilt.deviation.upper > most) {
            throw Failure(
                fmt::format("'{}' rebuilt with --rebuild {} would be up to {}{} away, above the tolerance {}{}: give a "
                            "higher degree "
                            "or more spans",
                            object.name, wish, number(rebuilt.deviation.upper), unit, number(most), unit));
          }
          result.objects.push_back({object.name, rebuilt.deviation.lower, rebuilt.deviation.upper});
          splines.emplace_back(std::move(rebuilt.spline));
          names.push_back(object.name);
        },
        *object.spline);
  }
  if (splines.empty()) throw InvalidInput("the file holds no splines to rebuild");
  result.model = modelOf(std::move(splines), std::move(names), model.unit());
  return result;
}

}  // namespace strak::cli
