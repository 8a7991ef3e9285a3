#pragma once
//
// The lines in space that a drawing of a surface or a curve consists of.

#include <vector>

#include "strak/metrology/isophotes.h"
#include "strak/report/scene.h"

namespace strak {

using SpacePolyline = std::vector<Eigen::Vector3d>;

// The lines field = level inside the trims, chords at most `flatness` (model units) from the line.
std::vector<SpacePolyline> fieldLines(const SceneSurface& surface, const SurfaceField& field,
                                      const std::vector<double>& levels, double flatness);

// `count` evenly spaced parameter lines per direction, inside the trims; the sides of the domain are not among them.
std::vector<SpacePolyline> parameterLines(const SceneSurface& surface, int count);

// Teeth of curvature combs of one line: from[i] on the line to from[i] + direction[i] * scale.
struct Comb {
  SpacePolyline base, direction;  // direction: curvature times the normal that points away from the centre
};

// Combs along `count` evenly spaced parameter lines per direction (cut at the trims), and of a curve. `density` is the
// wished number of teeth a line; every span has at least two.
std::vector<Comb> surfaceCombs(const SceneSurface& surface, int count, int density);
Comb curveComb(const SceneCurve& curve);

// The density for about `teeth` teeth on all surfaces together.
int teethPerLine(const Scene& scene, int count, Index teeth);

// The length of the longest tooth of all, without the longest half percent.
double largestCurvature(const std::vector<Comb>& combs);

}  // namespace strak
