#include "strak/exchange/digitised_model.h"

#include "strak/base/error.h"
#include "strak/base/file.h"
#include "strak/exchange/digitised.h"
#include "strak/exchange/file_kind.h"
#include "strak/exchange/replaceable.h"

namespace strak {
namespace {

class DigitisedModel : public Model {
 public:
  explicit DigitisedModel(DigitisedCurve content) : content_(std::move(content)), asRead_(content_.curve), objects_(1) {
    objects_[0].name = content_.name;
    objects_[0].kind = "digitised curve";
    objects_[0].spline = content_.curve;
  }

  const std::vector<Object>& objects() const override { return objects_; }
  std::string format() const override { return fileKindName(FileKind::points); }
  std::string unit() const override { return ""; }
  double size() const override {
    const Net& net = content_.curve.net();
    return (net.colwise().maxCoeff() - net.colwise().minCoeff()).stableNorm();
  }

  void replace(Index index, const AnySpline& spline) override {
    requireIndex(index, objects_);
    requireReplaceable(objects_[0], asRead_, spline);
    objects_[0].spline = spline;
  }

  void replaceTogether(const std::vector<std::pair<Index, AnySpline>>& splines) override {
    if (!splines.empty()) throw InvalidInput("a digitised curve has no faces that could be changed together");
  }
  std::vector<std::string> replaceForms(const std::vector<std::pair<Index, AnySpline>>& splines) override {
    for (const auto& [index, spline] : splines) {
      requireIndex(index, objects_);
      requireSameDomain(objects_[0], spline);
      objects_[0].spline = asRead_ = spline;
    }
    return std::vector<std::string>(splines.size());
  }
  std::vector<SharedEdge> sharedEdges(double) const override { return {}; }

  Audit audit() const override { return {}; }

  void write(const std::filesystem::path& path) const override {
    if (fileKindOfEnding(path) == FileKind::points) {
      writeFile(path, formatDigitised(content_, std::get<Curve>(*objects_[0].spline)));
    } else {
      writePlain(path, {{objects_[0].name, objects_[0].spline, "", ""}}, "");
    }
  }

 private:
  DigitisedCurve content_;
  std::optional<AnySpline> asRead_;
  std::vector<Object> objects_;
};

}  // namespace

std::unique_ptr<Model> digitisedModel(const std::string& text, const std::filesystem::path& path) {
  return std::make_unique<DigitisedModel>(parseDigitised(text, path.filename().string()));
}

}  // namespace strak
