#pragma once
//
// What a join of two surfaces, or an inner knot line of one, adds to the roughness: the angle between the tangent
// planes and the jump of the curvature across it, as if they were spread over one knot cell.
//
// With h the width of the cells next to the line, an angle a spread over h is a curvature a / h that comes and goes, a
// jump k a slope k / h of the curvature; |nabla h|^2 integrated over the cell is then about 12 a^2 / h^3 and k^2 / h a
// unit length of the line. So the figures have the unit of the isophote roughness, 1 / length^2, and add to it. The
// angle counts 400 times, as one twenty times as large: a break in a reflection line is seen before a bend.

#include <array>
#include <optional>
#include <vector>

#include "strak/solve/block_matrix.h"
#include "strak/spline/spline.h"

namespace strak {

// One bank of the line: the parameter `direction` has the value `at`, seen from the cells above or below it.
struct JoinBank {
  int direction = 0;
  double at = 0;
  bool above = true;
  std::optional<std::array<double, 2>> part = {};  // of the line: from, to in the other parameter; none: all of it
};

// Side 0 u low, 1 u high, 2 v low, 3 v high of a surface's domain.
JoinBank bankOfSide(const Surface& surface, int side);

struct JoinFigures {
  double ofAngle = 0;                  // the roughness that the angle stands for, see above; 1 / length^2
  double ofJump = 0;                   // ... and the jump
  double angle = 0;                    // largest sine of the angle between the tangent planes
  double jump = 0;                     // largest difference of the normal curvatures across the line
  double curvature = 0;                // largest of these curvatures themselves
  double meanAngle = 0, meanJump = 0;  // root mean squares over the length
};

class JoinEnergy {
 public:
  // The parameters along the two banks are mapped affinely, `reversed` or not; bank A, the whole line, has all knots of
  // bank B (of its part, if it has one).
  // `unknownA`, `unknownB` as in ShapeEnergy. Throws InvalidInput for a bank that is on no knot line.
  JoinEnergy(const Surface& a, const std::vector<int>& unknownA, const JoinBank& bankA, const Surface& b,
             const std::vector<int>& unknownB, const JoinBank& bankB, bool reversed);
  // The join of a surface with its mirror image, in a plane with this unit normal that holds the line. The figures are
  // those of the two: the angle is twice what the surface strays from perpendicular, curvatures agree by symmetry.
  JoinEnergy(const Surface& surface, const std::vector<int>& unknownOf, const JoinBank& bank,
             const Eigen::Vector3d& normal);

  // The unknowns that are coupled, for patternOfCliques. Stretches without free points are left out.
  std::vector<std::vector<int>> cliques() const;
  bool empty() const { return stretches_.empty(); }

  JoinFigures figures(const Net& pointsA, const Net& pointsB) const;

  // Adds the Gauss-Newton matrix and gradient of angleWeight * ofAngle + jumpWeight * ofJump.
  void addStep(const Net& pointsA, const Net& pointsB, double angleWeight, double jumpWeight, BlockMatrix& matrix,
               Eigen::VectorXd& gradient) const;

 private:
  using RowMatrix = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>;
  struct Sample {
    RowMatrix basisA, basisB;  // derivatives along, across, along along, along across, across across
    double length = 0, angleWeight = 0, jumpWeight = 0;
  };
  struct Stretch {
    std::vector<Index> rowsA, rowsB;  // control points of the cells next to it
    std::vector<int> unknown;         // of both
    std::vector<Sample> samples;
  };
  std::vector<Stretch> stretches_;
  std::optional<Eigen::Vector3d> mirror_;
};

}  // namespace strak
