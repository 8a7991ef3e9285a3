#include <BRepBndLib.hxx>
#include <BRep_Tool.hxx>
#include <Bnd_Box.hxx>
#include <Geom_OffsetSurface.hxx>
#include <Message.hxx>
#include <Message_Messenger.hxx>
#include <Precision.hxx>
#include <Standard_Failure.hxx>
#include <TopExp_Explorer.hxx>
#include <TopTools_MapOfShape.hxx>
#include <TopoDS.hxx>

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <iterator>
#include <map>
#include <set>

#include "strak/base/error.h"
#include "strak/exchange/audit_occ.h"
#include "strak/exchange/cad.h"
#include "strak/exchange/cad_file_occ.h"
#include "strak/exchange/cad_geometry_occ.h"
#include "strak/exchange/cad_names_occ.h"
#include "strak/exchange/convert_analytic_occ.h"
#include "strak/exchange/face_border_occ.h"
#include "strak/exchange/following_edges_occ.h"
#include "strak/exchange/other_form_occ.h"
#include "strak/exchange/periodic_occ.h"
#include "strak/exchange/replaceable.h"
#include "strak/exchange/shared_edges_occ.h"
#include "strak/exchange/shared_geometry_occ.h"
#include "strak/exchange/signal_guard_occ.h"
#include "strak/exchange/write_splines_occ.h"
#include "strak/spline/evaluate.h"

namespace strak::cad {
namespace {

constexpr double kSamePlace = 1e-6;   // of the model's size: unsewn edges this near are the same
constexpr double kHeldEnd = 1e-9;     // of the curve's size: the ends of a free edge must stay this near
constexpr double kConverted = 1e-10;  // of the model's size: what a converted face may differ by

std::string why(const std::string& kind) { return fmt::format("a {} is not a B-spline", kind); }

// An opened CAD file: its faces, and if it has none its curves.
class CadModel : public Model {
 public:
  explicit CadModel(CadFile file) : file_(std::move(file)), names_(namesOf(file_)) {
    openPeriodic(file_.shape);
    addFaces();
    addFreeEdges(objects_.empty());
    noteInstances();
    if (objects_.empty()) throw InvalidInput("there is no face and no curve in it");
    Bnd_Box box;
    BRepBndLib::Add(file_.shape, box, false);
    box.SetGap(0);
    if (!box.IsVoid() && !box.IsOpen()) size_ = std::sqrt(box.SquareExtent()) / file_.unit.millimetres;
    followingEdges_ = FollowingEdges(file_.shape, size_ * file_.unit.millimetres);
    original_.reserve(objects_.size());
    for (const Object& object : objects_) original_.push_back(object.spline);
  }

  const std::vector<Object>& objects() const override { return objects_; }
  std::string format() const override { return fileKindName(file_.kind); }
  std::string unit() const override { return file_.kind == FileKind::brep ? "" : file_.unit.name; }

  double size() const override { return size_; }

  void replace(Index index, const AnySpline& spline) override {
    requireIndex(index, objects_);
    const auto at = static_cast<std::size_t>(index);
    requireReplaceable(objects_[at], original_[at], spline);
    try {
      if (const auto* surface = std::get_if<Surface>(&spline)) {
        surfaces_.at(keys_[at]).put(*surface);
      } else {
        requireHeldEnds(objects_[at].name, std::get<Curve>(*original_[at]), std::get<Curve>(spline));
        curves_.at(keys_[at]).put(std::get<Curve>(spline));
      }
      objects_[at].spline = spline;
      for (Index i : objects_[at].sharedWith) objects_[static_cast<std::size_t>(i)].spline = spline;
    } catch (const Standard_Failure& failure) {
      throw Failure(fmt::format("{} cannot be changed: Open CASCADE gives up ({})", objects_[at].name,
                                failure.GetMessageString()));
    }
  }

