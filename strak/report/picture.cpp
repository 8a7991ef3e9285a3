#include "strak/report/picture.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "strak/base/error.h"
#include "strak/report/colour_map.h"
#include "strak/report/feature_lines.h"
#include "strak/report/isobands.h"
#include "strak/report/svg.h"
#include "strak/report/value_runs.h"
#include "strak/spline/evaluate.h"

namespace strak {

namespace {

constexpr double kMargin = 18, kLegendWidth = 92, kCaptionHeight = 34;
constexpr const char* kInk = "#1c2733";

bool isMap(RenderKind kind) {
  return kind == RenderKind::gaussian || kind == RenderKind::mean || kind == RenderKind::deviation ||
         kind == RenderKind::points;
}

// Where the model goes; the rest is for legend and caption.
Eigen::Vector2d plotSize(const RenderOptions& options) {
  const bool legend = options.caption && isMap(options.kind);
  return {options.width - (legend ? kLegendWidth : 0), options.height - (options.caption ? kCaptionHeight : 0)};
}

void check(const RenderOptions& options) {
  if (options.width < 64 || options.height < 64 || options.width > 16384 || options.height > 16384)
    throw InvalidInput(fmt::format("A picture of {} x {} pixels cannot be drawn: give 64 to 16384 in each direction",
                                   options.width, options.height));
  if (options.lines < 0 || options.lines > 1000)
    throw InvalidInput(fmt::format("{} lines cannot be drawn: give 1 to 1000", options.lines));
  if (options.light && !(options.light->stableNorm() > 0 && std::isfinite(options.light->stableNorm())))
    throw InvalidInput("The light direction is zero or not finite: give a vector from the model to the light");
  if (options.range && !(options.range->first < options.range->second))
    throw InvalidInput("The range to show is empty: give a lower and a higher number");
  if (options.kind == RenderKind::points &&
      (options.points.cols() != 3 || options.points.rows() != options.values.size()))
    throw InvalidInput("Points to be shown need three coordinates and a value each");
}

double reflection(const Eigen::Vector3d& normal, const Eigen::Vector3d& eye, const Eigen::Vector3d& light) {
  return 2 * normal.dot(eye) * normal.dot(light) - eye.dot(light);
}

// What is shown at the mesh points of one surface.
std::vector<double> surfaceValues(const Picture& picture, const SceneSurface& surface, RenderKind kind) {
  const SurfaceSamples& samples = surface.samples;
  if (kind == RenderKind::gaussian) return samples.gaussian;
  if (kind == RenderKind::mean) return samples.mean;
  const Eigen::Vector3d eye = picture.camera.view();
  std::vector<double> values;
  for (const Eigen::Vector3d& n : samples.normals)
    values.push_back(kind == RenderKind::zebra ? reflection(n, eye, picture.light)
                                               : (n.dot(eye) < 0 ? -1 : 1) * n.dot(picture.light));
  return values;
}

std::vector<std::vector<double>> allValues(const Picture& picture, const RenderOptions& options) {
  if (options.kind == RenderKind::deviation) return deviations(picture.scene, options.reference);
  std::vector<std::vector<double>> values;
  for (const SceneSurface& surface : picture.scene.surfaces)
    values.push_back(surfaceValues(picture, surface, options.kind));
  return values;
}

std::vector<Comb> allCombs(const Picture& picture, int lines) {
  std::vector<Comb> combs;
  for (const SceneSurface& surface : picture.scene.surfaces)
    for (Comb& comb : surfaceCombs(surface, lines, teethPerLine(picture.scene, lines, 30'000)))
      combs.push_back(std::move(comb));
  for (const SceneCurve& curve : picture.scene.curves) combs.push_back(curveComb(curve));
  return combs;
}

class Painter {
 public:
  Painter(const Picture& picture, const RenderOptions& options, std::pair<double, double> range)
      : picture_(picture),
        options_(options),
        range_(range),
        nothing_(1, 1),
        svg_(options.width, options.height, fmt::format("{} of the model", renderKindName(options.kind))) {}

  std::string draw() && {
    svg_.rectangle(0, 0, options_.width, options_.height, "fill=\"#fff\"");
    const bool points = options_.kind == RenderKind::points;
    if (!points && (options_.kind == RenderKind::zebra || isMap(options_.kind)))
      drawBands();
    else
      drawGround();
    if (points) drawPoints();
    drawLines();
    if (options_.kind == RenderKind::combs) drawCombs();
    drawOutline();
    if (options_.caption) drawCaption();
    return std::move(svg_).finish();
  }

 private:
  const DepthBuffer& hiding() const { return options_.hideLines ? picture_.depth : nothing_; }

  PictureMesh pictureMesh(const SceneSurface& surface, std::vector<double> values) const {
    PictureMesh mesh{{}, std::move(values), surface.mesh.triangles};
    for (const Eigen::Vector3d& p : surface.samples.points) mesh.corners.push_back(picture_.camera.project(p));
    return mesh;
  }

  // A pale tone under line drawings tells surfaces from holes.
  void drawGround() {
    svg_.open("fill=\"#f1f4f7\" stroke=\"#f1f4f7\" stroke-width=\".4\" fill-rule=\"evenodd\"");
    for (const SceneSurface& surface : picture_.scene.surfaces) {
      const PictureMesh mesh = pictureMesh(surface, std::vector<double>(surface.samples.points.size(), 0.0));
      svg_.path(visibleBands(mesh, {}, picture_.depth).front(), "");
    }
    svg_.close();
  }

  void drawBands() {
    const bool zebra = options_.kind == RenderKind::zebra;
    const int lines = lineCount(options_, picture_.scene);
    std::vector<double> levels;
    std::vector<std::string> colours;
    if (zebra) {
      levels = symmetricLevels(range_, lines);
      const double step = (range_.second - range_.first) / lines;
      for (std::size_t k = 0; k <= levels.size(); ++k) {
        const double below = levels.empty() ? 0 : (k > 0 ? levels[k - 1] : levels[0] - step);
        colours.push_back(std::llround(below / step - 0.5) % 2 == 0 ? "#1f2a36" : "#f7f8f9");
      }
    } else {
      for (int k = 0; k < lines; ++k) {
        if (k > 0) levels.push_back(range_.first + (range_.second - range_.first) * k / lines);
        colours.push_back(hexColour(mapColour((k + 0.5) / lines)));
      }
    }
    const auto values = allValues(picture_, options_);
    std::vector<std::string> paths(colours.size());
    for (std::size_t i = 0; i < values.size(); ++i) {
      const auto parts = visibleBands(pictureMesh(picture_.scene.surfaces[i], values[i]), levels, picture_.depth);
      for (std::size_t k = 0; k < parts.size(); ++k) paths[k] += parts[k];
    }
    // A hair of the same colour around each region closes the seams that antialiasing leaves between neighbours.
    svg_.open("fill-rule=\"evenodd\" stroke-width=\".4\" stroke-linejoin=\"round\"");
    for (std::size_t k = 0; k < paths.size(); ++k)
      svg_.path(paths[k], fmt::format("fill=\"{0}\" stroke=\"{0}\"", colours[k]));
    svg_.close();
  }

  // Squares of some pixels, each in the colour of the largest value of its points.
  void drawPoints() {
    const int lines = lineCount(options_, picture_.scene);
    std::vector<std::string> paths(static_cast<std::size_t>(lines));
    for (const ValueRun& run : valueRuns(picture_, options_, range_)) {
      paths[static_cast<std::size_t>(run.colour)] +=
          fmt::format("M{0} {1}h{2}v{3}h-{2}z", run.x, run.y, run.width, run.height);
    }
    svg_.open("class=\"points\"");
    for (std::size_t k = 0; k < paths.size(); ++k) {
      svg_.path(paths[k], fmt::format("fill=\"{}\"", hexColour(mapColour((static_cast<double>(k) + 0.5) / lines))));
    }
    svg_.close();
  }

  void drawLine(const SpacePolyline& line, std::string& out) const {
    SpacePolyline projected;
    for (const Eigen::Vector3d& p : line) projected.push_back(picture_.camera.project(p));
    if (projected.size() < 2) return;
    for (const auto& piece : visiblePieces(projected, hiding())) out += smoothPath(piece);
  }

  // What is seen from its inner side has the opposite brightness.
  std::vector<double> isophoteLevels(const SceneSurface& surface) const {
    constexpr double kFew = 0.01;
    const std::vector<double> levels = symmetricLevels(range_, lineCount(options_, picture_.scene));
    const auto& normals = surface.samples.normals;
    const auto away = static_cast<double>(std::count_if(
        normals.begin(), normals.end(), [&](const auto& n) { return n.dot(picture_.camera.view()) < 0; }));
    const auto few = kFew * static_cast<double>(normals.size());
    std::vector<double> all;
    for (double level : levels) {
      if (static_cast<double>(normals.size()) - away > few) all.push_back(level);
      if (away > few) all.push_back(-level);
    }
    std::sort(all.begin(), all.end());
    all.erase(std::unique(all.begin(), all.end()), all.end());
    return all;
  }

  void drawLines() {
    std::string isophotes, isolines, curves;
    const double flatness = 0.05 / picture_.camera.scale();
    for (const SceneSurface& surface : picture_.scene.surfaces) {
      if (options_.kind == RenderKind::isophotes)
        for (const auto& line : fieldLines(surface, isophoteField(picture_.light), isophoteLevels(surface), flatness))
          drawLine(line, isophotes);
      if (options_.kind == RenderKind::isolines || options_.kind == RenderKind::combs)
        for (const auto& line : parameterLines(surface, lineCount(options_, picture_.scene))) drawLine(line, isolines);
    }
    for (const SceneCurve& curve : picture_.scene.curves) drawLine(curve.points, curves);
    svg_.open(fmt::format("fill=\"none\" stroke=\"{}\" stroke-linecap=\"round\" stroke-linejoin=\"round\"", kInk));
    svg_.path(isophotes, "class=\"isophotes\" stroke-width=\".8\"");
    svg_.path(isolines, "class=\"isolines\" stroke=\"#7b8794\" stroke-width=\".6\"");
    svg_.path(curves, "class=\"curves\" stroke-width=\"1.3\"");
    svg_.close();
  }

  // Borders of the faces and silhouettes.
  void drawOutline() {
    std::string borders, silhouettes;
    for (std::size_t i = 0; i < picture_.scene.surfaces.size(); ++i) {
      const SceneSurface& surface = picture_.scene.surfaces[i];
      for (const auto& border : borderLines(surface, picture_.trims[i]))
        drawLine(pointsAt(surface.surface, border), borders);
      for (const auto& line :
           fieldLines(surface, isophoteField(picture_.camera.view()), {0.0}, 0.05 / picture_.camera.scale()))
        drawLine(line, silhouettes);
    }
    svg_.open(
        fmt::format("fill=\"none\" stroke=\"{}\" stroke-width=\"1.2\" stroke-linecap=\"round\" "
                    "stroke-linejoin=\"round\"",
                    kInk));
    svg_.path(borders, "class=\"borders\"");
    svg_.path(silhouettes, "class=\"silhouettes\"");
    svg_.close();
  }

  void drawCombs() {
    // The tooth of the largest curvature is an eighth of the picture long.
    const double longest = 0.125 * std::min(options_.width, options_.height) / picture_.camera.scale();
    const double scale = longest / range_.second;
    std::string teeth, tips;
    for (const Comb& comb : allCombs(picture_, lineCount(options_, picture_.scene))) {
      SpacePolyline run;
      PicturePolyline tipRun;
      for (std::size_t i = 0; i < comb.base.size(); ++i) {
        const Eigen::Vector3d base = picture_.camera.project(comb.base[i]);
        if (hiding().visible(base)) {
          const Eigen::Vector3d tip = picture_.camera.project(comb.base[i] + scale * comb.direction[i]);
          tipRun.emplace_back(tip.head<2>());
          teeth += fmt::format("M{} {}L{} {}", shortNumber(base.x()), shortNumber(base.y()), shortNumber(tip.x()),
                               shortNumber(tip.y()));
          if (i + 1 < comb.base.size()) continue;
        }
        tips += smoothPath(tipRun);
        tipRun.clear();
      }
    }
    svg_.open("fill=\"none\" stroke=\"#b03a2e\" stroke-linecap=\"round\" stroke-linejoin=\"round\"");
    svg_.path(teeth, "class=\"teeth\" stroke-width=\".4\" stroke-opacity=\".55\"");
    svg_.path(tips, "class=\"comb\" stroke-width=\".9\"");
    svg_.close();
  }

  void drawCaption() {
    const double bottom = options_.height - 12;
    const std::string grey = "font-size=\"12\" fill=\"#5a6672\"";
    svg_.text(kMargin, bottom, captionText(), grey);
    if (!isMap(options_.kind)) return;
    const int lines = lineCount(options_, picture_.scene);
    const double x = options_.width - kLegendWidth + 6, top = 40, height = plotSize(options_).y() - 2 * top;
    for (int k = 0; k < lines; ++k)
      svg_.rectangle(x, top + height * (lines - 1 - k) / lines, 12, height / lines + 0.3,
                     fmt::format("fill=\"{}\"", hexColour(mapColour((k + 0.5) / lines))));
    svg_.rectangle(x, top, 12, height, "fill=\"none\" stroke=\"#5a6672\" stroke-width=\".6\"");
    for (double tick : roundTicks(range_, 6)) {
      const double y = top + height * (range_.second - tick) / (range_.second - range_.first);
      svg_.line(x + 12, y, x + 16, y, "stroke=\"#5a6672\" stroke-width=\".6\"");
      svg_.text(x + 19, y + 4, figure(tick, 3), "font-size=\"11\" fill=\"#5a6672\"");
    }
  }

  std::string captionText() const {
    const int lines = lineCount(options_, picture_.scene);
    const auto direction = [](const Eigen::Vector3d& d) {
      return fmt::format("({}, {}, {})", shortNumber(d.x()), shortNumber(d.y()), shortNumber(d.z()));
    };
    const std::string step = figure((range_.second - range_.first) / lines, 3);
    switch (options_.kind) {
      case RenderKind::isophotes:
        return fmt::format("Isophotes: n\u00B7L in steps of {}, light from {}", step, direction(picture_.light));
      case RenderKind::zebra:
        return fmt::format("Reflected stripes: steps of {}, light from {}", step, direction(picture_.light));
      case RenderKind::isolines:
        return fmt::format("Parameter lines, {} per direction", lines);
      case RenderKind::combs:
        return fmt::format("Curvature combs: longest tooth {} per unit", figure(range_.second));
      case RenderKind::gaussian:
        return "Gaussian curvature";
      case RenderKind::mean:
        return "Mean curvature";
      case RenderKind::deviation:
        return "Distance from the reference along its normal";
      case RenderKind::points:
        return "Deviation of the points, the largest of each place";
    }
    return {};
  }

  const Picture& picture_;
  const RenderOptions& options_;
  std::pair<double, double> range_;
  DepthBuffer nothing_;  // hides nothing
  SvgWriter svg_;
};

}  // namespace

int lineCount(const RenderOptions& options, const Scene& scene) {
  if (options.lines > 0) return options.lines;
  const auto surfaces = static_cast<int>(std::max<std::size_t>(scene.surfaces.size(), 1));
  switch (options.kind) {
    case RenderKind::isolines:
      return std::clamp(80 / surfaces, 3, 20);
    case RenderKind::combs:
      return std::clamp(40 / surfaces, 2, 8);
    case RenderKind::isophotes:
    case RenderKind::zebra:
      return 24;
    default:
      return 20;
  }
}

std::vector<double> symmetricLevels(std::pair<double, double> range, int lines) {
  const double step = (range.second - range.first) / lines;
  std::vector<double> levels;
  // Values outside the range (there may be a few far out) get lines too, as long as they are not far too many.
  const auto first = std::llround(std::floor(range.first / step)) - 5LL * lines;
  const auto last = std::llround(std::ceil(range.second / step)) + 5LL * lines;
  for (auto k = first; k <= last; ++k) {
    const double level = (static_cast<double>(k) + 0.5) * step;
    if (std::abs(level) < 1) levels.push_back(level);
  }
  return levels;
}

Eigen::Vector3d lightDirection(const RenderOptions& options, const Camera& camera) {
  if (options.light) return options.light->stableNormalized();
  return (camera.view() + 0.7 * camera.up() - 0.55 * camera.right()).normalized();
}

Picture preparePicture(const std::vector<Object>& objects, const RenderOptions& options, const Camera* camera) {
  check(options);
  SceneDetail detail;
  detail.shared = static_cast<Index>(options.width) * options.height / 8;
  Scene scene = buildScene(objects, detail);
  if (scene.surfaces.empty() && scene.curves.empty())
    throw InvalidInput("There is nothing to draw: the file has no spline curve, surface or volume");
  const Eigen::Vector2d size = plotSize(options);
  std::vector<Eigen::Vector3d> framed;
  if (options.frame && !options.frame->isEmpty()) {
    for (int k = 0; k < 8; ++k)
      framed.push_back(options.frame->corner(static_cast<Eigen::AlignedBox3d::CornerType>(k)));
  } else {
    framed = scenePoints(scene);
  }
  const double margin = options.kind == RenderKind::combs ? kMargin + 0.125 * std::min(size.x(), size.y()) : kMargin;
  const Camera own =
      camera ? *camera
             : Camera(options.view.value_or(defaultView(scene)), options.up, framed, size.x(), size.y(), margin);
  Picture picture{std::move(scene), {}, own, DepthBuffer(options.width, options.height), lightDirection(options, own)};
  for (const SceneSurface& surface : picture.scene.surfaces) {
    picture.trims.push_back(objects[static_cast<std::size_t>(surface.object)].trims);
    std::vector<Eigen::Vector3d> corners;
    for (const Eigen::Vector3d& p : surface.samples.points) corners.push_back(own.project(p));
    for (const auto& t : surface.mesh.triangles) picture.depth.add(corners[t[0]], corners[t[1]], corners[t[2]]);
  }
  return picture;
}

std::vector<std::vector<double>> deviations(const Scene& scene, const std::vector<Object>& reference) {
  std::vector<std::vector<double>> out;
  Index part = 0;
  for (std::size_t i = 0; i < scene.surfaces.size(); ++i) {
    const SceneSurface& surface = scene.surfaces[i];
    part = i > 0 && scene.surfaces[i - 1].object == surface.object ? part + 1 : 0;
    const auto object = static_cast<std::size_t>(surface.object);
    const Drawable parts =
        object < reference.size() && reference[object].spline ? drawable(*reference[object].spline) : Drawable{};
    if (part >= static_cast<Index>(parts.surfaces.size()))
      throw InvalidInput(fmt::format(
          "Object {} has no counterpart in the reference: the deviation needs two files with the same objects",
          object + 1));
    const Surface& other = parts.surfaces[static_cast<std::size_t>(part)];
    for (int k = 0; k < 2; ++k) {
      const KnotVector &a = surface.surface.knots(k), &b = other.knots(k);
      if (std::max(std::abs(a.from() - b.from()), std::abs(a.to() - b.to())) > 1e-9 * a.length())
        throw InvalidInput(fmt::format(
            "Object {} has another parameter domain in the reference: the deviation is measured at equal parameters",
            object + 1));
    }
    const SurfaceSamples samples = sampleSurface(other, surface.mesh.parameters);
    std::vector<double> values;
    for (std::size_t v = 0; v < samples.points.size(); ++v)
      values.push_back((surface.samples.points[v] - samples.points[v]).dot(samples.normals[v]));
    out.push_back(std::move(values));
  }
  return out;
}

std::pair<double, double> pictureRange(const Picture& picture, const RenderOptions& options) {
  if (options.kind == RenderKind::isolines) return {0, 1};
  if (options.kind == RenderKind::combs) {
    const double largest = largestCurvature(allCombs(picture, lineCount(options, picture.scene)));
    return {0, largest > 0 ? largest : 1};
  }
  std::vector<Weighted> shown;
  if (options.kind == RenderKind::points) {
    for (const double value : options.values) {
      if (std::isfinite(value)) shown.push_back({value, 1});
    }
    return mapRange(std::move(shown));
  }
  // By the area in the picture.
  const auto values = allValues(picture, options);
  for (std::size_t i = 0; i < values.size(); ++i) {
    const SceneSurface& surface = picture.scene.surfaces[i];
    for (const auto& t : surface.mesh.triangles) {
      std::array<Eigen::Vector3d, 3> p;
      double value = 0;
      for (std::size_t k = 0; k < 3; ++k) {
        p[k] = picture.camera.project(surface.samples.points[t[k]]);
        value += values[i][t[k]] / 3;
      }
      const double area = std::abs((p[1] - p[0]).cross(p[2] - p[0]).z());
      if (picture.depth.visible((p[0] + p[1] + p[2]) / 3)) shown.push_back({value, area});
    }
  }
  if (isMap(options.kind)) return mapRange(std::move(shown));
  const auto range = quantiles(std::move(shown), 0.03, 0.97);
  // A plane has one brightness: lines would only show rounding errors.
  return range.second - range.first > 1e-7 ? range : std::pair{-1.0, 1.0};
}

std::string drawPicture(const Picture& picture, const RenderOptions& options, std::pair<double, double> range) {
  return Painter(picture, options, range).draw();
}

}  // namespace strak
