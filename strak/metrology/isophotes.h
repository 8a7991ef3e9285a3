#pragma once
//
// Lines on a surface along which a function of the point and its normal is constant: isophotes (n.L), reflection
// (zebra) lines and highlight lines. They show unevenness that no shaded picture shows: an isophote is one order of
// continuity less smooth than the surface.
//
// Source: isophotes n.L = c with a unit L, Hoschek and Juettler (3.3), (3.4) with the right denominator; reflection
// direction r = 2(n.e)n - e for an eye and lights at infinity; highlight lines: Beier and Chen, "Highlight-line
// algorithm for realtime surface-quality assessment" (1994).

#include <Eigen/Core>
#include <functional>
#include <vector>

#include "strak/spline/spline.h"

namespace strak {

// A polyline on a surface. Every vertex lies on its level to about 1e-12 of the field's range.
struct SurfaceLine {
  double level = 0;
  std::vector<Eigen::Vector2d> parameters{};  // (u, v)
  std::vector<Eigen::Vector3d> points{};      // X(u, v)
  bool closed = false;                        // then the last vertex repeats the first
};

// A function of a point of the surface and the unit normal there.
using SurfaceField = std::function<double(const Eigen::Vector3d& point, const Eigen::Vector3d& normal)>;

// n.L: the brightness of a matt surface under parallel light from the direction `light` (any length but zero).
SurfaceField isophoteField(const Eigen::Vector3d& light);

// r.L, r the mirrored direction to an eye in direction `eye` at infinity: the cosine of the angle under which circular
// light tubes around the axis `light` are seen. Equally spaced levels are the zebra lines.
SurfaceField reflectionField(const Eigen::Vector3d& light, const Eigen::Vector3d& eye);

// The signed distance of the line along the normal from the straight light tube through `place` along `direction`; in
// the model's unit. Zero where the normal is parallel to the tube.
SurfaceField highlightField(const Eigen::Vector3d& place, const Eigen::Vector3d& direction);

struct LineOptions {
  // Grid cells per knot span and direction in which lines are looked for; raised until a direction has minSamples cells
  // in all, lowered until it has at most maxSamples (but one a span stays).
  Index samplesPerSpan = 8, minSamples = 64, maxSamples = 2048;
  // Vertices are inserted until chords are this close to the line, relative to the size of the surface.
  double flatness = 1e-4;
  // Only the parts where it is true (trimmed faces); empty: everywhere. Called from many threads.
  std::function<bool(double u, double v)> inside{};
};

// The lines field = level for each of the levels, in the order of the levels. Lines run through knot lines where the
// surface is C1 (with a kink if it is not C2) and end where it is only C0: every piece is evaluated from its own side.
// On collapsed edges the limit of the normal from inside is taken. Cost: one evaluation a grid cell, some ten a vertex.
// Multi-threaded; the same lines for any number of threads. Throws InvalidInput unless the surface lies in space and
// the options are positive.
std::vector<SurfaceLine> levelLines(const Surface& surface, const SurfaceField& field,
                                    const std::vector<double>& levels, const LineOptions& options = {});

// `count` levels spread evenly inside the range that the field takes on the surface (ends excluded). To compare two
// surfaces use the same levels for both.
std::vector<double> evenLevels(const Surface& surface, const SurfaceField& field, int count,
                               const LineOptions& options = {});

struct IsophoteOptions : LineOptions {
  Eigen::Vector3d light{0, 0, 1};
  int lines = 20;                // number of levels, spread evenly over the range of n.L on the surface ...
  std::vector<double> levels{};  // ... unless they are given here
};

// The isophotes of a surface: levelLines of isophoteField.
std::vector<SurfaceLine> isophotes(const Surface& surface, const IsophoteOptions& options = {});

// The isoparametric lines u = value (direction 0) or v = value (direction 1) through every inner knot and `perSpan` - 1
// values between two knots, edges included; `level` is the fixed parameter. `inside` cuts as above.
std::vector<SurfaceLine> isoparametricLines(const Surface& surface, int direction, Index perSpan = 1,
                                            const LineOptions& options = {});

}  // namespace strak