  void replaceTogether(const std::vector<std::pair<Index, AnySpline>>& splines) override {
    for (const auto& [index, spline] : splines) {
      requireIndex(index, objects_);
      const auto at = static_cast<std::size_t>(index);
      requireReplaceable(objects_[at], original_[at], spline);
      if (!std::holds_alternative<Surface>(spline)) {
        throw InvalidInput(fmt::format("{}: only faces can be changed together", objects_[at].name));
      }
    }
    std::vector<std::pair<Index, AnySpline>> before;
    try {
      for (const auto& [index, spline] : splines) {
        before.emplace_back(index, *objects_[static_cast<std::size_t>(index)].spline);
        replace(index, spline);
      }
      followFaces();
    } catch (...) {
      for (auto old = before.rbegin(); old != before.rend(); ++old) replace(old->first, old->second);
      throw;
    }
  }

  std::vector<std::string> replaceForms(const std::vector<std::pair<Index, AnySpline>>& splines) override {
    std::vector<std::string> refused;
    for (const auto& [index, spline] : splines) {
      requireIndex(index, objects_);
      requireSameDomain(objects_[static_cast<std::size_t>(index)], spline);
    }
    ChangedSurfaces changed;
    for (const auto& [index, spline] : splines) {
      const auto at = static_cast<std::size_t>(index);
      const auto surface = surfaces_.find(keys_[at]);
      const Handle(Geom_BSplineSurface) had =
          surface == surfaces_.end() ? Handle(Geom_BSplineSurface)() : surface->second.original;
      refused.push_back(replaceForm(at, spline));
      if (refused.back().empty() && !had.IsNull()) changed.emplace(surfaces_.at(keys_[at]).live.get(), had);
    }
    try {
      if (!changed.empty()) followingEdges_.settle(changed);
    } catch (const Standard_Failure& failure) {
      throw Failure(
          fmt::format("the edges cannot be followed: Open CASCADE gives up ({})", failure.GetMessageString()));
    }
    followingEdges_ = FollowingEdges(file_.shape, size_ * file_.unit.millimetres);
    return refused;
  }

  using Model::sharedEdges;
  std::vector<SharedEdge> sharedEdges(double within) const override {
    try {
      return sharedEdgesOf(file_.shape, objects_, places_, file_.unit.millimetres,
                           std::max(kSamePlace * size_, within));
    } catch (const Standard_Failure& failure) {
      throw Failure(
          fmt::format("the edges cannot be followed: Open CASCADE gives up ({})", failure.GetMessageString()));
    }
  }

  void convertAnalytic(const std::vector<Index>& which) override {
    for (Index index : which) requireIndex(index, objects_);
    for (Index index : which) {
      const auto at = static_cast<std::size_t>(index);
      if (objects_[at].spline || objects_[at].kind == "mesh" || shapes_[at].ShapeType() != TopAbs_FACE) continue;
      const std::string refused = convertGroup(keys_[at]);
      if (!refused.empty()) {
        objects_[at].leftAlone = why(objects_[at].kind) + " and cannot be made one: " + refused;
      }
    }
  }

  Audit audit() const override {
    try {
      return auditShape(file_.shape, file_.unit.millimetres);
    } catch (const Standard_Failure& failure) {
      throw Failure(fmt::format("the edges cannot be checked: Open CASCADE gives up ({})", failure.GetMessageString()));
    }
  }

  void write(const std::filesystem::path& path) const override {
    const FileKind kind = fileKindOfEnding(path);
    if (kind == FileKind::step || kind == FileKind::iges || kind == FileKind::brep) {
      return writeCadFile(file_, path, kind);
    }
    std::vector<PlainObject> plain;
    for (std::size_t i = 0; i < objects_.size(); ++i) {
      if (!objects_[i].spline) continue;
      plain.push_back({objects_[i].name, placed(*objects_[i].spline, places_[i], file_.unit.millimetres), "", ""});
    }
    writePlain(path, plain, unit());
  }

 private:
  static void requireHeldEnds(const std::string& name, const Curve& had, const Curve& has) {
    const KnotVector& knots = had.knots(0);
    const Net points = had.euclideanNet();
    const double size = (points.colwise().maxCoeff() - points.colwise().minCoeff()).stableNorm();
    for (double end : {knots.from(), knots.to()}) {
      if ((evaluate<1>(had, {end}) - evaluate<1>(has, {end})).stableNorm() > kHeldEnd * size) {
        throw InvalidInput(fmt::format("{}: its ends must stay where they are, hold at least one row", name));
      }
    }
  }

