#pragma once
//
// The content of a file while it is worked on: its splines, what is in the way of changing them, and how to put changed
// ones back with everything else untouched.

#include <Eigen/Core>
#include <array>
#include <filesystem>
#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <variant>
#include <vector>

#include "strak/spline/spline.h"

namespace strak {

using AnySpline = std::variant<Curve, Surface, Volume>;

// One curve, face or block of a file.
struct Object {
  std::string name;  // the file's own name if it has one, else "face 3", "curve 1", ...
  std::string kind;  // for people: "B-spline surface", "plane", "rational B-spline surface", ...
  // In the object's own coordinates (before an assembly puts it in its place) and parameters, lengths in the model's
  // unit; empty for other kinds.
  std::optional<AnySpline> spline;
  std::string leftAlone;  // why it cannot be faired (a clause, lower case); empty if it can
  // All edges of a face in the parameter plane, each a dense polyline; empty for whole surfaces, curves and volumes.
  std::vector<std::vector<Eigen::Vector2d>> trims;
  // Which sides of the domain (u low, u high, v low, v high) are wholly edges of the face, so that strips there
  // suffice.
  std::array<bool, 4> naturalSide{true, true, true, true};
  std::vector<Index> sharedWith;  // numbers of the objects that share this very surface (instances); changed together
};

// How well an edge fits its faces, in the model's unit.
struct EdgeFit {
  std::string name;      // "edge 12"
  double gap = 0;        // largest distance between the edge's 3D curve and its image on a surface, measured densely
  double tolerance = 0;  // what the file claims
  double faceGap = 0;    // largest distance between its images on two faces (or on both sides of a seam)
};

// The whole-model check before or after a change.
struct Audit {
  bool valid = true;  // the CAD kernel's own checker; true where there is nothing to check
  Index invalidFaces = 0;
  double largestGap = 0;  // over the edges' gaps
  double largestTolerance = 0;
  std::vector<EdgeFit> edges;
};

// Where two faces meet, or a face meets itself (a seam). The sides of a domain are numbered as in Object::naturalSide:
// 0 u low, 1 u high, 2 v low, 3 v high.
struct SharedEdge {
  std::string name;            // "edge 12", as in the audit; "face 1 / face 2" where every face has an edge of its own
  Index faceA = 0, faceB = 0;  // numbers of the objects; the same for a seam
  // The edge in the parameters of either face: polylines at even steps of the edge's own parameter, running the same
  // way. Two points where it is a straight line there, which is exact; a few hundred on a trimmed face. lineB is empty
  // where face B is no spline.
  std::vector<Eigen::Vector2d> lineA, lineB;
  std::optional<int> sideA, sideB;    // the side of the domain, if the edge is the whole of it
  std::optional<int> alongA, alongB;  // the side on which it lies, whole or in part
  bool reversed = false;              // along sides of both: the border rows run in opposite directions
  bool sameNormals = true;            // X_u x X_v points to the same side of the part on both faces
  bool sewn = true;                   // one edge of the file, not two that coincide
  bool samePlace = true;              // both faces stand in one place, so that their own coordinates agree
  std::string notJoinable;            // why its faces cannot be changed together (a clause); empty if they can
};

// An open file. Everything that is not replaced is written back as it was read. All lengths are in the model's unit,
// which is the file's: a hood in metres has coordinates, sizes and gaps in metres.
class Model {
 public:
  virtual ~Model() = default;

  virtual const std::vector<Object>& objects() const = 0;
  virtual std::string format() const = 0;  // "STEP", "IGES", "BREP", "g2", "JSON"
  virtual std::string unit() const = 0;    // "mm", "inch", ..., "" if the file has none
  virtual double size() const = 0;         // diagonal of the bounding box, in model units

  // Puts `spline` in the place of object `index`'s. It must have the same domain and degree; inner knots may have been
  // inserted or removed (inserted only where the ends are not clamped). Edges keep their curves: audit() tells whether
  // they still fit. The spline as it was read puts everything back to the bit.
  // Objects in sharedWith change too. Throws InvalidInput for any other spline, for an object left alone, and for a
  // free edge whose ends would move.
  virtual void replace(Index index, const AnySpline& spline) = 0;

  // The same for several objects at once, whose common borders may move: the edges there and their corners move with
  // the faces, the curves in the parameter planes stay. The splines as they were give everything back to the bit.
  // Throws InvalidInput, and changes nothing, like replace and if the faces at an edge would not move alike by 1e-9 of
  // the model's size (a face that is not named does not move). Not for the curves of a file.
  virtual void replaceTogether(const std::vector<std::pair<Index, AnySpline>>& splines) = 0;

  // Puts splines of another form (degree, knots, weights) in the places of objects', with the same domains and nearly
  // the same shapes. Corners stay where they are, and so do edges; those that then lie farther from a face than their
  // tolerances say get the curve of their faces if that fits better, and the tolerance that is measured. Objects in
  // sharedWith change too. Returns for each why it was refused (a clause: the kernel's checker accepts the face no
  // longer), empty where it was not. From then on this is the spline as it was read. Throws InvalidInput, and changes
  // nothing, for an object left alone, and another domain or dimension.
  virtual std::vector<std::string> replaceForms(const std::vector<std::pair<Index, AnySpline>>& splines) = 0;

  // All edges between a spline face and another face, in a fixed order, of the model as it is now. Faces with edges of
  // their own (IGES, .g2, JSON) meet where these coincide from end to end, within the largest of the file's tolerance
  // there, 1e-6 of the size and `within`.
  virtual std::vector<SharedEdge> sharedEdges(double within) const = 0;
  std::vector<SharedEdge> sharedEdges() const { return sharedEdges(0); }

  // Makes the named objects that are planes, cylinders, cones, spheres, tori, extruded or revolved surfaces into
  // B-splines with the same parameters, to 1e-10 of their size, and all edges as they are; instances go along. Where
  // that is not possible, or the face would fit its edges less well, the object stays and its leftAlone says why. Does
  // nothing for other objects. Throws InvalidInput for an index out of range.
  virtual void convertAnalytic(const std::vector<Index>& which);

  // Densely measured gaps of all edges, and the kernel's checker. Empty for plain splines. Edges are counted once,
  // however many instances of a part there are.
  virtual Audit audit() const = 0;

  // Writes to `path` (format by its ending: .stp .step .igs .iges .brep .g2 .json; beside, then renamed). Throws
  // InvalidInput for an unknown ending, Failure if it cannot be written. A CAD file written as .g2 or .json loses what
  // these cannot hold: trimming, faces that are not B-splines, colours; its surfaces are put in their places.
  virtual void write(const std::filesystem::path& path) const = 0;
};

// Opens a file: kind by content, then by ending. Throws InvalidInput with one sentence if it cannot be understood.
// STEP, IGES and BREP need strak::cad and enableCad() (strak/exchange/cad.h) once before.
std::unique_ptr<Model> readModel(const std::filesystem::path& path);

// A model made of splines, for files that are to be written from nothing. Missing names become "curve 1", "surface 2",
// ...
std::unique_ptr<Model> modelOf(std::vector<AnySpline> splines, std::vector<std::string> names = {},
                               const std::string& unit = "");

}  // namespace strak
