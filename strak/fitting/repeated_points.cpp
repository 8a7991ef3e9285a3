#include "strak/fitting/repeated_points.h"

#include <tbb/parallel_sort.h>

#include <algorithm>
#include <bit>
#include <cstdint>
#include <vector>

namespace strak {

namespace {

struct Entry {
  std::uint64_t hash;
  Index row;
};

std::uint64_t mixed(std::uint64_t hash, const Net& rows, Index r) {
  for (Index c = 0; c < rows.cols(); ++c) {
    hash = (hash ^ std::bit_cast<std::uint64_t>(rows(r, c))) * 0x9e3779b97f4a7c15U;
    hash ^= hash >> 29;
  }
  return hash;
}

}  // namespace

Index mergeRepeatedPoints(Net& parameters, Net& values, Eigen::VectorXd& weights) {
  const Index n = parameters.rows();
  std::vector<Entry> entries(static_cast<std::size_t>(n));
  for (Index r = 0; r < n; ++r) entries[static_cast<std::size_t>(r)] = {mixed(mixed(1, parameters, r), values, r), r};
  tbb::parallel_sort(entries.begin(), entries.end(), [](const Entry& a, const Entry& b) {
    return a.hash < b.hash || (a.hash == b.hash && a.row < b.row);
  });
  // The first row that each one repeats.
  std::vector<Index> first(static_cast<std::size_t>(n));
  Index repeated = 0;
  for (std::size_t begin = 0; begin < entries.size();) {
    std::size_t end = begin;
    while (end < entries.size() && entries[end].hash == entries[begin].hash) ++end;
    for (std::size_t k = begin; k < end; ++k) {
      const Index r = entries[k].row;
      first[static_cast<std::size_t>(r)] = r;
      for (std::size_t l = begin; l < k; ++l) {
        const Index other = entries[l].row;
        if (first[static_cast<std::size_t>(other)] != other) continue;
        if (parameters.row(other) != parameters.row(r) || values.row(other) != values.row(r)) continue;
        first[static_cast<std::size_t>(r)] = other;
        ++repeated;
        break;
      }
    }
    begin = end;
  }
  if (repeated == 0) return 0;
  if (weights.size() == 0) weights = Eigen::VectorXd::Ones(n);
  for (Index r = 0; r < n; ++r) {
    const Index f = first[static_cast<std::size_t>(r)];
    if (f != r) weights[f] += weights[r];
  }
  Index kept = 0;
  for (Index r = 0; r < n; ++r) {
    if (first[static_cast<std::size_t>(r)] != r) continue;
    parameters.row(kept) = parameters.row(r);
    values.row(kept) = values.row(r);
    weights[kept++] = weights[r];
  }
  parameters.conservativeResize(kept, Eigen::NoChange);
  values.conservativeResize(kept, Eigen::NoChange);
  weights.conservativeResize(kept);
  return repeated;
}

}  // namespace strak
