#include "strak/solve/field.h"

#include <algorithm>
#include <cstdlib>
#include <new>
#include <numeric>

#include "strak/solve/kernels.h"

namespace strak {

using Eigen::Index;

namespace {
Index roundUp(Index n) { return (n + 7) / 8 * 8; }
}  // namespace

BoxLayout::BoxLayout(const std::vector<Index>& sizes, const std::vector<Index>& first, const std::vector<Index>& count,
                     int componentCount, int halo)
    : directions(static_cast<int>(sizes.size())), components(componentCount) {
  std::vector<int> order(sizes.size());
  std::iota(order.begin(), order.end(), 0);
  // Longest first; equal sizes keep their order, so that the result is repeatable.
  std::stable_sort(order.begin(), order.end(), [&](int a, int b) {
    return count[static_cast<std::size_t>(a)] > count[static_cast<std::size_t>(b)];
  });
  // A curve runs along the rows: one plane, one column.
  const std::size_t axis = sizes.size() == 3 ? 0 : 1;
  for (std::size_t k = 0; k < order.size(); ++k) {
    const auto d = static_cast<std::size_t>(order[k]);
    size[axis + k] = count[d];
    direction[axis + k] = order[k];
    netFirst[axis + k] = first[d];
    Index step = 1;
    for (std::size_t l = d + 1; l < sizes.size(); ++l) step *= sizes[l];
    netStep[axis + k] = step;
  }
  width = roundUp(size[2]);
  stride = roundUp(size[2] + halo);
  lead = roundUp(halo);
}

BoxLayout BoxLayout::scalar() const {
  BoxLayout result = *this;
  result.components = 1;
  return result;
}

void Field::Release::operator()(double* p) const { std::free(p); }

Field::Field(const BoxLayout& layout)
    : size_(layout.bufferSize()), lead_(layout.lead), rowStride_(layout.rowStride()), stride_(layout.stride) {
  const auto bytes = static_cast<std::size_t>(size_) * sizeof(double);
  data_.reset(static_cast<double*>(std::aligned_alloc(64, std::max<std::size_t>(bytes, 64))));
  if (!data_) throw std::bad_alloc();
  setZero();
}

void Field::setZero() { std::fill_n(data_.get(), size_, 0.0); }

void packBox(const BoxLayout& layout, const NetRef& net, const Eigen::RowVectorXd& shift, Field& field) {
  for (Index r = 0; r < layout.rows(); ++r) {
    for (int c = 0; c < layout.components; ++c) {
      double* target = field.row(r, c);
      for (Index j = 0; j < layout.size[2]; ++j) target[j] = net(layout.netRow(r, j), c) - shift[c];
    }
  }
}

void addBox(const BoxLayout& layout, const Field& field, MutableNetRef net) {
  for (Index r = 0; r < layout.rows(); ++r) {
    for (int c = 0; c < layout.components; ++c) {
      const double* source = field.row(r, c);
      for (Index j = 0; j < layout.size[2]; ++j) net(layout.netRow(r, j), c) += source[j];
    }
  }
}

double dot(const Field& a, const Field& b) { return kernels::chosen().dot(a.data(), b.data(), a.size()); }
void addScaled(Field& y, double factor, const Field& x) {
  kernels::chosen().addScaled(y.data(), factor, x.data(), y.size());
}
void scaleAndAdd(Field& y, double factor, const Field& x) {
  kernels::chosen().scaleAndAdd(y.data(), factor, x.data(), y.size());
}

}  // namespace strak
