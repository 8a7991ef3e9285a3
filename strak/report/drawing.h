#pragma once
//
// Pictures of splines: vector drawings (SVG) with hidden lines removed, and a page to turn and light them (HTML).

#include <Eigen/Geometry>
#include <optional>
#include <string>
#include <vector>

#include "strak/exchange/model.h"

namespace strak {

// What is shown on the surfaces. Curves are drawn with their combs for `combs`, else as lines; volumes by their six
// boundary faces.
enum class RenderKind {
  isophotes,  // lines of equal brightness n.L
  zebra,      // reflected stripes
  isolines,   // parameter lines
  combs,      // curvature combs along parameter lines
  gaussian,   // colour maps of the Gaussian ...
  mean,       // ... and the mean curvature
  deviation,  // colour map of the signed distance from a reference along its normal
  points,     // measured points in the colours of their values; drawings only
};

// "isophotes", "zebra", "isolines", "combs", "gaussian", "mean", "deviation", "points".
const char* renderKindName(RenderKind kind);

// Throws InvalidInput with the list of names for any other name; points are no choice, they need RenderOptions::points.
RenderKind renderKind(const std::string& name);

struct RenderOptions {
  RenderKind kind = RenderKind::isophotes;
  std::optional<Eigen::Vector3d>
      view;                           // from the model to the eye; default: a three-quarter view, plane curves from +z
  std::optional<Eigen::Vector3d> up;  // upright in the picture; default: z, or y if the view is along z
  std::optional<Eigen::Vector3d> light;  // from the model to the light; default: half left and above the eye
  int width = 900, height = 700;         // pixels
  int lines = 0;  // isophotes, stripes, colour steps, or combs and isolines per direction; 0: what suits the kind
  bool hideLines = true;                           // lines behind a surface are not drawn
  bool caption = true;                             // the legend of colour maps and the line of text below the drawing
  std::optional<Eigen::AlignedBox3d> frame;        // what fills the picture; default: the objects (frameOf)
  std::optional<std::pair<double, double>> range;  // of what is shown (rangeOf); default: from the objects
  std::vector<Object> reference;                   // for deviation: the same objects as they were
  Net points;                                      // for points: their places on the surfaces (x, y, z), and
  Eigen::VectorXd values;                          // ... a value each; points whose value is no number are left out
};

// The box of all objects that can be drawn (empty if there are none). Give the same box and view to two drawings and
// they can be laid on top of each other.
Eigen::AlignedBox3d frameOf(const std::vector<Object>& objects);

// The range of what is shown: brightness of the visible parts, curvatures, distances, or for combs zero to the largest
// curvature. The outermost 1 to 3 percent of the visible area are left out. Give the same range to two drawings to
// compare them. Throws like renderSvg.
std::pair<double, double> rangeOf(const std::vector<Object>& objects, const RenderOptions& options);

// The drawing. Throws InvalidInput if nothing can be drawn, an option is out of range, a direction is zero, or
// `reference` does not match for deviation.
std::string renderSvg(const std::vector<Object>& objects, const RenderOptions& options = {});

// A self-contained page that shows the objects with WebGL, starting from the same options, and the SVG drawing below
// for print and for readers without WebGL. `title` is usually the file's name. Throws like renderSvg, and for points.
std::string renderHtml(const std::vector<Object>& objects, const std::string& title, const RenderOptions& options = {});

}  // namespace strak
