#pragma once
//
// Several patches, the joins between them and their tolerance as one function of the free points' displacements: what
// the descent (shape_descent.h) takes its steps in.

#include <memory>
#include <optional>
#include <vector>

#include "strak/fairing/hull_rows.h"
#include "strak/fairing/shape_descent.h"

namespace strak {

class ShapeProblem {
 public:
  ShapeProblem(const std::vector<ShapePatch>& patches, const std::vector<ShapeJoin>& joins, double tolerance,
               bool ballsOnPoints);

  // What a place in the space of displacements is worth.
  struct Figures {
    std::vector<ShapeEnergies> patches;  // over the active cells, without joins
    std::vector<JoinFigures> joins;      // the given ones, then the inner knot lines
    std::vector<double> rough;           // of the patches with their share of the joins, and never zero
    std::vector<double> metric;
  };
  Figures figuresAt(const Eigen::VectorXd& e) const;

  // The merit, the sum over the patches of
  //   log (roughness with joins) + (psi - 1) log roughness + theta log plate + mu metric / roughness at `now`,
  // at one place less that at another.
  double meritChange(const Figures& now, const Figures& at) const;
  // ... and its Gauss-Newton model at e, where the figures are `now`.
  void addStep(const Eigen::VectorXd& e, const Figures& now, BlockMatrix& matrix, Eigen::VectorXd& gradient) const;
  // The metric energies alone, each one at first.
  void addMetric(BlockMatrix& matrix, Eigen::VectorXd& gradient) const;
  // Without the weights that depend on the way: both energies count alike.
  double plainMerit(const Figures& at) const;

  // The arc lengths of the metric energies are those at e from now on; mu is `most` or `share` of the roughness.
  void setMetrics(const Eigen::VectorXd& e, double most, double share);

  // Whether a patch's figures are larger than its input's; of one patch alone. `turn` moves the plate energy's weight
  // towards the one that is.
  bool patchHolds(const Eigen::VectorXd& e, const Figures& at) const;
  void turnPlateWeight(const Eigen::VectorXd& e, const Figures& at);
  // Gives more weight to what is worse than the input: joins, and of several patches their figures. Returns the patches
  // that are touched; none if there is nothing to raise.
  std::vector<std::size_t> raiseWeights(const Eigen::VectorXd& e, const Figures& now);
  void resetPlateWeights();

  // What moves these patches.
  std::vector<int> unknownsOf(const std::vector<std::size_t>& patches) const;
  // The patches of which a figure is larger than the input's, integrated adaptively, sharply where they are close.
  std::vector<std::size_t> worseFigures(const Eigen::VectorXd& e, std::vector<SurfaceFairness>& before,
                                        std::vector<SurfaceFairness>& after);
  // The patches at joins of which a figure is larger.
  std::vector<std::size_t> worseJoins(const Figures& at) const;
  // From now on the points of these patches stay where the input has them. False if they do already.
  bool holdPatches(const std::vector<std::size_t>& patches);
  // A place near e where held points are where the input has them, and everything is inside the balls.
  Eigen::VectorXd withHeld(const Eigen::VectorXd& e) const;

  // Refines the hull where balls are touched; false if none is.
  bool refineRows(const Eigen::VectorXd& e);
  const BallRows& rows() const { return rows_; }
  // Feasible to the last bit: the balls are convex and contain zero.
  Eigen::VectorXd shrunk(const Eigen::VectorXd& e) const;

  Surface surface(std::size_t patch, const Eigen::VectorXd& e) const;
  std::size_t patches() const { return patches_.size(); }
  std::size_t givenJoins() const { return givenJoins_; }
  const JoinFigures& firstJoin(std::size_t join) const { return joins_[join].first; }
  const ShapeEnergies& firstEnergies(std::size_t patch) const { return patches_[patch].first; }
  const SurfaceFairness& before(std::size_t patch) const { return patches_[patch].before; }
  bool isFlat() const;
  Index unknowns() const { return unknowns_; }
  const std::shared_ptr<const BlockPattern>& pattern() const { return pattern_; }
  // Where the unknowns lie, for the order of elimination.
  Eigen::MatrixX3d places() const;

 private:
  struct Patch {
    const ShapePatch* input;
    Net start;  // points in space
    ShapeEnergy energy;
    SpanLevels levels;
    ShapeEnergies first{};                            // over the active cells
    SurfaceFairness before{};                         // the same and more, integrated adaptively ...
    std::optional<SurfaceFairness> sharpBefore = {};  // ... and sharply, once it is needed
    bool singular = false;                            // the integrals do not converge: no more than a hint
    double metricWeight = 0;                          // mu
    double plateWeight = 1;                           // theta
    double roughWeight = 1;                           // psi
    double roughnessFloor = 0;                        // below this all is rounding
    Index firstRow = 0;
  };
  struct Join {
    std::size_t a, b;  // patches; the same for an inner knot line
    JoinEnergy energy;
    JoinFigures first{};
    double angleWeight = 1, jumpWeight = 1;
    double wishedJump = 1;  // the weight that the jump has at first
    double roughness(const JoinFigures& now) const { return angleWeight * now.ofAngle + jumpWeight * now.ofJump; }
  };
  struct Worse {
    bool plate = false, roughness = false;
  };
  struct WorseJoin {
    bool angle = false, jump = false;
  };

  static SurfaceFairness fairnessOf(const Patch& patch, const Surface& surface, double relativeError);
  void addInnerLines(std::size_t patch);
  void makePattern();
  void makeRows();
  Eigen::Vector3d move(int point, const Eigen::VectorXd& e) const;
  // Lets `fill` add to a matrix and gradient of the points, and those to the unknowns'.
  template <class Fill>
  void addTied(BlockMatrix& matrix, Eigen::VectorXd& gradient, const Fill& fill) const;
  Net points(const Patch& patch, const Eigen::VectorXd& e) const;
  Worse worsePatch(std::size_t patch, const Eigen::VectorXd& e, const Figures& at) const;
  WorseJoin worseJoin(std::size_t join, const JoinFigures& now) const;
  bool figuresHold(std::size_t patch, const Surface& moved, SurfaceFairness& before, SurfaceFairness& after);
  void holdPoints(BlockMatrix& matrix, Eigen::VectorXd& gradient) const;

  double tolerance_;
  bool ballsOnPoints_;
  std::vector<Patch> patches_;
  std::vector<Join> joins_;
  std::size_t givenJoins_ = 0;
  Index unknowns_ = 0;
  std::vector<char> held_;  // by unknowns; empty: none
  std::shared_ptr<const BlockPattern> pattern_;
  BallRows rows_;
  std::shared_ptr<const TiedPoints> tied_;  // null: the patches' points are the unknowns
  std::optional<TiedMatrix> reduction_;
};

}  // namespace strak
