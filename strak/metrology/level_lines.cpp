#include "strak/metrology/level_lines.h"

#include <tbb/blocked_range.h>
#include <tbb/parallel_for.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <unordered_map>

#include "strak/metrology/curvature.h"

namespace strak {

namespace {

using Eigen::Vector2d;
using Eigen::Vector3d;

constexpr double kNudge = 1e-5;     // of a piece: how far inside a collapsed edge the normal is taken
constexpr int kMaxInsertions = 5;   // halvings of a chord
constexpr int kMaxBisections = 40;  // of a chord that a trimming curve cuts

struct Sample {
  double value = std::numeric_limits<double>::quiet_NaN();  // where there is no normal
  Vector3d point = Vector3d::Zero();
};

Sample sampleFrom(const SurfaceJet& jet, const SurfaceField& field) {
  Sample s{.point = jet[0]};
  if (const auto normal = unitNormal(jet[1], jet[2])) s.value = field(jet[0], *normal);
  return s;
}

// The field at a point of a piece; where the surface is singular its limit along the way to the middle of the piece.
Sample sampleAt(const SurfacePiece& piece, const SurfaceField& field, double u, double v) {
  SurfaceJet jet;
  piece.at(u, v, 1, jet);
  Sample s = sampleFrom(jet, field);
  if (std::isnan(s.value)) {
    const double middleU = (piece.from(0) + piece.to(0)) / 2, middleV = (piece.from(1) + piece.to(1)) / 2;
    piece.at(std::lerp(u, middleU, kNudge), std::lerp(v, middleV, kNudge), 1, jet);
    s.value = sampleFrom(jet, field).value;
  }
  return s;
}

// The end (one past the last) of the cells with the same span as cell `first`.
Index endOfSpan(const Band& band, Index first) {
  Index end = first;
  const auto span = band.spans[static_cast<std::size_t>(first)];
  while (end < static_cast<Index>(band.spans.size()) && band.spans[static_cast<std::size_t>(end)] == span) ++end;
  return end;
}

// Finds the lines of one level on one grid.
class Tracer {
 public:
  Tracer(const LineGrid& grid, double level, double tolerance) : grid_(grid), level_(level), tolerance_(tolerance) {}

  std::vector<LineTrace> run() {
    collectSegments();
    std::vector<LineTrace> result;
    // Open lines first, from their lower end; what is left are loops.
    for (const bool open : {true, false}) {
      for (std::size_t s = 0; s < segments_.size(); ++s) {
        if (used_[s]) continue;
        if (!open) {
          result.push_back(follow(s, segments_[s].edges[0]));
          continue;
        }
        for (const Index edge : segments_[s].edges) {
          if (edges_.at(edge)[1] < 0) {
            result.push_back(follow(s, edge));
            break;
          }
        }
      }
    }
    for (LineTrace& trace : result) refine(trace);
    return result;
  }

 private:
  struct Segment {
    std::array<Index, 2> edges, cell;
  };

  // Edges along v (from node (i, j) to (i, j + 1)) have even numbers, those along u odd ones.
  Index edgeNumber(Index i, Index j, int direction) const {
    return ((i * (grid_.cellsV() + 1)) + j) * 2 + (direction == 1 ? 0 : 1);
  }

  bool above(Index i, Index j) const { return grid_.values(i, j) >= level_; }