  std::string nameOf(const TopoDS_Shape& shape, const char* word, int number) const {
    const auto own = names_.find(shape.TShape().get());
    return own == names_.end() ? fmt::format("{} {}", word, number) : own->second;
  }

  // One unit of our coordinates in Open CASCADE's, before the placement (which may scale) is applied.
  double unitLength(const gp_Trsf& placement) const {
    return file_.unit.millimetres / std::abs(placement.ScaleFactor());
  }

  // Converts the faces on one surface; why not, or empty.
  std::string convertGroup(const Standard_Transient* key) {
    std::vector<std::size_t> group;
    std::vector<TopoDS_Face> all, faces;  // each object's, and each once
    for (std::size_t i = 0; i < objects_.size(); ++i) {
      if (keys_[i] != key) continue;
      group.push_back(i);
      all.push_back(TopoDS::Face(shapes_[i]));
      const bool known =
          std::any_of(faces.begin(), faces.end(), [&](const TopoDS_Face& face) { return face.IsPartner(all.back()); });
      if (!known) faces.push_back(all.back());
    }
    if (carriesOffset_.count(key) != 0) return "an offset surface of the file hangs on it";
    const double length = unitLength(places_[group.front()]);
    Handle(Geom_BSplineSurface) next;
    const std::string refused = convertFaces(faces, kConverted * size_ * file_.unit.millimetres, next);
    if (!refused.empty()) return refused;
    surfaces_[next.get()] = {next, copyAsSpline(next), all, length, {}};
    for (std::size_t i : group) {
      objects_[i].kind = kindOf(Handle(Geom_Surface)(next));
      objects_[i].leftAlone.clear();
      describeSurface(objects_[i], TopoDS::Face(shapes_[i]), next, places_[i]);
      original_[i] = objects_[i].spline;
      keys_[i] = next.get();
      for (std::size_t j : group) {
        if (j != i) objects_[i].sharedWith.push_back(static_cast<Index>(j));
      }
    }
    return "";
  }

  // Why it was refused, or empty.
  std::string replaceForm(std::size_t at, const AnySpline& spline) {
    const Standard_Transient* next = nullptr;
    std::string kind;
    try {
      if (const auto* surface = std::get_if<Surface>(&spline)) {
        SharedSurface shared = surfaces_.at(keys_[at]);
        const Handle(Geom_BSplineSurface) made = fromSpline(*surface, shared.unitLength);
        if (std::string refused = layForm(shared.faces, made); !refused.empty()) return refused;
        shared.live = made;
        shared.original = copyAsSpline(made);
        kind = kindOf(Handle(Geom_Surface)(made));
        next = made.get();
        surfaces_.erase(keys_[at]);
        surfaces_[next] = std::move(shared);
      } else {
        requireHeldEnds(objects_[at].name, std::get<Curve>(*original_[at]), std::get<Curve>(spline));
        SharedCurve shared = curves_.at(keys_[at]);
        const Handle(Geom_BSplineCurve) made = fromSpline(std::get<Curve>(spline), shared.unitLength);
        layForm(shared.edges, made);
        shared.live = made;
        shared.original = copyAsSpline(made);
        kind = kindOf(Handle(Geom_Curve)(made));
        next = made.get();
        curves_.erase(keys_[at]);
        curves_[next] = std::move(shared);
      }
    } catch (const InvalidInput& error) {
      return error.what();
    } catch (const Standard_Failure& failure) {
      return fmt::format("Open CASCADE gives up ({})", failure.GetMessageString());
    }
    std::vector<Index> changed = objects_[at].sharedWith;
    changed.push_back(static_cast<Index>(at));
    for (Index i : changed) {
      const auto object = static_cast<std::size_t>(i);
      objects_[object].spline = original_[object] = spline;
      objects_[object].kind = kind;
      keys_[object] = next;
    }
    return "";
  }

  void add(Object object, const TopoDS_Shape& shape, const gp_Trsf& placement, const Standard_Transient* key) {
    objects_.push_back(std::move(object));
    shapes_.push_back(shape);
    places_.push_back(placement);
    keys_.push_back(key);
  }

