#pragma once
//
// What `strak fair` did, as data, and its two forms: a page to look at and JSON to compute with.

#include <optional>
#include <string>
#include <vector>

#include "strak/exchange/model.h"
#include "strak/fairing/faired.h"
#include "strak/metrology/fairness.h"
#include "strak/metrology/self_intersection.h"
#include "strak/report/before_after.h"
#include "strak/report/edge_joins.h"

namespace strak {

// What became of a curve of the plane or of space.
struct CurveChange {
  CurveFairness before, after;
  Index extremaBefore = 0, extremaAfter = 0;  // counted by curvatureProfile
};

// One object of the file: what it was, what became of it.
struct FairedObject {
  std::string name, kind;                           // as in Object
  std::vector<int> degree;                          // per direction; empty if the object is no spline
  std::vector<Index> points;                        // control points per direction
  std::optional<AnySpline> before;                  // empty if the object is no spline
  std::optional<AnySpline> after;                   // empty if the object was left alone
  std::vector<std::vector<Eigen::Vector2d>> trims;  // as in Object
  std::string leftAlone;           // why it was left alone (a clause, lower case); empty if it was faired
  std::vector<std::string> notes;  // what else a reader should know: inserted knots, shared surfaces, ...
  std::string energyName;          // "thin-plate", ...
  FairingSummary summary;          // energies, gap, steps, stop reason, seconds
  BeforeAfter plate;               // the exact bending energy: int k1^2 + k2^2 dA, of curves int k^2 ds
  std::optional<SurfaceFairness> fairnessBefore, fairnessAfter;  // of surfaces in space
  std::optional<CurveChange> curve;                              // of curves of the plane and of space
  double deviationLower = 0;           // certified: the largest distance really reached and ...
  double deviationUpper = 0;           // ... the bound that none exceeds, model units
  double controlPointMove = 0;         // largest move of a control point
  double heldMaxMove = 0;              // largest move of a held control point
  std::optional<SelfMeeting> meeting;  // whether what moved meets itself (curves and surfaces)
  bool newMeeting = false;             // ... where it did not before

  // What was done to its knots, where that was asked for.
  struct Simplified {
    Index knotsRemoved = 0, pointsBefore = 0, pointsAfter = 0;
  };
  struct Smoothed {
    Index smoothed = 0, kept = 0;  // inner knots (surfaces: knot lines) of low continuity
    double deviation = 0;          // certified, by smoothing alone
  };
  std::optional<Simplified> simplified;
  std::optional<Smoothed> smoothed;

  bool faired() const { return after.has_value(); }
};

// The entry of an object that nothing has been done to yet.
FairedObject describe(const Object& object);

struct FairReport {
  std::string version;  // of the program
  std::string command;  // the command line that made it
  std::string inputName, outputName;
  std::string unit;               // "mm", ..., "" if the file has none
  double size = 0;                // diagonal of the bounding box, model units
  double tolerance = kUnlimited;  // model units
  std::string toleranceKind;      // "points" or "surface"
  Audit before, after;            // of the whole model
  std::vector<FairedObject> objects;
  std::vector<EdgeJoin> joins;  // where faces meet
  double seconds = 0;           // of the whole run
};

// A self-contained HTML page: figures, tables, before and after as drawings (SVG) and, with WebGL, to turn, light and
// measure. Needs no network and runs no code but its own; all names are escaped. The same report gives the same bytes.
// Size: 2 to about 12 MB, whatever the number of objects (large models are sampled more coarsely).
std::string fairReportHtml(const FairReport& report);

// One JSON object: version, command, inputs, output, unit, size, tolerance, tolerance_kind, objects, audit, joins,
// seconds.
// An object: name, kind, degree, points, left_alone or null, notes and, if it was faired, energy {name, before, after},
// plate {before, after}, of curves also curve {before, after} and curvatureExtrema {before, after}, deviation
// {control_points, lower, certified}, self_intersection (free: the move made none, proven; undecided; as-before: the
// input has one, too), held_max_move, steps, gap, stop_reason, seconds; with --simplify also simplified
// {knotsRemoved, pointsBefore, pointsAfter}, with --smooth-knots smoothed_knots {smoothed, kept, deviation}. A join:
// edge, faces (object numbers from 1), gap, angle (degrees), curvature, angle_rms, curvature_rms, kind, each {before,
// after}. Numbers read back to the same doubles; infinities and NaN are null.
std::string fairReportJson(const FairReport& report);

}  // namespace strak
