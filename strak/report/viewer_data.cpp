#include "strak/report/viewer_data.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <nlohmann/json.hpp>

#include "strak/report/colour_map.h"
#include "strak/report/feature_lines.h"
#include "strak/spline/evaluate.h"

namespace strak {

namespace {

using Json = nlohmann::ordered_json;
using Box = std::pair<double, double>;

constexpr Index kTeeth = 40'000;  // of all surfaces, one state
constexpr Index kMeshPoints = 90'000;

std::string base64(const std::vector<std::uint8_t>& bytes) {
  static const char digits[] = "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
  std::string out;
  out.reserve((bytes.size() + 2) / 3 * 4);
  for (std::size_t i = 0; i < bytes.size(); i += 3) {
    std::uint32_t group = static_cast<std::uint32_t>(bytes[i]) << 16;
    if (i + 1 < bytes.size()) group |= static_cast<std::uint32_t>(bytes[i + 1]) << 8;
    if (i + 2 < bytes.size()) group |= bytes[i + 2];
    for (std::size_t k = 0; k < 4; ++k) out += i + k > bytes.size() ? '=' : digits[(group >> (18 - 6 * k)) & 63];
  }
  return out;
}

// In the byte order of the page (little endian).
template <class T>
void append(std::vector<std::uint8_t>& bytes, T value) {
  for (std::size_t k = 0; k < sizeof value; ++k) bytes.push_back(static_cast<std::uint8_t>(value >> (8 * k)));
}

std::uint16_t fraction(double value, Box box) {
  const double t = box.second > box.first ? (value - box.first) / (box.second - box.first) : 0;
  return static_cast<std::uint16_t>(std::lround(std::clamp(t, 0.0, 1.0) * 65535));
}

Json vectorJson(const Eigen::Vector3d& v) { return {v.x(), v.y(), v.z()}; }

// Vectors as fractions of their bounding box.
Json quantized(const std::vector<Eigen::Vector3d>& vectors) {
  Eigen::AlignedBox3d box;
  if (vectors.empty()) box.extend(Eigen::Vector3d::Zero().eval());
  for (const Eigen::Vector3d& v : vectors) box.extend(v);
  std::vector<std::uint8_t> bytes;
  for (const Eigen::Vector3d& v : vectors)
    for (int k = 0; k < 3; ++k) append(bytes, fraction(v[k], {box.min()[k], box.max()[k]}));
  return {{"from", vectorJson(box.min())}, {"size", vectorJson(box.sizes())}, {"data", base64(bytes)}};
}

// Numbers as fractions of their range; the few that lie far outside (poles, kinks) are cut off.
Json quantized(const std::vector<double>& values) {
  std::vector<Weighted> weighted;
  weighted.reserve(values.size());
  for (double v : values) weighted.push_back({v, 1});
  Box box = quantiles(std::move(weighted), 0.002, 0.998);
  const double width = box.second - box.first;
  box = {box.first - width, box.second + width};
  std::vector<std::uint8_t> bytes;
  for (double v : values) append(bytes, fraction(v, box));
  return {{"from", box.first}, {"size", box.second - box.first}, {"data", base64(bytes)}};
}

Json meshJson(const SurfaceSamples& samples) {
  return {{"points", quantized(samples.points)},
          {"normals", quantized(samples.normals)},
          {"gaussian", quantized(samples.gaussian)},
          {"mean", quantized(samples.mean)}};
}

Json trianglesJson(const ParameterMesh& mesh) {
  std::vector<std::uint8_t> bytes;
  const bool narrow = mesh.parameters.size() <= 65536;
  for (const auto& triangle : mesh.triangles)
    for (std::uint32_t v : triangle) narrow ? append(bytes, static_cast<std::uint16_t>(v)) : append(bytes, v);
  return {{"bytes", narrow ? 2 : 4}, {"data", base64(bytes)}};
}

// Polylines without the points that are within `tolerance` of the line between their neighbours.
SpacePolyline thinned(const SpacePolyline& line, double tolerance) {
  SpacePolyline out;
  for (std::size_t i = 0; i < line.size(); ++i) {
    if (i > 0 && i + 1 < line.size() && i % 8 != 0) {
      const Eigen::Vector3d chord = (line[i + 1] - out.back()).normalized(), d = line[i] - out.back();
      if (d.cross(chord).norm() < tolerance) continue;
    }
    out.push_back(line[i]);
  }
  return out;
}

Json linesJson(const std::vector<SpacePolyline>& lines, const Eigen::Vector3d& origin) {
  SpacePolyline points;
  Json counts = Json::array();
  for (const SpacePolyline& line : lines) {
    counts.push_back(line.size());
    for (const Eigen::Vector3d& p : line) points.push_back(p - origin);
  }
  return {{"counts", counts}, {"points", quantized(points)}};
}

Json combsJson(const std::vector<Comb>& combs, const Eigen::Vector3d& origin) {
  SpacePolyline directions;
  std::vector<SpacePolyline> lines;
  for (const Comb& comb : combs) {
    lines.push_back(comb.base);
    directions.insert(directions.end(), comb.direction.begin(), comb.direction.end());
  }
  Json json = linesJson(lines, origin);
  json["directions"] = quantized(directions);
  return json;
}

std::vector<SpacePolyline> borders(const SceneSurface& surface, const std::vector<std::vector<Eigen::Vector2d>>& trims,
                                   double tolerance) {
  std::vector<SpacePolyline> out;
  for (const auto& line : borderLines(surface, trims))
    out.push_back(thinned(pointsAt(surface.surface, line), tolerance));
  return out;
}

class Builder {
 public:
  Builder(const ViewerModel& model, const Eigen::AlignedBox3d& box)
      : model_(model), origin_(box.center()), size_(box.diagonal().norm()) {
    for (const Object& object : model.before) objects_.push_back({{"name", object.name}, {"parts", Json::array()}});
  }

