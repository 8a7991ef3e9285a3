#pragma once
//
// The part of a parameter plane that the trimming curves of a face leave.

#include <Eigen/Geometry>
#include <vector>

#include "strak/spline/spline.h"

namespace strak {

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

  // The segments that reach into v in [low, high].
  std::vector<Segment> segmentsBetween(double low, double high) const;

 private:
  std::size_t row(double v) const;

  Eigen::AlignedBox2d domain_;
  std::vector<Segment> segments_;
  std::vector<std::vector<std::size_t>> rows_;  // the segments that reach into each of the equal strips in v
};

}  // namespace strak
