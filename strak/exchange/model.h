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

// An open file. Everything that is not replaced is written back as it was read. All lengths are in the model's unit,
// which is the file's: a hood in metres has coordinates, sizes and gaps in metres.
class Model {
 public:
  virtual ~Model() = default;

  virtual const std::vector<Object>& objects() const = 0;
  virtual std::string format() const = 0;  // "STEP", "IGES", "BREP", "g2", "JSON"
  virtual std::string unit() const = 0;    // "mm", "inch", ..., "" if the file has none
  virtual double size() const = 0;         // diagonal of the bounding box, in model units

  // Puts `spline` in the place of object `index`'s. It must have the same domain and degree and the knots that the file
  // has among its own (knots may have been inserted); so the spline as it was read puts everything back to the bit.
  // Objects in sharedWith change too. Throws InvalidInput for any other spline, for an object left alone, and for a
  // free edge whose ends would move.
  virtual void replace(Index index, const AnySpline& spline) = 0;

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
