#include "strak/spline/evaluate_kernels.h"

#include <gtest/gtest.h>

#include "strak/base/cpu.h"
#include "strak/spline/basis_table.h"
#include "tests/spline/random_splines.h"

namespace strak {
namespace {

using strak::testing::Random;

// The kernels of one instruction set.
struct Kernels {
  const char* name;
  decltype(&generic::basisWeights) basisWeights;
  decltype(&generic::contractPoints) contractPoints;
  decltype(&generic::contractLines) contractLines;
  decltype(&generic::contractLast) contractLast;
};

std::vector<Kernels> availableKernels() {
  std::vector<Kernels> result{
      {"generic", &generic::basisWeights, &generic::contractPoints, &generic::contractLines, &generic::contractLast}};
#ifdef STRAK_HAS_X86_SIMD
  if (simdLevel() >= SimdLevel::avx2) {
    result.push_back({"avx2", &avx2::basisWeights, &avx2::contractPoints, &avx2::contractLines, &avx2::contractLast});
  }
  if (simdLevel() >= SimdLevel::avx512) {
    result.push_back(
        {"avx512", &avx512::basisWeights, &avx512::contractPoints, &avx512::contractLines, &avx512::contractLast});
  }
#endif
  return result;
}

// The basis functions of a knot vector on one span as powers, as the kernels want them: only one span, so that this
// test stands on its own.
struct OneSpan {
  std::vector<double> coefficients;
  double starts[2] = {-1, 1};
  double centre = 0;
  double scale = 1;
  std::ptrdiff_t first = 0;
  std::ptrdiff_t buckets[2] = {0, 0};
  BasisView view;

  OneSpan(Random& random, int degree) : view() {
    const int width = (degree + 4) / 4 * 4;
    coefficients.assign(static_cast<std::size_t>((degree + 1) * width), 0.0);
    for (int power = 0; power <= degree; ++power) {
      for (int j = 0; j <= degree; ++j)
        coefficients[static_cast<std::size_t>(power * width + j)] = random.uniform(-1, 1);
    }
    view = {degree, width, starts, &first, &centre, &scale, coefficients.data(), -1, 0.5, 1, buckets};
  }
  OneSpan(const OneSpan&) = delete;
  OneSpan& operator=(const OneSpan&) = delete;
};

TEST(EvaluateKernels, EveryInstructionSetGivesTheSame) {
  Random random(41);
  const auto kernels = availableKernels();
  for (int directions = 1; directions <= 3; ++directions) {
    for (int trial = 0; trial < 60; ++trial) {
      const int order = random.integer(0, 3);
      const int count = 5;
      std::vector<std::unique_ptr<OneSpan>> bases;
      NetView net{};
      net.directions = directions;
      net.columns = random.integer(1, 9);
      const int planes = (net.columns + 3) / 4;
      std::ptrdiff_t points = 1;
      const bool equal = random.coin();
      for (int k = 0; k < directions; ++k) {
        const int degree = equal && k > 0 ? net.degrees[0] : random.integer(0, directions == 3 ? 5 : 9);
        bases.push_back(std::make_unique<OneSpan>(random, degree));
        net.degrees[k] = degree;
        net.widths[k] = bases.back()->view.width;
        net.sizes[k] = degree + 1;
        points *= degree + 1;
      }
      net.planeStride = 4 * points;
      std::vector<double> padded(static_cast<std::size_t>(4 * points * planes + 4), 0.0);
      for (double& x : padded) x = random.uniform(-1, 1);
      net.points = padded.data();

      std::vector<std::vector<double>> parameters(static_cast<std::size_t>(directions));
      for (auto& values : parameters) {
        for (int i = 0; i < count; ++i) values.push_back(random.uniform(-1, 1));
      }
      const int derivatives = directions == 1   ? order + 1
                              : directions == 2 ? (order + 1) * (order + 2) / 2
                                                : (order + 1) * (order + 2) * (order + 3) / 6;
      const int stride = derivatives * net.columns;
      std::vector<double> expected, expectedLast;
      for (const auto& kernel : kernels) {
        std::vector<std::vector<double>> weights;
        std::vector<std::vector<std::ptrdiff_t>> firsts;
        std::vector<WeightsView> views;
        for (int k = 0; k < directions; ++k) {
          const auto& basis = bases[static_cast<std::size_t>(k)]->view;
          weights.emplace_back(static_cast<std::size_t>(count * (order + 1) * basis.width), -7.0);
          firsts.emplace_back(static_cast<std::size_t>(count), -7);
          kernel.basisWeights(basis, parameters[static_cast<std::size_t>(k)].data(), 1, count, order,
                              firsts.back().data(), weights.back().data());
          views.push_back({firsts.back().data(), weights.back().data()});
        }
        // A guard behind the result: nothing may be written there.
        std::vector<double> out(static_cast<std::size_t>(count * stride + 4), 77.0);
        kernel.contractPoints(net, views.data(), count, order, out.data(), stride);
        for (std::size_t i = out.size() - 4; i < out.size(); ++i) ASSERT_EQ(out[i], 77.0) << kernel.name;

        // The lines of the last direction at the first parameters of the others, then all parameters of the last.
        std::vector<double> last(static_cast<std::size_t>(count * stride + 4), 77.0);
        const std::ptrdiff_t row = 4 * net.sizes[directions - 1];
        for (int plane = 0; plane < planes; ++plane) {
          const double* source = net.points + plane * net.planeStride;
          const std::ptrdiff_t lineStride = row + 4;
          std::vector<double> lines(static_cast<std::size_t>((order + 1) * (order + 2) / 2 * lineStride), 0.0);
          if (directions == 1) {
            std::copy(source, source + row, lines.begin());
          } else if (directions == 2) {
            kernel.contractLines(views[0].weights, net.widths[0], net.degrees[0], order, source, row, row, lines.data(),
                                 lineStride);
          } else {
            const std::ptrdiff_t sheet = net.sizes[1] * row;
            std::vector<double> sheets(static_cast<std::size_t>((order + 1) * sheet), 0.0);
            kernel.contractLines(views[0].weights, net.widths[0], net.degrees[0], order, source, sheet, sheet,
                                 sheets.data(), sheet);
            double* line = lines.data();
            for (int a = 0; a <= order; ++a) {
              kernel.contractLines(views[1].weights, net.widths[1], net.degrees[1], order - a,
                                   sheets.data() + a * sheet, row, row, line, lineStride);
              line += (order + 1 - a) * lineStride;
            }
          }
          kernel.contractLast(net, lines.data(), lineStride, views.back(), count, order, 4 * plane, last.data(),
                              stride);
        }
        for (std::size_t i = last.size() - 4; i < last.size(); ++i) ASSERT_EQ(last[i], 77.0) << kernel.name;
        for (int i = 0; i < stride; ++i) {
          ASSERT_NEAR(last[static_cast<std::size_t>(i)], out[static_cast<std::size_t>(i)], 1e-9) << kernel.name;
        }
        if (expected.empty()) {
          expected = out;
          expectedLast = last;
        }
        for (std::size_t i = 0; i < out.size(); ++i) {
          ASSERT_NEAR(out[i], expected[i], 1e-10 * (1 + std::abs(expected[i]))) << kernel.name << " order " << order;
          ASSERT_NEAR(last[i], expectedLast[i], 1e-10 * (1 + std::abs(expectedLast[i]))) << kernel.name;
        }
      }
    }
  }
}

}  // namespace
}  // namespace strak
