#include "strak/report/drawing.h"

#include <fmt/format.h>

#include <cctype>

#include "strak/base/error.h"
#include "strak/report/page.h"
#include "strak/report/picture.h"
#include "strak/report/svg.h"
#include "strak/report/viewer_data.h"

namespace strak {

namespace {

constexpr RenderKind kKinds[] = {RenderKind::isophotes, RenderKind::zebra, RenderKind::isolines, RenderKind::combs,
                                 RenderKind::gaussian,  RenderKind::mean,  RenderKind::deviation};

}  // namespace

const char* renderKindName(RenderKind kind) {
  switch (kind) {
    case RenderKind::isophotes:
      return "isophotes";
    case RenderKind::zebra:
      return "zebra";
    case RenderKind::isolines:
      return "isolines";
    case RenderKind::combs:
      return "combs";
    case RenderKind::gaussian:
      return "gaussian";
    case RenderKind::mean:
      return "mean";
    case RenderKind::deviation:
      return "deviation";
    case RenderKind::points:
      return "points";
  }
  return "";
}

RenderKind renderKind(const std::string& name) {
  std::string names;
  for (RenderKind kind : kKinds) {
    if (name == renderKindName(kind)) return kind;
    names += fmt::format("{}{}", names.empty() ? "" : ", ", renderKindName(kind));
  }
  throw InvalidInput(fmt::format("\"{}\" cannot be shown: choose one of {}", name, names));
}

Eigen::AlignedBox3d frameOf(const std::vector<Object>& objects) {
  SceneDetail coarse;
  coarse.perSpan = 1;
  coarse.shared = 10'000;
  Eigen::AlignedBox3d box;
  for (const Eigen::Vector3d& p : scenePoints(buildScene(objects, coarse))) box.extend(p);
  return box;
}

std::pair<double, double> rangeOf(const std::vector<Object>& objects, const RenderOptions& options) {
  return pictureRange(preparePicture(objects, options), options);
}

std::string renderSvg(const std::vector<Object>& objects, const RenderOptions& options) {
  const Picture picture = preparePicture(objects, options);
  return drawPicture(picture, options, options.range ? *options.range : pictureRange(picture, options));
}

std::string renderHtml(const std::vector<Object>& objects, const std::string& title, const RenderOptions& options) {
  if (options.kind == RenderKind::points) throw InvalidInput("measured points are drawn as SVG only");
  const Picture picture = preparePicture(objects, options);
  const auto range = options.range ? *options.range : pictureRange(picture, options);
  std::string caption = fmt::format("{} of {}", renderKindName(options.kind), escaped(title));
  caption.front() = static_cast<char>(std::toupper(caption.front()));
  const std::string body =
      fmt::format("<h1>{}</h1>\n<p class=\"sub\">{} {}</p>\n{}<h2>Drawing</h2>\n<div class=\"single\">{}</div>\n",
                  escaped(title), objects.size(), objects.size() == 1 ? "object" : "objects", viewerMarkup(),
                  htmlFigure(drawPicture(picture, options, range), caption));
  return htmlPage(title, body, viewerData({"", objects, {}, {}, options}, picture));
}

}  // namespace strak
