#pragma once
//
// The part of a parameter plane that the trimming curves of a face leave.

#include <Eigen/Geometry>
#include <vector>

#include "strak/spline/spline.h"

namespace strak {

// What a box of the parameter plane shows of a region.
enum class Cover : unsigned char { outside, inside, cut };

// A region of the plane bounded by closed polygons; even-odd rule, so the direction of the curves does not matter.
class TrimRegion {
 public:
  struct Segment {
    Eigen::Vector2d from, to;
  };

  // `trims`: open pieces in any order that together close (small gaps between their ends are bridged); points beyond
  // the domain are moved to its border, and pieces are straightened by up to 1e-4 of the domain. With no trims, or
  // trims that leave nothing, the region is the whole domain.
  TrimRegion(const Surface& surface, const std::vector<std::vector<Eigen::Vector2d>>& trims);

  bool isWholeDomain() const { return segments_.empty(); }
  const Eigen::AlignedBox2d& domain() const { return domain_; }

  // Expected O(segments / 256) for evenly spread trims.
  bool inside(const Eigen::Vector2d& parameter) const;

  // Whether the box lies wholly inside or outside. It is cut where a curve comes nearer than 2e-4 of the domain (twice
  // of what the pieces were straightened by), save those along the domain's own border: no box of which something is
  // visible is ever said to be outside. A box may be a point.
  Cover cover(const Eigen::AlignedBox2d& box) const;

  // Of `context`, a TrimRegion: whether something of the box is visible. For DeviationOptions::counts.
  static bool reaches(const double* from, const double* to, const void* context);

  // The segments that reach into v in [low, high].
  std::vector<Segment> segmentsBetween(double low, double high) const;

 private:
  std::size_t row(double v) const;
  bool isBorder(const Segment& segment) const;

  Eigen::AlignedBox2d domain_;
  std::vector<Segment> segments_;
  std::vector<std::vector<std::size_t>> rows_;  // the segments that reach into each of the equal strips in v
};

// The cover of every cell of the surface's knot grid, a row a span in u, v fastest. Cost O(cells + cells next to
// segments times segments in their strip).
std::vector<Cover> coverOfCells(const Surface& surface, const TrimRegion& region);

}  // namespace strak
