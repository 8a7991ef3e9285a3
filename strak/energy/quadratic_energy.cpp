#include "strak/energy/quadratic_energy.h"

#include <fmt/format.h>

#include <algorithm>
#include <cctype>
#include <charconv>
#include <cmath>

#include "strak/base/error.h"

namespace strak {

namespace {

template <int D>
std::array<int, D> derivativeOf(std::initializer_list<int> directions) {
  std::array<int, D> orders{};
  for (int k : directions) ++orders[static_cast<std::size_t>(k)];
  return orders;
}

// Adds c |D^a X|^2 to the energy, joined with an equal term if there is one.
template <int D>
void addSquare(QuadraticEnergy<D>& energy, double c, const std::array<int, D>& a) {
  for (auto& term : energy.terms) {
    if (term.a == a && term.b == a) {
      term.coefficient += c;
      return;
    }
  }
  energy.terms.push_back({c, a, a});
}

template <int D>
void append(QuadraticEnergy<D>& energy, double factor, const QuadraticEnergy<D>& other) {
  for (const auto& term : other.terms) {
    energy.terms.push_back({factor * term.coefficient, term.a, term.b});
  }
}

}  // namespace

template <int D>
int QuadraticEnergy<D>::order() const {
  int result = 0;
  for (const auto& term : terms) {
    int a = 0;
    int b = 0;
    for (std::size_t k = 0; k < D; ++k) {
      a += term.a[k];
      b += term.b[k];
    }
    result = std::max({result, a, b});
  }
  return result;
}

template <int D>
QuadraticEnergy<D> thinPlate() {
  QuadraticEnergy<D> energy{"thin-plate", {}};
  for (int k = 0; k < D; ++k) {
    for (int l = 0; l < D; ++l) addSquare<D>(energy, 1, derivativeOf<D>({k, l}));
  }
  return energy;
}

template <int D>
QuadraticEnergy<D> laplacian() {
  QuadraticEnergy<D> energy{"laplacian", {}};
  for (int k = 0; k < D; ++k) {
    for (int l = k; l < D; ++l) {
      energy.terms.push_back({k == l ? 1.0 : 2.0, derivativeOf<D>({k, k}), derivativeOf<D>({l, l})});
    }
  }
  return energy;
}

template <int D>
QuadraticEnergy<D> thirdOrder() {
  QuadraticEnergy<D> energy{"third-order", {}};
  for (int k = 0; k < D; ++k) addSquare<D>(energy, 1, derivativeOf<D>({k, k, k}));
  return energy;
}

template <int D>
QuadraticEnergy<D> laplacianGradient() {
  QuadraticEnergy<D> energy{"laplacian-gradient", {}};
  for (int m = 0; m < D; ++m) {
    for (int k = 0; k < D; ++k) {
      for (int l = k; l < D; ++l) {
        energy.terms.push_back({k == l ? 1.0 : 2.0, derivativeOf<D>({k, k, m}), derivativeOf<D>({l, l, m})});
      }
    }
  }
  return energy;
}

template <int D>
QuadraticEnergy<D> thirdDerivatives() {
  QuadraticEnergy<D> energy{"third-derivatives", {}};
  for (int k = 0; k < D; ++k) {
    for (int l = 0; l < D; ++l) {
      for (int m = 0; m < D; ++m) addSquare<D>(energy, 1, derivativeOf<D>({k, l, m}));
    }
  }
  return energy;
}

template <int D>
QuadraticEnergy<D> q3() {
  if (D == 1)
    throw InvalidInput("the energy 'q3' has mixed derivatives only and does not exist for curves: choose another");
  QuadraticEnergy<D> energy{"q3", {}};
  for (int k = 0; k < D; ++k) {
    for (int l = 0; l < D; ++l) {
      if (k != l) addSquare<D>(energy, 1, derivativeOf<D>({k, k, l}));
    }
  }
  return energy;
}

template <int D>
QuadraticEnergy<D> energyNamed(std::string_view text) {
  QuadraticEnergy<D> mixture{std::string(text), {}};
  std::string_view rest = text;
  while (true) {
    const std::size_t plus = rest.find('+');
    // "1e+3 * name" has a plus of its own.
    std::size_t end = plus;
    while (end != std::string_view::npos && end > 0 && (rest[end - 1] == 'e' || rest[end - 1] == 'E') && end > 1 &&
           std::isdigit(static_cast<unsigned char>(rest[end - 2]))) {
      end = rest.find('+', end + 1);
    }
    std::string part(rest.substr(0, end));
    std::erase_if(part, [](unsigned char c) { return std::isspace(c); });
    double factor = 1;
    std::string name = part;
    if (const auto star = part.find('*'); star != std::string::npos) {
      const std::string number = part.substr(0, star);
      name = part.substr(star + 1);
      const auto [stop, error] = std::from_chars(number.data(), number.data() + number.size(), factor);
      if (error != std::errc() || stop != number.data() + number.size() || !(factor > 0) || !std::isfinite(factor)) {
        throw InvalidInput(fmt::format(
            "'{}' in the energy '{}' is not a positive factor: write e.g. 0.01*third-derivatives", number, text));
      }
    }
    QuadraticEnergy<D> energy;
    if (name == "thin-plate") {
      energy = thinPlate<D>();
    } else if (name == "laplacian") {
      energy = laplacian<D>();
    } else if (name == "third-order") {
      energy = thirdOrder<D>();
    } else if (name == "laplacian-gradient") {
      energy = laplacianGradient<D>();
    } else if (name == "third-derivatives") {
      energy = thirdDerivatives<D>();
    } else if (name == "q3") {
      energy = q3<D>();
    } else {
      throw InvalidInput(
          fmt::format("there is no energy '{}': choose thin-plate, laplacian, third-order, laplacian-gradient, "
                      "third-derivatives or q3, or a mixture like thin-plate+0.01*third-derivatives",
                      name));
    }
    append(mixture, factor, energy);
    if (end == std::string_view::npos) break;
    rest.remove_prefix(end + 1);
  }
  return mixture;
}

#define STRAK_INSTANTIATE(D)                          \
  template struct QuadraticEnergy<D>;                 \
  template QuadraticEnergy<D> thinPlate<D>();         \
  template QuadraticEnergy<D> laplacian<D>();         \
  template QuadraticEnergy<D> thirdOrder<D>();        \
  template QuadraticEnergy<D> laplacianGradient<D>(); \
  template QuadraticEnergy<D> thirdDerivatives<D>();  \
  template QuadraticEnergy<D> q3<D>();                \
  template QuadraticEnergy<D> energyNamed<D>(std::string_view);
STRAK_INSTANTIATE(1)
STRAK_INSTANTIATE(2)
STRAK_INSTANTIATE(3)
#undef STRAK_INSTANTIATE

}  // namespace strak
