#pragma once
//
// The steps of a drawing: prepare objects for a camera, find the range of what is shown, draw.

#include <string>
#include <utility>
#include <vector>

#include "strak/report/depth_buffer.h"
#include "strak/report/drawing.h"
#include "strak/report/scene.h"

namespace strak {

struct Picture {
  Scene scene;
  std::vector<std::vector<std::vector<Eigen::Vector2d>>> trims;  // of each surface of the scene
  Camera camera;
  DepthBuffer depth;
  Eigen::Vector3d light;
};

// Meshes, camera and hidden parts. `camera`: the one of another picture that this one shall lie on.
Picture preparePicture(const std::vector<Object>& objects, const RenderOptions& options,
                       const Camera* camera = nullptr);

// The light that the options ask for or, if none, half left and above the eye; a unit vector.
Eigen::Vector3d lightDirection(const RenderOptions& options, const Camera& camera);

// Signed distances from the reference along its normal, for each surface of a scene made of the same objects as they
// are now. Throws InvalidInput if the reference has other objects or domains.
std::vector<std::vector<double>> deviations(const Scene& scene, const std::vector<Object>& reference);

std::pair<double, double> pictureRange(const Picture& picture, const RenderOptions& options);
std::string drawPicture(const Picture& picture, const RenderOptions& options, std::pair<double, double> range);

// The levels (k + 1/2) * step, step = (high - low) / lines, around the range. They lie evenly around zero, so isophotes
// do not depend on which side of a surface is its outer one.
std::vector<double> symmetricLevels(std::pair<double, double> range, int lines);

// How many lines the options ask for; if they leave it open, what suits the kind and the number of surfaces.
int lineCount(const RenderOptions& options, const Scene& scene);

}  // namespace strak