  void collectSegments() {
    for (Index i = 0; i < grid_.cellsU(); ++i) {
      for (Index j = 0; j < grid_.cellsV(); ++j) {
        const bool corner[4] = {above(i, j), above(i + 1, j), above(i + 1, j + 1), above(i, j + 1)};
        if (corner[0] == corner[1] && corner[1] == corner[2] && corner[2] == corner[3]) continue;
        if (grid_.values.block<2, 2>(i, j).hasNaN()) continue;
        const Index edge[4] = {edgeNumber(i, j, 0), edgeNumber(i + 1, j, 1), edgeNumber(i, j + 1, 0),
                               edgeNumber(i, j, 1)};
        std::vector<int> crossed;
        for (int e = 0; e < 4; ++e) {
          if (corner[e] != corner[(e + 1) % 4]) crossed.push_back(e);
        }
        if (crossed.size() == 2) {
          addSegment(edge[crossed[0]], edge[crossed[1]], i, j);
          continue;
        }
        // A saddle: the middle says which corners belong together. Edge e goes from corner e to corner e + 1.
        const Vector2d middle = (grid_.node(i, j) + grid_.node(i + 1, j + 1)) / 2;
        const bool inside = sampleAt(grid_.piece(i, j), *grid_.field, middle[0], middle[1]).value >= level_;
        const int shift = inside == corner[0] ? 0 : 3;
        addSegment(edge[shift], edge[(shift + 1) % 4], i, j);
        addSegment(edge[(shift + 2) % 4], edge[(shift + 3) % 4], i, j);
      }
    }
    used_.assign(segments_.size(), false);
  }

  void addSegment(Index a, Index b, Index i, Index j) {
    const auto number = static_cast<Index>(segments_.size());
    segments_.push_back({{a, b}, {i, j}});
    for (const Index edge : {a, b}) {
      auto [place, fresh] = edges_.try_emplace(edge, std::array<Index, 2>{number, -1});
      if (!fresh) place->second[1] = number;
    }
  }

  // The line through segment `s` that starts on its edge `edge`.
  LineTrace follow(std::size_t s, Index edge) {
    LineTrace trace;
    const Index start = edge;
    trace.vertices.push_back(onEdge(edge, segments_[s].cell));
    while (true) {
      used_[s] = true;
      trace.cells.push_back(segments_[s].cell);
      edge = segments_[s].edges[segments_[s].edges[0] == edge ? 1 : 0];
      if (edge == start) {
        trace.closed = true;
        trace.vertices.push_back(trace.vertices.front());
        return trace;
      }
      trace.vertices.push_back(onEdge(edge, segments_[s].cell));
      const auto& neighbours = edges_.at(edge);
      const Index next = neighbours[neighbours[0] == static_cast<Index>(s) ? 1 : 0];
      if (next < 0 || used_[static_cast<std::size_t>(next)]) return trace;
      s = static_cast<std::size_t>(next);
    }
  }

  // Where the level crosses a grid edge: a bracketed root (regula falsi in the Illinois form).
  LineVertex onEdge(Index edge, const std::array<Index, 2>& cell) const {
    const Index node = edge / 2, i = node / (grid_.cellsV() + 1), j = node % (grid_.cellsV() + 1);
    const bool alongU = edge % 2 == 1;
    const Index i1 = alongU ? i + 1 : i, j1 = alongU ? j : j + 1;
    const Vector2d a = grid_.node(i, j), b = grid_.node(i1, j1);
    const SurfacePiece piece = grid_.piece(cell[0], cell[1]);
    double t0 = 0, t1 = 1, f0 = grid_.values(i, j) - level_, f1 = grid_.values(i1, j1) - level_;
    double t = 0.5;
    int side = 0;
    Sample sample;
    Vector2d place;
    for (int step = 0; step < 60; ++step) {
      t = std::clamp(t0 - f0 * (t1 - t0) / (f1 - f0), t0, t1);
      place = a + t * (b - a);
      sample = sampleAt(piece, *grid_.field, place[0], place[1]);
      const double f = sample.value - level_;
      if (!(std::abs(f) > grid_.accuracy) || t1 - t0 < 1e-15) break;
      if ((f > 0) == (f1 > 0)) {
        t1 = t;
        f1 = f;
        if (side == 1) f0 /= 2;
        side = 1;
      } else {
        t0 = t;
        f0 = f;
        if (side == -1) f1 /= 2;
        side = -1;
      }
    }
    return {place, sample.point};
  }

  void refine(LineTrace& trace) const {
    LineTrace fine;
    fine.closed = trace.closed;
    for (std::size_t s = 0; s < trace.cells.size(); ++s) {
      fine.vertices.push_back(trace.vertices[s]);
      insertBetween(trace.vertices[s], trace.vertices[s + 1], trace.cells[s], 0, fine);
      fine.cells.push_back(trace.cells[s]);
    }
    fine.vertices.push_back(trace.vertices.back());
    trace = std::move(fine);
  }

