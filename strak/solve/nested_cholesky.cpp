#include "strak/solve/nested_cholesky.h"

#include <tbb/parallel_invoke.h>

#include <algorithm>
#include <atomic>
#include <numeric>

#include "strak/solve/dense_kernels.h"
#include "strak/solve/halves.h"

namespace strak {

using Eigen::Index;

namespace {

constexpr std::size_t kLeaf = 12;      // points that are no longer dissected
constexpr Index kParallelBelow = 600;  // subtrees of fewer points are one task

struct Entry {
  Index place;      // among the matrix's blocks
  int row, column;  // in the front, points
  bool transposed;
};

// A set of points eliminated together, and the later points that this couples.
struct Node {
  int first = 0, count = 0;  // own points, in the order of elimination
  std::vector<int> update;   // later points, ascending
  std::vector<int> children;
  std::vector<int> inParent;   // places of `update` in the parent's front
  std::vector<Entry> entries;  // of the matrix that belong to the own points
  Index below = 0;             // points of the whole subtree
  Eigen::MatrixXd factor;      // L of the own columns: own and update rows
  Eigen::MatrixXd schur;       // what goes to the parent, while factoring
};

}  // namespace

struct NestedCholesky::Tree {
  std::shared_ptr<const BlockPattern> pattern;
  std::vector<std::vector<int>> neighbours;
  std::vector<Node> nodes;  // children before parents
  std::vector<int> order;   // order[k]: the point eliminated k-th
  std::vector<int> rank;    // its inverse
  std::vector<int> roots;
  std::atomic<bool> failed{false};