  void addFaces() {
    const std::vector<TopoDS_Shape> faces = partsOf(file_.shape, TopAbs_FACE);
    for (const TopoDS_Shape& shape : faces) {
      TopLoc_Location place;
      const Handle(Geom_Surface) surface = BRep_Tool::Surface(TopoDS::Face(shape), place);
      if (surface.IsNull()) continue;
      if (const auto* offset = dynamic_cast<const Geom_OffsetSurface*>(untrimmed(surface).get())) {
        carriesOffset_.insert(untrimmed(offset->BasisSurface()).get());
      }
    }
    for (const TopoDS_Shape& shape : faces) {
      const TopoDS_Face& face = TopoDS::Face(shape);
      TopLoc_Location place;
      const Handle(Geom_Surface) raw = BRep_Tool::Surface(face, place);
      Object object;
      object.name = nameOf(face, "face", static_cast<int>(objects_.size()) + 1);
      if (raw.IsNull()) {
        object.kind = "mesh";
        object.leftAlone = why(object.kind);
        add(std::move(object), face, place.Transformation(), nullptr);
        continue;
      }
      const Handle(Geom_Surface) live = untrimmed(raw);
      object.kind = kindOf(live);
      describeSurface(object, face, live, place.Transformation());
      if (object.leftAlone.empty() && carriesOffset_.count(live.get()) != 0) {
        object.leftAlone = "an offset surface of the file hangs on it";
      }
      if (object.leftAlone.empty()) {
        SharedSurface& shared = surfaces_[live.get()];
        if (shared.live.IsNull()) {
          shared.live = live;
          shared.original = copyAsSpline(live);
          shared.unitLength = unitLength(place.Transformation());
        }
        shared.faces.push_back(face);
      }
      add(std::move(object), face, place.Transformation(), live.get());
    }
  }

  void describeSurface(Object& object, const TopoDS_Face& face, const Handle(Geom_Surface) & live,
                       const gp_Trsf& placement) const {
    const Handle(Geom_BSplineSurface) spline = copyAsSpline(live);
    if (spline.IsNull()) {
      object.leftAlone = why(object.kind);
      return;
    }
    try {
      object.spline = toSpline(*spline, unitLength(placement));
      Border border = borderOf(face, std::get<Surface>(*object.spline));
      object.trims = std::move(border.trims);
      object.naturalSide = border.naturalSide;
      object.leftAlone = border.missing;
    } catch (const InvalidInput& error) {
      object.spline.reset();
      object.leftAlone = error.what();
      return;
    }
    if (spline->IsUPeriodic() || spline->IsVPeriodic()) object.leftAlone = "it is periodic";
  }

  void addFreeEdges(bool only) {
    TopTools_MapOfShape seen;
    int number = 0;
    for (TopExp_Explorer all(file_.shape, TopAbs_EDGE, TopAbs_FACE); all.More(); all.Next()) {
      const TopoDS_Shape& shape = all.Current();
      if (!seen.Add(shape)) continue;
      const TopoDS_Edge& edge = TopoDS::Edge(shape);
      TopLoc_Location place;
      double from = 0, to = 0;
      const Handle(Geom_Curve) raw = BRep_Tool::Curve(edge, place, from, to);
      if (raw.IsNull()) continue;
      const Handle(Geom_Curve) live = untrimmed(raw);
      Object object;
      object.name = nameOf(edge, "curve", ++number);
      object.kind = kindOf(live);
      object.naturalSide = {true, true, false, false};
      describeCurve(object, live, from, to, place.Transformation());
      if (object.leftAlone.empty() && !only) object.leftAlone = "a curve beside the faces of its file stays";
      if (object.leftAlone.empty()) {
        SharedCurve& shared = curves_[live.get()];
        if (shared.live.IsNull()) {
          shared.live = live;
          shared.original = copyAsSpline(live);
          shared.unitLength = unitLength(place.Transformation());
        }
        shared.edges.push_back(edge);
      }
      add(std::move(object), edge, place.Transformation(), live.get());
    }
  }

