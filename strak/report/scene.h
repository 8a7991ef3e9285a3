#pragma once
//
// Objects made ready for pictures: meshes of the surfaces, points of the curves.

#include <optional>

#include "strak/report/parts.h"
#include "strak/report/surface_mesh.h"

namespace strak {

struct SceneSurface {
  Index object = 0;  // its number in the list given
  Surface surface;
  TrimRegion region;
  ParameterMesh mesh;
  SurfaceSamples samples;
};

struct SceneCurve {
  Index object = 0;
  Curve curve;
  std::vector<double> parameters;
  std::vector<Eigen::Vector3d> points;
};

struct Scene {
  std::vector<SceneSurface> surfaces;
  std::vector<SceneCurve> curves;
  bool plane = true;  // everything lies in the plane z = 0
};

// How many mesh points the surfaces get.
struct SceneDetail {
  double perSpan = 4;     // wished number of cells per knot span in each direction
  Index shared = 60'000;  // shared out among the surfaces by area, at least `least` each
  Index least = 250;
  Index total = 300'000;  // of all surfaces; where the wishes exceed it, all are cut down alike
};

// Objects without a spline are passed over. Cost: an evaluation with second derivatives a mesh point.
Scene buildScene(const std::vector<Object>& objects, const SceneDetail& detail);

// All points of the scene, for framing.
std::vector<Eigen::Vector3d> scenePoints(const Scene& scene);

// A direction to the eye from which the scene is seen well: from above for plane scenes; for a sheet against its
// average normal, tilted; else three-quarter from the front, right and above.
Eigen::Vector3d defaultView(const Scene& scene);

// The lines that bound a surface in its parameter plane, as parameters: the trims or the sides of the domain, without
// seams (sides that are the same line in space).
std::vector<std::vector<Eigen::Vector2d>> borderLines(const SceneSurface& surface,
                                                      const std::vector<std::vector<Eigen::Vector2d>>& trims);

// Points of a surface at parameters.
std::vector<Eigen::Vector3d> pointsAt(const Surface& surface, const std::vector<Eigen::Vector2d>& parameters);

}  // namespace strak