  int dissect(std::vector<int> points, const Eigen::Ref<const Eigen::MatrixX3d>& places, std::vector<char>& side);
  int addNode(const std::vector<int>& own, std::vector<int> children);
  void analyse();
  void factorNode(int index, const BlockMatrix& matrix);
};

int NestedCholesky::Tree::addNode(const std::vector<int>& own, std::vector<int> children) {
  Node node;
  node.first = static_cast<int>(order.size());
  node.count = static_cast<int>(own.size());
  node.children = std::move(children);
  order.insert(order.end(), own.begin(), own.end());
  nodes.push_back(std::move(node));
  return static_cast<int>(nodes.size()) - 1;
}

int NestedCholesky::Tree::dissect(std::vector<int> points, const Eigen::Ref<const Eigen::MatrixX3d>& places,
                                  std::vector<char>& side) {
  if (points.size() <= kLeaf) return addNode(points, {});
  const auto middle = points.begin() + halveByPlace(points, places);
  for (auto p = points.begin(); p != points.end(); ++p) side[static_cast<std::size_t>(*p)] = p < middle ? 1 : 2;
  std::vector<int> halves[2], borders[2];
  for (int p : points) {
    const char own = side[static_cast<std::size_t>(p)], other = static_cast<char>(3 - own);
    const auto& near = neighbours[static_cast<std::size_t>(p)];
    const bool touches =
        std::any_of(near.begin(), near.end(), [&](int q) { return side[static_cast<std::size_t>(q)] == other; });
    (touches ? borders : halves)[own - 1].push_back(p);
  }
  for (int p : points) side[static_cast<std::size_t>(p)] = 0;
  const int thin = borders[0].size() <= borders[1].size() ? 0 : 1;
  std::vector<int>& separator = borders[thin];
  halves[1 - thin].insert(halves[1 - thin].end(), borders[1 - thin].begin(), borders[1 - thin].end());
  if (separator.size() * 3 > points.size() * 2) return addNode(points, {});
  std::vector<int> children;
  for (auto& half : halves) {
    std::sort(half.begin(), half.end());
    if (!half.empty()) children.push_back(dissect(std::move(half), places, side));
  }
  std::sort(separator.begin(), separator.end());
  if (separator.empty() && children.size() == 1) return children.front();
  return addNode(separator, std::move(children));
}

void NestedCholesky::Tree::analyse() {
  rank.resize(order.size());
  for (std::size_t k = 0; k < order.size(); ++k) rank[static_cast<std::size_t>(order[k])] = static_cast<int>(k);
  std::vector<int> local(order.size(), -1);
  for (Node& node : nodes) {
    const int end = node.first + node.count;
    node.below = node.count;
    std::vector<int>& update = node.update;
    for (int k = node.first; k < end; ++k) {
      for (int q : neighbours[static_cast<std::size_t>(order[static_cast<std::size_t>(k)])]) {
        if (rank[static_cast<std::size_t>(q)] >= end) update.push_back(rank[static_cast<std::size_t>(q)]);
      }
    }
    for (int child : node.children) {
      const Node& below = nodes[static_cast<std::size_t>(child)];
      node.below += below.below;
      for (int k : below.update) {
        if (k >= end) update.push_back(k);
      }
    }
    std::sort(update.begin(), update.end());
    update.erase(std::unique(update.begin(), update.end()), update.end());

    for (int k = node.first; k < end; ++k) local[static_cast<std::size_t>(k)] = k - node.first;
    for (std::size_t k = 0; k < update.size(); ++k) {
      local[static_cast<std::size_t>(update[k])] = node.count + static_cast<int>(k);
    }
    for (int child : node.children) {
      Node& below = nodes[static_cast<std::size_t>(child)];
      for (int k : below.update) below.inParent.push_back(local[static_cast<std::size_t>(k)]);
    }
    for (int k = node.first; k < end; ++k) {
      const int p = order[static_cast<std::size_t>(k)];
      node.entries.push_back({pattern->place(p, p), k - node.first, k - node.first, false});
      for (int q : neighbours[static_cast<std::size_t>(p)]) {
        const int later = rank[static_cast<std::size_t>(q)];
        if (later <= k) continue;
        node.entries.push_back({pattern->place(std::max(p, q), std::min(p, q)), local[static_cast<std::size_t>(later)],
                                k - node.first, q < p});
      }
    }
  }
}

void NestedCholesky::Tree::factorNode(int index, const BlockMatrix& matrix) {
  Node& node = nodes[static_cast<std::size_t>(index)];
  if (node.below > kParallelBelow && node.children.size() == 2) {
    tbb::parallel_invoke([&] { factorNode(node.children[0], matrix); }, [&] { factorNode(node.children[1], matrix); });
  } else {
    for (int child : node.children) factorNode(child, matrix);
  }
  if (failed) return;
  const Index own = 3 * node.count, all = own + 3 * static_cast<Index>(node.update.size());
  // The own columns and the rest apart, so that the factor needs no copy.
  Eigen::MatrixXd& left = node.factor;
  Eigen::MatrixXd& rest = node.schur;
  left.setZero(all, own);
  rest.setZero(all - own, all - own);
  for (const Entry& e : node.entries) {
    const Eigen::Map<const Eigen::Matrix<double, 3, 3, Eigen::RowMajor>> block(matrix.at(e.place));
    if (e.transposed) {
      left.block<3, 3>(3 * e.row, 3 * e.column) = block.transpose();
    } else {
      left.block<3, 3>(3 * e.row, 3 * e.column) = block;
    }
  }
  for (int child : node.children) {
    Node& below = nodes[static_cast<std::size_t>(child)];
    const auto& to = below.inParent;
    for (std::size_t c = 0; c < to.size(); ++c) {
      for (std::size_t r = c; r < to.size(); ++r) {
        const auto from = below.schur.block<3, 3>(3 * static_cast<Index>(r), 3 * static_cast<Index>(c));
        if (to[c] < node.count) {
          left.block<3, 3>(3 * to[r], 3 * to[c]) += from;
        } else {
          rest.block<3, 3>(3 * to[r] - own, 3 * to[c] - own) += from;
        }
      }
    }
    below.schur.resize(0, 0);
  }
  static thread_local std::vector<double> scratch;
  scratch.resize(std::max(scratch.size(), static_cast<std::size_t>(dense::scratchSize(all))));
  if (!dense::chosen().eliminate(all, own, left.data(), rest.data(), scratch.data())) failed = true;
}

NestedCholesky::NestedCholesky(std::shared_ptr<const BlockPattern> pattern,
                               const Eigen::Ref<const Eigen::MatrixX3d>& places)
    : tree_(std::make_unique<Tree>()) {
  const Index n = pattern->size();
  tree_->pattern = std::move(pattern);
  tree_->neighbours.resize(static_cast<std::size_t>(n));
  for (Index j = 0; j < n; ++j) {
    for (Index k = tree_->pattern->start[static_cast<std::size_t>(j)];
         k < tree_->pattern->start[static_cast<std::size_t>(j) + 1]; ++k) {
      const int i = tree_->pattern->rows[static_cast<std::size_t>(k)];
      if (i == j) continue;
      tree_->neighbours[static_cast<std::size_t>(j)].push_back(i);
      tree_->neighbours[static_cast<std::size_t>(i)].push_back(static_cast<int>(j));
    }
  }
  std::vector<int> all(static_cast<std::size_t>(n));
  std::iota(all.begin(), all.end(), 0);
  std::vector<char> side(all.size(), 0);
  if (n > 0) tree_->roots.push_back(tree_->dissect(std::move(all), places, side));
  tree_->analyse();
  std::vector<std::vector<int>>().swap(tree_->neighbours);
}

NestedCholesky::~NestedCholesky() = default;
NestedCholesky::NestedCholesky(NestedCholesky&&) noexcept = default;
NestedCholesky& NestedCholesky::operator=(NestedCholesky&&) noexcept = default;

bool NestedCholesky::factor(const BlockMatrix& matrix) {
  tree_->failed = false;
  for (int root : tree_->roots) tree_->factorNode(root, matrix);
  return !tree_->failed;
}

Eigen::VectorXd NestedCholesky::solve(const Eigen::VectorXd& b) const {
  const Tree& tree = *tree_;
  Eigen::VectorXd x(b.size()), part;
  for (std::size_t k = 0; k < tree.order.size(); ++k) {
    x.segment<3>(3 * static_cast<Index>(k)) = b.segment<3>(3 * tree.order[k]);
  }
  for (const Node& node : tree.nodes) {
    const Index own = 3 * node.count, rest = 3 * static_cast<Index>(node.update.size());
    auto mine = x.segment(3 * node.first, own);
    node.factor.topRows(own).triangularView<Eigen::Lower>().solveInPlace(mine);
    part.noalias() = node.factor.bottomRows(rest) * mine;
    for (std::size_t k = 0; k < node.update.size(); ++k) {
      x.segment<3>(3 * node.update[k]) -= part.segment<3>(3 * static_cast<Index>(k));
    }
  }
  for (auto node = tree.nodes.rbegin(); node != tree.nodes.rend(); ++node) {
    const Index own = 3 * node->count, rest = 3 * static_cast<Index>(node->update.size());
    auto mine = x.segment(3 * node->first, own);
    part.resize(rest);
    for (std::size_t k = 0; k < node->update.size(); ++k) {
      part.segment<3>(3 * static_cast<Index>(k)) = x.segment<3>(3 * node->update[k]);
    }
    mine.noalias() -= node->factor.bottomRows(rest).transpose() * part;
    node->factor.topRows(own).triangularView<Eigen::Lower>().transpose().solveInPlace(mine);
  }
  Eigen::VectorXd result(b.size());
  for (std::size_t k = 0; k < tree.order.size(); ++k) {
    result.segment<3>(3 * tree.order[k]) = x.segment<3>(3 * static_cast<Index>(k));
  }
  return result;
}

Eigen::VectorXd NestedCholesky::factorDiagonal() const {
  Eigen::VectorXd result(3 * static_cast<Index>(tree_->order.size()));
  for (const Node& node : tree_->nodes) {
    for (int k = 0; k < node.count; ++k) {
      const int point = tree_->order[static_cast<std::size_t>(node.first + k)];
      for (int c = 0; c < 3; ++c) result[3 * Index{point} + c] = node.factor(3 * k + c, 3 * k + c);
    }
  }
  return result;
}

Index NestedCholesky::factorSize() const {
  Index sum = 0;
  for (const Node& node : tree_->nodes) {
    const Index own = 3 * node.count;
    sum += own * (own + 1) / 2 + own * 3 * static_cast<Index>(node.update.size());
  }
  return sum;
}

}  // namespace strak