  void insertBetween(const LineVertex& a, const LineVertex& b, const std::array<Index, 2>& cell, int depth,
                     LineTrace& out) const {
    if (depth == kMaxInsertions) return;
    const auto middle = betweenVertices(grid_, level_, a, b, 0.5, cell);
    if (!middle) return;
    const Vector3d chord = b.point - a.point, offset = middle->point - a.point;
    const double length = chord.squaredNorm();
    const double t = length > 0 ? std::clamp(offset.dot(chord) / length, 0.0, 1.0) : 0;
    if ((offset - t * chord).norm() <= tolerance_) return;
    insertBetween(a, *middle, cell, depth + 1, out);
    out.cells.push_back(cell);
    out.vertices.push_back(*middle);
    insertBetween(*middle, b, cell, depth + 1, out);
  }

  const LineGrid& grid_;
  double level_, tolerance_;
  std::vector<Segment> segments_;
  std::unordered_map<Index, std::array<Index, 2>> edges_;  // the segments at an edge, -1 for none
  std::vector<bool> used_;
};

}  // namespace

std::vector<Band> bandsOf(const KnotVector& knots, const LineOptions& options) {
  const auto spans = knots.spans();
  const auto count = static_cast<Index>(spans.size());
  Index cells = std::max(options.samplesPerSpan, (options.minSamples + count - 1) / count);
  cells = std::max<Index>(1, std::min(cells, options.maxSamples / count));
  std::vector<Band> result;
  for (std::size_t s = 0; s < spans.size(); ++s) {
    // Between two spans lie as many steps as their common knot is multiple.
    const bool smooth = s > 0 && spans[s] - spans[s - 1] < knots.degree();
    const double from = knots[spans[s]], to = knots[spans[s] + 1];
    if (!smooth) result.push_back({{from}, {}});
    for (Index i = 1; i <= cells; ++i) {
      result.back().parameters.push_back(
          i == cells ? to : std::lerp(from, to, static_cast<double>(i) / static_cast<double>(cells)));
      result.back().spans.push_back(spans[s]);
    }
  }
  return result;
}

LineGrid::LineGrid(const Surface& s, const SurfaceField& f, const Band& bandU, const Band& bandV)
    : surface(&s), field(&f), u(&bandU), v(&bandV), values(cellsU() + 1, cellsV() + 1) {
  std::vector<std::array<Index, 2>> strips;
  for (Index i = 0; i < cellsU(); i = endOfSpan(*u, i)) strips.push_back({i, endOfSpan(*u, i)});
  tbb::parallel_for(tbb::blocked_range<std::size_t>(0, strips.size(), 1), [&](const auto& range) {
    std::vector<SurfaceJet> jets;
    for (std::size_t n = range.begin(); n < range.end(); ++n) {
      // A node between two spans belongs to the later one.
      const auto [firstI, endI] = strips[n];
      const Index stopI = endI == cellsU() ? endI + 1 : endI;
      const std::vector<double> us(u->parameters.begin() + firstI, u->parameters.begin() + stopI);
      for (Index firstJ = 0; firstJ < cellsV();) {
        const Index endJ = endOfSpan(*v, firstJ);
        const Index stopJ = endJ == cellsV() ? endJ + 1 : endJ;
        const std::vector<double> vs(v->parameters.begin() + firstJ, v->parameters.begin() + stopJ);
        const SurfacePiece part = piece(firstI, firstJ);
        part.grid(us, vs, 1, jets);
        for (std::size_t i = 0; i < us.size(); ++i) {
          for (std::size_t j = 0; j < vs.size(); ++j) {
            Sample sample = sampleFrom(jets[i * vs.size() + j], *field);
            if (std::isnan(sample.value)) sample = sampleAt(part, *field, us[i], vs[j]);
            values(firstI + static_cast<Index>(i), firstJ + static_cast<Index>(j)) = sample.value;
          }
        }
        firstJ = endJ;
      }
    }
  });
  double least = std::numeric_limits<double>::infinity(), most = -least;
  for (const double value : values.reshaped()) {
    if (std::isnan(value)) continue;
    least = std::min(least, value);
    most = std::max(most, value);
  }
  accuracy = least <= most ? 1e-12 * (most - least) + 1e-15 * std::max({1.0, std::abs(least), std::abs(most)}) : 0;
}

std::optional<LineVertex> betweenVertices(const LineGrid& grid, double level, const LineVertex& a, const LineVertex& b,
                                          double t, const std::array<Index, 2>& cell) {
  const SurfacePiece piece = grid.piece(cell[0], cell[1]);
  const Vector2d low = grid.node(cell[0], cell[1]), high = grid.node(cell[0] + 1, cell[1] + 1);
  const Eigen::Array2d size = (high - low).array();
  const Vector2d middle = a.parameters + t * (b.parameters - a.parameters);
  const Eigen::Array2d along = (b.parameters - a.parameters).array() / size;
  const Vector2d across = (Eigen::Array2d(-along[1], along[0]) * size).matrix();
  double s0 = 0, s1 = 0.05;
  Sample sample = sampleAt(piece, *grid.field, middle[0], middle[1]);
  double f0 = sample.value - level;
  for (int i = 0; i < 12; ++i) {
    if (std::abs(f0) <= grid.accuracy) return LineVertex{middle + s0 * across, sample.point};
    const Vector2d next = middle + s1 * across;
    sample = sampleAt(piece, *grid.field, next[0], next[1]);
    const double f1 = sample.value - level;
    const double step = f1 * (s1 - s0) / (f1 - f0);
    s0 = s1;
    f0 = f1;
    if (!std::isfinite(step)) break;
    s1 -= step;
    if (std::abs(s1) > 0.5) break;
  }
  if (std::abs(f0) <= grid.accuracy) return LineVertex{middle + s0 * across, sample.point};
  return std::nullopt;
}

std::vector<LineTrace> traceLevel(const LineGrid& grid, double level, double tolerance) {
  return Tracer(grid, level, tolerance).run();
}

std::vector<SurfaceLine> clippedLines(
    const LineTrace& trace, double level, const std::function<bool(double u, double v)>& inside,
    const std::function<std::optional<LineVertex>(std::size_t s, double t)>& between) {
  std::vector<SurfaceLine> out;
  SurfaceLine line;
  line.level = level;
  const auto add = [&](const LineVertex& v) {
    line.parameters.push_back(v.parameters);
    line.points.push_back(v.point);
  };
  const auto finish = [&] {
    if (line.points.size() > 1) out.push_back(line);
    line = SurfaceLine();
    line.level = level;
  };
  if (!inside) {
    for (const LineVertex& v : trace.vertices) add(v);
    line.closed = trace.closed;
    finish();
    return out;
  }
  const auto isInside = [&](const LineVertex& v) { return inside(v.parameters[0], v.parameters[1]); };
  // The last point inside on the chord from an inner vertex (place 0 or 1) to an outer one.
  const auto cut = [&](std::size_t s, double in, double outer) {
    LineVertex best = trace.vertices[in == 0 ? s : s + 1];
    for (int i = 0; i < kMaxBisections && std::abs(outer - in) > 1e-9; ++i) {
      const double t = (in + outer) / 2;
      const auto v = between(s, t);
      if (v && isInside(*v)) {
        best = *v;
        in = t;
      } else {
        outer = t;
      }
    }
    return best;
  };
  bool previous = isInside(trace.vertices[0]), whole = previous;
  if (previous) add(trace.vertices[0]);
  for (std::size_t s = 0; s + 1 < trace.vertices.size(); ++s) {
    const bool now = isInside(trace.vertices[s + 1]);
    whole = whole && now;
    if (previous && !now) {
      add(cut(s, 0, 1));
      finish();
    }
    if (!previous && now) add(cut(s, 1, 0));
    if (now) add(trace.vertices[s + 1]);
    previous = now;
  }
  line.closed = trace.closed && whole;
  finish();
  return out;
}

}  // namespace strak
