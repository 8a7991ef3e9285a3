#pragma once
//
// How lines field = level are found on a surface: grids of samples over the parts where it is C1, lines traced through
// the grid cells, sharpened by root finding, and cut by a predicate. The machinery of isophotes.h.

#include <Eigen/Core>
#include <array>
#include <optional>
#include <vector>

#include "strak/metrology/isophotes.h"
#include "strak/metrology/piece.h"

namespace strak {

// Neighbouring spans between which the surface is C1, cut into grid cells.
struct Band {
  std::vector<double> parameters;
  std::vector<Index> spans;  // of the cells: one less than parameters
};

std::vector<Band> bandsOf(const KnotVector& knots, const LineOptions& options);

// The field on the nodes of a grid of cells over a part of the surface that is C1; NaN where there is no normal. Refers
// to everything that it is made from.
struct LineGrid {
  const Surface* surface;
  const SurfaceField* field;
  const Band* u;
  const Band* v;
  Eigen::MatrixXd values;
  double accuracy;  // of the field: what counts as being on a level

  // Samples the field. Multi-threaded.
  LineGrid(const Surface& s, const SurfaceField& f, const Band& bandU, const Band& bandV);

  SurfacePiece piece(Index i, Index j) const {
    return {*surface, u->spans[static_cast<std::size_t>(i)], v->spans[static_cast<std::size_t>(j)]};
  }
  Eigen::Vector2d node(Index i, Index j) const {
    return {u->parameters[static_cast<std::size_t>(i)], v->parameters[static_cast<std::size_t>(j)]};
  }
  Index cellsU() const { return static_cast<Index>(u->spans.size()); }
  Index cellsV() const { return static_cast<Index>(v->spans.size()); }
};

struct LineVertex {
  Eigen::Vector2d parameters;
  Eigen::Vector3d point;
};

// A line on its way: vertices, and between each two of them the grid cell that they share.
struct LineTrace {
  std::vector<LineVertex> vertices;
  std::vector<std::array<Index, 2>> cells;
  bool closed = false;
};

// The lines of a level on a grid; chords are within `tolerance` of the line.
std::vector<LineTrace> traceLevel(const LineGrid& grid, double level, double tolerance);

// The point of the level line near the place `t` of the chord between two vertices in a cell: searched across the chord
// by the secant method. Nothing if it is not found near by.
std::optional<LineVertex> betweenVertices(const LineGrid& grid, double level, const LineVertex& a, const LineVertex& b,
                                          double t, const std::array<Index, 2>& cell);

// The parts of the trace where `inside` holds (all of it if there is none). `between(s, t)` gives the line's point at
// the place t of its chord s.
std::vector<SurfaceLine> clippedLines(const LineTrace& trace, double level,
                                      const std::function<bool(double u, double v)>& inside,
                                      const std::function<std::optional<LineVertex>(std::size_t s, double t)>& between);

}  // namespace strak