  void describeCurve(Object& object, const Handle(Geom_Curve) & live, double from, double to,
                     const gp_Trsf& placement) const {
    const Handle(Geom_BSplineCurve) spline = copyAsSpline(live);
    if (spline.IsNull()) {
      object.leftAlone = why(object.kind);
      return;
    }
    try {
      object.spline = toSpline(*spline, unitLength(placement));
    } catch (const InvalidInput& error) {
      object.leftAlone = error.what();
      return;
    }
    const KnotVector& knots = std::get<Curve>(*object.spline).knots(0);
    const double slack = Precision::PConfusion();
    if (from > knots.from() + slack || to < knots.to() - slack)
      object.leftAlone = "its edge is a part of a longer curve";
    if (spline->IsPeriodic()) object.leftAlone = "it is periodic";
  }

  // Edges and corners go where the faces are now.
  void followFaces() {
    ChangedSurfaces changed;
    for (std::size_t i = 0; i < objects_.size(); ++i) {
      const auto shared = surfaces_.find(keys_[i]);
      if (shared == surfaces_.end() || objects_[i].spline == original_[i]) continue;
      changed.emplace(shared->second.live.get(), shared->second.original);
    }
    try {
      followingEdges_.follow(changed);
    } catch (const Standard_Failure& failure) {
      throw Failure(
          fmt::format("the edges cannot follow their faces: Open CASCADE gives up ({})", failure.GetMessageString()));
    }
  }

  // Tells the objects on one surface or curve about one another.
  void noteInstances() {
    std::map<const Standard_Transient*, std::vector<Index>> groups;
    for (std::size_t i = 0; i < objects_.size(); ++i) {
      if (objects_[i].spline) groups[keys_[i]].push_back(static_cast<Index>(i));
    }
    for (const auto& [key, group] : groups) {
      // One that cannot be changed, because its border is unknown, keeps the surface for all.
      const auto fixed = std::find_if(group.begin(), group.end(), [&](Index i) {
        return !objects_[static_cast<std::size_t>(i)].leftAlone.empty();
      });
      for (Index i : group) {
        Object& object = objects_[static_cast<std::size_t>(i)];
        if (fixed != group.end() && object.leftAlone.empty()) {
          object.leftAlone = "it shares its surface with '" + objects_[static_cast<std::size_t>(*fixed)].name +
                             "', which cannot be changed";
        }
        std::vector<Index>& others = object.sharedWith;
        std::copy_if(group.begin(), group.end(), std::back_inserter(others), [&](Index j) { return j != i; });
      }
    }
  }

  CadFile file_;
  std::map<const TopoDS_TShape*, std::string> names_;
  double size_ = 0;
  std::vector<Object> objects_;
  std::vector<std::optional<AnySpline>> original_;  // as read
  std::vector<TopoDS_Shape> shapes_;                // the face or edge of each object
  std::set<const Standard_Transient*> carriesOffset_;
  std::vector<gp_Trsf> places_;                  // where the assembly puts each object
  std::vector<const Standard_Transient*> keys_;  // into the two maps
  std::map<const Standard_Transient*, SharedSurface> surfaces_;
  std::map<const Standard_Transient*, SharedCurve> curves_;
  FollowingEdges followingEdges_;
};

std::unique_ptr<Model> readCadModel(const std::filesystem::path& path, FileKind kind) {
  CadFile file = readCadFile(path, kind);
  std::unique_ptr<Model> model;
  const std::lock_guard lock(readerMutex());
  try {
    if (survives([&] { model = std::make_unique<CadModel>(std::move(file)); })) return model;
  } catch (const InvalidInput& error) {
    throw InvalidInput(fmt::format("'{}': {}", path.string(), error.what()));
  } catch (const Standard_Failure& failure) {
    throw InvalidInput(
        fmt::format("'{}' cannot be read: Open CASCADE gives up ({})", path.string(), failure.GetMessageString()));
  }
  throw InvalidInput(fmt::format("'{}' cannot be read: it is damaged, its references lead nowhere", path.string()));
}

}  // namespace
}  // namespace strak::cad

namespace strak {

void enableCad() {
  static const bool once = [] {
    Message::DefaultMessenger()->ChangePrinters().Clear();  // the kernel's chatter is not for our users
    setCadFormats({cad::readCadModel, cad::writeCadSplines, cad::writeCadTrimmed});
    return true;
  }();
  static_cast<void>(once);
}

}  // namespace strak
