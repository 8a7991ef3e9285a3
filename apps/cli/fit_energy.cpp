#include "apps/cli/fit_energy.h"

#include <fmt/format.h>

#include "apps/cli/console.h"

namespace strak::cli {

Json followEnergy(InnerBending bending, FitOptions<2>& options, const EnergyFitMaker& make, Fit<2>& fit) {
  DataDependentOptions iteration;
  iteration.bending = bending;
  iteration.progress = options.progress;
  // `make` may change the options.
  const FitOptions<2> start = options;
  DataDependentFit followed = followDataDependentEnergy(fit, start, make, iteration);
  if (!followed.settled && !followed.fit.summary.stopped) {
    followed.fit.summary.warnings.push_back(
        fmt::format("the energy's geometry has not settled in {} rounds: the last moved the surface by {:.3g}{}",
                    followed.rounds, followed.changes.back(),
                    bending == InnerBending::beltrami
                        ? "; waves cost it nothing where points leave holes, but cost --energy data-dependent-plate"
                        : ""));
  }
  fit = std::move(followed.fit);
  options = std::move(followed.options);
  return {{"rounds", followed.rounds}, {"settled", followed.settled}, {"moves", followed.changes}};
}

std::string describeFollowing(const Json& following) {
  return fmt::format("geometry    {} after {} rounds, the last moved the surface by {}\n",
                     following["settled"].get<bool>() ? "settled" : "not settled", following["rounds"].dump(),
                     following["moves"].empty() ? "-" : number(following["moves"].back().get<double>()));
}

}  // namespace strak::cli
