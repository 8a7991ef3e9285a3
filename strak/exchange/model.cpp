#include "strak/exchange/model.h"

#include <fmt/format.h>

#include <algorithm>

#include "strak/base/error.h"
#include "strak/base/file.h"
#include "strak/exchange/digitised_model.h"
#include "strak/exchange/face_edges.h"
#include "strak/exchange/file_kind.h"
#include "strak/exchange/g2.h"
#include "strak/exchange/json.h"
#include "strak/exchange/replaceable.h"

namespace strak {
namespace {

std::string kindOf(const AnySpline& spline) {
  const char* shape = std::array{"curve", "surface", "volume"}[spline.index()];
  const bool rational = std::visit([](const auto& s) { return s.isRational(); }, spline);
  return fmt::format("{}B-spline {}", rational ? "rational " : "", shape);
}

constexpr double kSamePlace = 1e-6;  // of the model's size: sides this near are the same edge

// Splines and nothing that hangs on them.
class PlainModel : public Model {
 public:
  PlainModel(std::vector<PlainObject> content, FileKind kind, std::string unit)
      : content_(std::move(content)), kind_(kind), unit_(std::move(unit)) {
    int number = 0;
    for (const PlainObject& entry : content_) {
      Object object;
      ++number;
      object.spline = entry.spline;
      object.kind = entry.spline ? kindOf(*entry.spline) : entry.kind;
      const char* shape = entry.spline ? std::array{"curve", "surface", "volume"}[entry.spline->index()] : "object";
      object.name = entry.name.empty() ? fmt::format("{} {}", shape, number) : entry.name;
      if (!entry.spline) object.leftAlone = fmt::format("a {} is not a spline", entry.kind);
      objects_.push_back(std::move(object));
    }
  }

  const std::vector<Object>& objects() const override { return objects_; }
  std::string format() const override { return fileKindName(kind_); }
  std::string unit() const override { return unit_; }

  double size() const override {
    Eigen::VectorXd low, high;
    for (const Object& object : objects_) {
      if (!object.spline) continue;
      const Net net = std::visit([](const auto& s) { return s.euclideanNet(); }, *object.spline);
      const Index old = low.size();
      if (net.cols() > old) {
        low.conservativeResize(net.cols());
        high.conservativeResize(net.cols());
        low.tail(net.cols() - old).setConstant(std::numeric_limits<double>::infinity());
        high.tail(net.cols() - old).setConstant(-std::numeric_limits<double>::infinity());
      }
      low.head(net.cols()) = low.head(net.cols()).cwiseMin(net.colwise().minCoeff().transpose());
      high.head(net.cols()) = high.head(net.cols()).cwiseMax(net.colwise().maxCoeff().transpose());
    }
    return (high - low).stableNorm();
  }

  void replace(Index index, const AnySpline& spline) override {
    requireIndex(index, objects_);
    const auto i = static_cast<std::size_t>(index);
    requireReplaceable(objects_[i], content_[i].spline, spline);
    objects_[i].spline = spline;
  }

  void replaceTogether(const std::vector<std::pair<Index, AnySpline>>& splines) override {
    for (const auto& [index, spline] : splines) {
      requireIndex(index, objects_);
      const auto i = static_cast<std::size_t>(index);
      requireReplaceable(objects_[i], content_[i].spline, spline);
    }
    for (const auto& [index, spline] : splines) replace(index, spline);
  }

  std::vector<std::string> replaceForms(const std::vector<std::pair<Index, AnySpline>>& splines) override {
    for (const auto& [index, spline] : splines) {
      requireIndex(index, objects_);
      requireSameDomain(objects_[static_cast<std::size_t>(index)], spline);
    }
    for (const auto& [index, spline] : splines) {
      const auto i = static_cast<std::size_t>(index);
      objects_[i].spline = content_[i].spline = spline;
      objects_[i].kind = kindOf(spline);
    }
    return std::vector<std::string>(splines.size());
  }

  using Model::sharedEdges;
  std::vector<SharedEdge> sharedEdges(double within) const override {
    const double tolerance = std::max(kSamePlace * size(), within);
    std::vector<FaceEdge> sides;
    std::vector<const Surface*> surfaces(objects_.size(), nullptr);
    for (std::size_t i = 0; i < objects_.size(); ++i) {
      const auto* surface = objects_[i].spline ? std::get_if<Surface>(&*objects_[i].spline) : nullptr;
      if (surface == nullptr) continue;
      surfaces[i] = surface;
      for (int side = 0; side < 4; ++side) {
        sides.push_back(sideEdge(*surface, static_cast<Index>(i), side));
        sides.back().name = objects_[i].name;
        sides.back().tolerance = tolerance;
      }
    }
    std::vector<SharedEdge> edges = coincidentEdges(sides, surfaces);
    markCrowded(edges);
    return edges;
  }

  Audit audit() const override { return {}; }

  void write(const std::filesystem::path& path) const override {
    std::vector<PlainObject> content = content_;
    for (std::size_t i = 0; i < content.size(); ++i) {
      content[i].spline = objects_[i].spline;
      if (content[i].name.empty()) content[i].name = objects_[i].name;
    }
    writePlain(path, content, unit_);
  }

 private:
  std::vector<PlainObject> content_;  // as read
  FileKind kind_;
  std::string unit_;
  std::vector<Object> objects_;
};

// By content, then by ending. A table of numbers may begin like a .g2 file: there the ending decides.
FileKind fileKindOf(const std::string& text, const std::filesystem::path& path) {
  const auto byContent = fileKindOfContent(text);
  if (!byContent) return fileKindOfEnding(path);
  const std::string ending = path.extension().string();
  const bool table = ending == ".csv" || ending == ".dat";
  return *byContent == FileKind::g2 && table ? FileKind::points : *byContent;
}

}  // namespace

void Model::convertAnalytic(const std::vector<Index>& which) {
  for (Index index : which) requireIndex(index, objects());
}

std::unique_ptr<Model> readModel(const std::filesystem::path& path) {
  const std::string text = readFile(path);
  if (text.empty()) throw InvalidInput(fmt::format("'{}' is empty", path.string()));
  const FileKind kind = fileKindOf(text, path);
  if (kind != FileKind::g2 && kind != FileKind::json && kind != FileKind::points) return readCad(path, kind);
  try {
    if (kind == FileKind::points) return digitisedModel(text, path);
    if (kind == FileKind::g2) return std::make_unique<PlainModel>(parseG2(text), kind, "");
    JsonContent content = parseJson(text);
    return std::make_unique<PlainModel>(std::move(content.objects), kind, content.unit);
  } catch (const InvalidInput& error) {
    throw InvalidInput(fmt::format("'{}': {}", path.string(), error.what()));
  }
}

std::unique_ptr<Model> modelOf(std::vector<AnySpline> splines, std::vector<std::string> names,
                               const std::string& unit) {
  std::vector<PlainObject> content;
  for (std::size_t i = 0; i < splines.size(); ++i) {
    content.push_back({i < names.size() ? names[i] : "", std::move(splines[i]), "", ""});
  }
  return std::make_unique<PlainModel>(std::move(content), FileKind::g2, unit);
}

}  // namespace strak
