#pragma once
//
// How smoothly surfaces join: gap, angle of the normals and jump of the curvature along a common edge, and across the
// inner knot lines of one surface.

#include <Eigen/Core>
#include <functional>
#include <vector>

#include "strak/spline/spline.h"

namespace strak {

// A figure along an edge: its largest value with the place (a point of the first surface), and its root mean square
// over the length of the edge.
struct JointFigure {
  double max = 0, rms = 0;
  Eigen::Vector3d place = Eigen::Vector3d::Zero();
};

struct Continuity {
  JointFigure gap;              // distance of the two edges; the model's unit
  JointFigure angle;            // between the tangent planes; radians, in [0, pi]
  JointFigure curvature;        // difference of the normal curvatures across the edge; 1 / length
  double length = 0;            // of the edge
  double largestCurvature = 0;  // of the normal curvatures across the edge, on either side
  Index samples = 0;
  Index singular = 0;  // samples where a side has no normal: they count for the gap only
};

// A curve in the parameters of a surface over [0, 1].
using ParameterCurve = std::function<Eigen::Vector2d(double t)>;

// The polyline through the points, at even steps of t. Throws InvalidInput for fewer than two points.
ParameterCurve parameterPolyline(std::vector<Eigen::Vector2d> points);

// The edge of the domain where direction 0 (u) or 1 (v) is at its start or its end.
ParameterCurve domainEdge(const Surface& surface, int direction, bool atEnd);

// How the normals of the second surface lie to those of the first: whatever gives the smaller angles on the whole edge,
// the same side, or opposite sides (one face is reversed).
enum class NormalSides { nearest, same, opposite };

struct ContinuityOptions {
  Index samples = 200;  // at least 2, ends included
  NormalSides sides = NormalSides::nearest;
};

// Continuity along a shared edge. A sample on the first edge is compared with the nearest point of the second edge, so
// the two curves may run at different speeds and in different directions. If the surface's own knot lines lie on the
// edge, the side to the right or above is taken. Throws InvalidInput unless both surfaces lie in space.
Continuity edgeContinuity(const Surface& a, const ParameterCurve& edgeA, const Surface& b, const ParameterCurve& edgeB,
                          const ContinuityOptions& options = {});

// Continuity of one surface across an inner knot line where it need not be C2.
struct KnotLineContinuity {
  int direction = 0;  // the knot's: 0 for a line u = knot
  double knot = 0;
  int multiplicity = 0;
  Continuity continuity;
};

// All inner knot lines with multiplicity above degree - 2, u first; `samplesPerSpan` >= 1 places on each span of the
// line, both sides evaluated with their own polynomials. Throws InvalidInput unless the surface lies in space.
std::vector<KnotLineContinuity> innerContinuity(const Surface& surface, Index samplesPerSpan = 8);

}  // namespace strak