  void build() {
    // The finer knots of the state after are also those of the state before.
    std::vector<Object> finest = model_.before;
    for (std::size_t i = 0; i < model_.after.size(); ++i)
      if (model_.after[i].spline) finest[i].spline = model_.after[i].spline;
    const Scene scene = buildScene(finest, {5, 30'000, 150, kMeshPoints});
    RenderOptions combs;
    combs.kind = RenderKind::combs;
    combLines_ = lineCount(combs, scene);
    density_ = teethPerLine(scene, combLines_, kTeeth);
    Index part = 0;
    for (std::size_t i = 0; i < scene.surfaces.size(); ++i) {
      part = i > 0 && scene.surfaces[i - 1].object == scene.surfaces[i].object ? part + 1 : 0;
      addSurface(scene.surfaces[i], static_cast<std::size_t>(part));
    }
    for (const SceneCurve& curve : scene.curves) addCurve(curve);
  }

  // The edges between faces: lines of both states and their figures, [before, after].
  Json joins() const {
    std::vector<SpacePolyline> before, after;
    Json faces = Json::array(), gap = Json::array(), angle = Json::array(), curvature = Json::array();
    const auto pair = [](const BeforeAfter& figure) { return Json{figure.before, figure.after}; };
    for (const EdgeJoin& join : model_.joins) {
      before.push_back(thinned(join.lineBefore, 5e-5 * size_));
      after.push_back(thinned(join.lineAfter, 5e-5 * size_));
      faces.push_back({join.faceA, join.faceB});
      gap.push_back(pair(join.gap));
      angle.push_back(pair(join.angle));
      curvature.push_back(pair(join.curvature));
    }
    return {{"faces", faces},
            {"gap", gap},
            {"angle", angle},
            {"curvature", curvature},
            {"lines", {linesJson(before, origin_), linesJson(after, origin_)}}};
  }

  Json ranges() const {
    const auto pair = [](Box box) { return Json{box.first, box.second}; };
    return {{"gaussian", pair(mapRange(gaussian_))},
            {"mean", pair(mapRange(mean_))},
            {"deviation", pair(mapRange(deviation_))},
            {"combs", largestComb_}};
  }
  Json objects() && { return std::move(objects_); }

 private:
  bool changed(std::size_t object) const { return object < model_.after.size() && model_.after[object].spline; }

  void addSurface(const SceneSurface& scene, std::size_t part) {
    if (scene.mesh.triangles.empty()) return;
    const auto object = static_cast<std::size_t>(scene.object);
    const auto& trims = model_.before[object].trims;
    SceneSurface before{scene.object, drawable(*model_.before[object].spline).surfaces[part], scene.region, {}, {}};
    before.samples = changed(object) ? sampleSurface(before.surface, scene.mesh.parameters) : scene.samples;
    Json json{{"triangles", trianglesJson(scene.mesh)}, {"before", stateJson(before, trims)}};
    collect(scene, before.samples.gaussian, gaussian_);
    collect(scene, before.samples.mean, mean_);
    if (changed(object)) {
      std::vector<double> moved;
      for (std::size_t i = 0; i < scene.samples.points.size(); ++i)
        moved.push_back((scene.samples.points[i] - before.samples.points[i]).dot(before.samples.normals[i]));
      collect(scene, moved, deviation_);
      json["after"] = stateJson(scene, trims);
      json["deviation"] = quantized(moved);
    }
    objects_[object]["parts"].push_back(std::move(json));
  }

  static void collect(const SceneSurface& scene, const std::vector<double>& values, std::vector<Weighted>& out) {
    const auto& p = scene.samples.points;
    for (const auto& t : scene.mesh.triangles)
      out.push_back(
          {(values[t[0]] + values[t[1]] + values[t[2]]) / 3, (p[t[1]] - p[t[0]]).cross(p[t[2]] - p[t[0]]).norm()});
  }

  Json stateJson(const SceneSurface& surface, const std::vector<std::vector<Eigen::Vector2d>>& trims) {
    SurfaceSamples moved = surface.samples;
    for (Eigen::Vector3d& p : moved.points) p -= origin_;
    const std::vector<Comb> combs = surfaceCombs(surface, combLines_, density_);
    largestComb_ = std::max(largestComb_, largestCurvature(combs));
    Json json{{"mesh", meshJson(moved)}};
    json["borders"] = linesJson(borders(surface, trims, 5e-5 * size_), origin_);
    json["combs"] = combsJson(combs, origin_);
    return json;
  }

  void addCurve(const SceneCurve& scene) {
    const auto object = static_cast<std::size_t>(scene.object);
    const auto state = [&](const SceneCurve& curve) {
      const Comb comb = curveComb(curve);
      largestComb_ = std::max(largestComb_, largestCurvature({comb}));
      return Json{{"borders", linesJson({curve.points}, origin_)}, {"combs", combsJson({comb}, origin_)}};
    };
    Json json{{"before", state(scene)}};
    if (changed(object)) {
      json["after"] = json["before"];
      std::vector<Object> old{model_.before[object]};
      json["before"] = state(buildScene(old, {}).curves.front());
    }
    objects_[object]["parts"].push_back(std::move(json));
  }

  const ViewerModel& model_;
  Eigen::Vector3d origin_;  // of the page: its numbers then are small wherever the model lies
  double size_;
  int combLines_ = 0, density_ = 0;
  Json objects_ = Json::array();
  std::vector<Weighted> gaussian_, mean_, deviation_;  // by area
  double largestComb_ = 0;
};

}  // namespace

std::string viewerData(const ViewerModel& model, const Picture& picture) {
  Eigen::AlignedBox3d box;
  for (const Eigen::Vector3d& p : scenePoints(picture.scene)) box.extend(p);
  Builder builder(model, box);
  builder.build();
  Json json{{"unit", model.unit},
            {"compare", !model.after.empty()},
            {"kind", renderKindName(model.start.kind)},
            {"size", box.diagonal().norm()},
            {"right", vectorJson(picture.camera.right())},
            {"up", vectorJson(picture.camera.up())},
            {"view", vectorJson(picture.camera.view())},
            {"light", vectorJson(picture.light)},
            {"ranges", builder.ranges()}};
  for (RenderKind kind : {RenderKind::isophotes, RenderKind::zebra}) {
    RenderOptions options = model.start;
    options.kind = kind;
    options.range.reset();
    const auto range = pictureRange(picture, options);
    json["ranges"][renderKindName(kind)] = {range.first, range.second};
  }
  json["lines"] = lineCount(model.start, picture.scene);
  for (const Colour& colour : colourAnchors()) json["colours"].push_back(colour);
  if (!model.joins.empty()) json["joins"] = builder.joins();
  json["objects"] = std::move(builder).objects();
  // "</script" inside a name would end the element.
  std::string text = json.dump(-1, ' ', true, Json::error_handler_t::replace), safe;
  for (char c : text) c == '<' ? void(safe += "\\u003c") : safe.push_back(c);
  return safe;
}

}  // namespace strak
