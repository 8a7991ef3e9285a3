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
  std::string name;                  // the file's own name if it has one, else "face 3", "curve 1", ...
  std::string kind;                  // for people: "B-spline surface", "plane", "rational B-spline surface", ...
  std::optional<AnySpline> spline;   // in the object's own coordinates and parameters; empty for other kinds
  std::string leftAlone;             // why it cannot be faired (a clause, lower case); empty if it can
  // Trimming curves in the parameter plane, one dense polyline an edge; empty for whole surfaces, curves and volumes.
  std::vector<std::vector<Eigen::Vector2d>> trims;
  // Which sides of the domain (u low, u high, v low, v high) are wholly edges of the face, so that strips there suffice.
  std::array<bool, 4> naturalSide{true, true, true, true};
  std::vector<Index> sharedWith;     // numbers of the objects that share this very surface (instances); changed together
};

// How well the edges of a face fit: the largest distance between an edge's 3D curve and its image on a surface.
struct EdgeFit {
  std::string name;      // "edge 12"
  double gap = 0;        // measured densely
  double tolerance = 0;  // what the file claims
};

// The whole-model check before or after a change.
struct Audit {
  bool valid = true;                 // the CAD kernel's own checker; true where there is nothing to check
  Index invalidFaces = 0;
  double largestGap = 0;
  double largestTolerance = 0;
  std::vector<EdgeFit> edges;
};

// An open file. Everything that is not replaced is written back as it was read.
class Model {
 public:
  virtual ~Model() = default;

  virtual const std::vector<Object>& objects() const = 0;
  virtual std::string format() const = 0;  // "STEP", "IGES", "BREP", "g2", "JSON"
  virtual std::string unit() const = 0;    // "mm", "inch", ..., "" if the file has none
  virtual double size() const = 0;         // diagonal of the bounding box, in model units

  // Puts `spline` in the place of object `index`'s. It must have the same domain and degree and the old knots among its
  // own (knots may have been inserted). Objects in sharedWith change too. Throws InvalidInput for any other spline.
  virtual void replace(Index index, const AnySpline& spline) = 0;

  // Densely measured gaps of all edges, and the kernel's checker. Empty for plain splines.
  virtual Audit audit() const = 0;

  // Writes to `path` (format by its ending; beside, then renamed). Throws InvalidInput for an unknown ending.
  virtual void write(const std::filesystem::path& path) const = 0;
};

// Opens a file: kind by content, then by ending. Throws InvalidInput with one sentence if it cannot be understood.
std::unique_ptr<Model> readModel(const std::filesystem::path& path);

// A model made of splines, for files that are to be written from nothing.
std::unique_ptr<Model> modelOf(std::vector<AnySpline> splines, std::vector<std::string> names = {});

}  // namespace strak
