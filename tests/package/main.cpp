// Fairs a small noisy surface with the installed library; prints the energies and returns 0 if the certificate holds.
#include <strak/fairing/optimal_fairing.h>

#include <cstdio>

int main() {
  const auto knots = strak::KnotVector::uniformClamped(3, 9);
  strak::Net net(144, 3);
  for (int i = 0; i < 12; ++i) {
    for (int j = 0; j < 12; ++j) net.row(i * 12 + j) << i, j, 0.1 * ((i * 7 + j * 5) % 3);
  }
  const strak::Surface surface({knots, knots}, net);
  strak::OptimalFairingOptions options;
  options.tolerance = 0.1;
  options.held = strak::holdStrips<2>(surface, {2, 2, 2, 2});
  const auto faired = strak::fairOptimally<2>(surface, strak::thinPlate<2>(), options);
  std::printf("energy %g -> %g, certified gap %g\n", faired.summary.energyBefore, faired.summary.energyAfter,
              faired.summary.gap);
  return faired.summary.gap <= 1e-6 && faired.summary.energyAfter < faired.summary.energyBefore ? 0 : 1;
}
