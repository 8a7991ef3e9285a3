#pragma once
//
// The problem of hull_minimizer.h for very many points: window after window, each one with what lies around it as it
// is. Where balls keep every point near its place, far points hardly feel one another, and a factor of everything would
// cost a hundred times what the factors of its windows cost.
//
// Method: overlapping multiplicative Schwarz; windows of one colour touch nothing in common and run side by side.
// Source: Tai, "Rate of convergence for some constraint decomposition methods for nonlinear variational inequalities"
// (2003), for convex constraints.

#include <memory>
#include <vector>

#include "strak/solve/hull_minimizer.h"

namespace strak {

struct WindowOptions {
  Eigen::Index points = 1200;  // of a window, at most, without its overlap
  int overlap = 2;             // so many times the points coupled with the window's are added
};

class HullWindows {
 public:
  // `places` as for NestedCholesky. `points`: the windows hold these and their overlap only, all others stay where they
  // are; none: every point. Cost O(blocks log size).
  HullWindows(std::shared_ptr<const BlockPattern> pattern, const Eigen::Ref<const Eigen::MatrixX3d>& places,
              const WindowOptions& options = {}, std::vector<int> points = {});
  ~HullWindows();
  HullWindows(HullWindows&&) noexcept;
  HullWindows& operator=(HullWindows&&) noexcept;

  // One sweep over the windows: x, which must lie in all balls, gets better, and lies in them to a millionth of their
  // radius. Of the result only `value`, `factors` (of all windows) and `solved` (every window was) are meaningful; how
  // far the value is from the least one is not known. Does not depend on the number of threads. Memory: the factor of
  // one window a thread.
  HullResult sweep(const HullProblem& problem, Eigen::VectorXd& x, const HullOptions& options = {}) const;

  Eigen::Index windows() const;

 private:
  struct Parts;
  std::unique_ptr<Parts> parts_;
};

}  // namespace strak
