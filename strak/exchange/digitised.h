#pragma once
//
// Digitised curves: airfoil files (.dat, Selig's and Lednicer's order), tables of coordinates (.csv, .txt: race tracks,
// race lines, measured sections) and point clouds of one curve (.pcd, ASCII).
//
// They are read as a cubic spline that passes through every point, with chord-length parameters, closed where the
// points are; they can be written back with the points moved to where the spline is at their parameters.

#include <filesystem>
#include <string>
#include <string_view>
#include <vector>

#include "strak/spline/spline.h"

namespace strak {

// A point's line in the file, so that it can be written back as it was.
struct DigitisedPoint {
  Index line = 0;        // number of the line, from 0
  double parameter = 0;  // of the spline
};

struct DigitisedCurve {
  std::string name;
  Curve curve;  // cubic, 2 or 3 coordinates
  bool closed = false;
  std::vector<DigitisedPoint> places;  // one a point of the file, in the order of the curve
  std::vector<std::size_t> columns;    // of the coordinates
  std::vector<std::string> lines;      // of the file
};

// Reads the text. Numbers are separated by commas, semicolons, blanks or tabs; two or three columns are coordinates (by
// a header's names x, y, z if it has one, else x, y; a header may name a column s before them); what follows them, like
// track widths, is kept. Repeated points are skipped. Curves are closed if the last point is the first one again, or as
// near to it as its neighbours are, and the direction turns by less than 60 degrees there (an airfoil's trailing edge
// stays open). Throws InvalidInput with the line that cannot be understood, or for fewer than 4 points.
DigitisedCurve parseDigitised(std::string_view text, const std::string& fileName);

// The file with its coordinates replaced by the points of `curve` at the parameters of the points, everything else as
// it was. For .csv, .txt and .dat alike. Throws InvalidInput if the curve has another dimension or domain.
std::string formatDigitised(const DigitisedCurve& original, const Curve& curve);

// The cubic C2 spline through the rows of `points` at chord-length parameters on [0, length]: closed (C2 at the seam)
// or open with the not-a-knot ends of de Boor. `parameters` gets one value a point. Throws InvalidInput for fewer than
// 4 points or two equal neighbours.
Curve interpolatingCurve(const Net& points, bool closed, std::vector<double>* parameters = nullptr);

}  // namespace strak
