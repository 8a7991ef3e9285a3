#include "strak/fitting/data_dependent_fit.h"

#include <gtest/gtest.h>

#include <cstdio>

#include "strak/base/error.h"
#include "strak/fitting/robust_fit.h"
#include "strak/spline/evaluate.h"
#include "tests/fitting/franke.h"

namespace strak {
namespace {

std::array<KnotVector, 2> bicubic(Index size) {
  const KnotVector line = KnotVector::uniformClamped(3, size - 3, 0, 1);
  return {line, line};
}

TEST(DataDependentFit, Measure) {
  for (Index count : {2000, 20000}) {
    const Net points = test::frankePoints(count);
    const Net parameters = points.leftCols(2), values = points.rightCols(1);
    for (const auto& energy : {thinPlate<2>(), thirdDerivatives<2>()}) {
      FitOptions<2> options;
      options.energy = energy;
      const auto fit = fitLeastSquares<2>(bicubic(30), {parameters, values}, options);
      printf("%ld %s %g lambda %g\n", count, energy.name.c_str(), test::frankeError(fit.spline), fit.summary.lambda);
    }
    const auto dd = fitDataDependently(bicubic(30), 1, passOf<2>({parameters, values}));
    printf("%ld dd %g lambda %g rounds %d settled %d\n", count, test::frankeError(dd.fit.spline), dd.fit.summary.lambda, dd.rounds, dd.settled);
    for (double c : dd.changes) printf(" %g", c);
    printf("\n");
  }
}

}  // namespace
}  // namespace strak
