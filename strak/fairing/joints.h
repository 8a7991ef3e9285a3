#pragma once
//
// Where surfaces meet: which control points of two borders belong together, how smooth the joint is, and which borders
// lie in a plane of symmetry.
//
// Sides of a surface are numbered 0 u low, 1 u high, 2 v low, 3 v high. The rows of a side are numbered inwards: row 0
// is the border. Along a side control points are counted with the rising parameter.

#include <Eigen/Core>
#include <array>
#include <optional>
#include <string>
#include <vector>

#include "strak/spline/spline.h"

namespace strak {

// A part of a side: from and to, rising, in the parameter along it.
using SidePart = std::array<double, 2>;

// Side `sideA` of surface a, or a part of it, meets the whole side `sideB` of surface b. a = b for a closed surface.
struct SidePair {
  Index a = 0, b = 0;
  int sideA = 0, sideB = 0;
  std::optional<SidePart> part = {};  // of side A, where several surfaces meet it (a T-junction)
};

// Rows of the net of the control points in row `depth` behind a side, with the rising parameter along it. Throws
// InvalidInput for another side and for a depth that the net has not.
std::vector<Index> borderRow(const Surface& surface, int side, Index depth = 0);

// The knots along a side.
const KnotVector& knotsAlong(const Surface& surface, int side);

// How well two borders fit, control point by control point.
struct BorderFit {
  bool compatible = false;      // same degree, weights and knots (mapped affinely), control points within the limit
  bool reversed = false;        // they run in opposite directions
  bool differentKnots = false;  // knots are in the way: makeCompatible can help
  double gap = 0;               // largest distance of two partners; no meaning with different knots or degrees
  std::string obstacle;         // why they are not compatible (a clause); empty if they are
  // Compatible: control point k of side B is the combination of side A's with row k, up to the gap. For whole sides a
  // permutation; moves of both borders fit if they obey it.
  Eigen::MatrixXd fromA;
  std::vector<Index> partner;  // whole sides: control point k of side A belongs to partner[k] of side B
};

// Compares the borders. Knots within 1e-9 of the domain are the same; partners may lie `gapLimit` apart. With a part of
// side A, side B must have A's knots there and may have more. Throws InvalidInput for a side that is none and for a
// part outside it.
BorderFit fitBorders(const Surface& a, int sideA, const Surface& b, int sideB, double gapLimit,
                     const std::optional<SidePart>& part = {});

// Knots that give all pairs the same knots along their common sides: missing ones are inserted, exactly, on both sides
// and passed on to the sides opposite, until nothing is missing. Surfaces keep their shape, domain and own knots. Pairs
// of different degrees stay apart. Throws InvalidInput for wrong numbers, and Failure if a net would get more than
// `maxPoints` control points.
std::vector<Surface> makeCompatible(const std::vector<Surface>& surfaces, const std::vector<SidePair>& pairs,
                                    Index maxPoints = 1'000'000);

// feature: the angle is meant. g0: a kink that is not. g1, g2: as measured.
enum class JointKind { feature, g0, g1, g2 };

// "feature", "G0", "G1", "G2".
const char* jointKindName(JointKind kind);

struct JointOptions {
  double gapLimit = 0;           // partners farther apart do not belong together; 0: 1e-6 of the surfaces' size
  double featureAngle = 3.0;     // degrees: joints with a larger angle are features
  double smoothAngle = 0.1;      // degrees: joints with at most this angle are G1
  double curvatureShare = 0.02;  // G2 if the jump is at most this share of the largest curvature across the joint
  Index samples = 65;            // along a joint
};

struct Joint {
  Index a = 0, b = 0;
  int sideA = 0, sideB = 0;
  std::optional<SidePart> part;  // as in SidePair
  BorderFit fit;
  bool sameNormals = true;      // X_u x X_v points to the same side on both surfaces
  double gapMax = 0;            // of the curves, model units
  double angleMax = 0;          // degrees, [0, 180]
  double curvatureJumpMax = 0;  // 1 / length
  JointKind kind = JointKind::g0;
};

// Measures all pairs, in their order. Multi-threaded; the result does not depend on the number of threads. Throws
// InvalidInput for surfaces that do not lie in space and wrong numbers. Cost: some hundred surface points a pair.
std::vector<Joint> measureJoints(const std::vector<Surface>& surfaces, const std::vector<SidePair>& pairs,
                                 const JointOptions& options = {});

// Whether an angle and a jump of curvature (`largest`: of the curvatures themselves) make a joint G1 or G2.
JointKind jointKind(double angleDegrees, double curvatureJump, double largestCurvature, double length,
                    const JointOptions& options = {});

// For every surface, which sides are in no pair.
std::vector<std::array<bool, 4>> freeSides(std::size_t surfaces, const std::vector<SidePair>& pairs);

struct SymmetryPlane {
  Eigen::Vector3d point, normal;  // normal of length 1, its largest coordinate positive
};

struct SymmetryOptions {
  double planarity = 1e-6;  // of the border's size: its control points may be this far from the plane
  double angle = 0.5;       // degrees that the surface may stray from perpendicular
  std::optional<Eigen::Vector3d> normal = {};  // of the plane, length 1, if it is known; none: any plane
};

// The plane in which a border lies and to which the surface is perpendicular there; none if there is no such plane.
// Mirrored, the surface goes on smoothly across it. Throws InvalidInput unless the surface lies in space.
std::optional<SymmetryPlane> symmetryPlane(const Surface& surface, int side, const SymmetryOptions& options = {});

}  // namespace strak
