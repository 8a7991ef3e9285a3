#include "strak/fitting/delaunay.h"

#include <algorithm>
#include <cmath>
#include <numeric>

#include "strak/base/error.h"

namespace strak {

namespace {

__extension__ using Wide = __int128;

constexpr int kBits = 24;                             // of the rounded coordinates
constexpr std::int64_t kFar = std::int64_t{1} << 28;  // the corners of the first square: no coordinate is beyond
constexpr double kRounding = 4e-15;                   // bounds the relative error of the in-circle test in doubles
constexpr Index kMost = 500'000'000;                  // points, so that triangles have numbers of 32 bits
constexpr std::int32_t kSquare = 4;                   // corners of the first square, before all points

struct Place {
  std::int64_t x, y;
};

// > 0: a, b, c turn to the left.
std::int64_t turn(const Place& a, const Place& b, const Place& c) {
  return (b.x - a.x) * (c.y - a.y) - (b.y - a.y) * (c.x - a.x);
}

template <typename Number>
struct Minors {
  Number ax, ay, bx, by, cx, cy;
  Minors(const Place& a, const Place& b, const Place& c, const Place& d)
      : ax(static_cast<Number>(a.x - d.x)),
        ay(static_cast<Number>(a.y - d.y)),
        bx(static_cast<Number>(b.x - d.x)),
        by(static_cast<Number>(b.y - d.y)),
        cx(static_cast<Number>(c.x - d.x)),
        cy(static_cast<Number>(c.y - d.y)) {}
  Number first() const { return (ax * ax + ay * ay) * (bx * cy - cx * by); }
  Number second() const { return (bx * bx + by * by) * (cx * ay - ax * cy); }
  Number third() const { return (cx * cx + cy * cy) * (ax * by - bx * ay); }
};

// Whether d lies in the circle through a, b, c, which turn to the left. Differences have at most 30 bits, so that the
// wide integers hold the determinant.
bool inCircle(const Place& a, const Place& b, const Place& c, const Place& d) {
  const Minors<double> m(a, b, c, d);
  const double determinant = m.first() + m.second() + m.third();
  const double size = (m.ax * m.ax + m.ay * m.ay) * (std::abs(m.bx * m.cy) + std::abs(m.cx * m.by)) +
                      (m.bx * m.bx + m.by * m.by) * (std::abs(m.cx * m.ay) + std::abs(m.ax * m.cy)) +
                      (m.cx * m.cx + m.cy * m.cy) * (std::abs(m.ax * m.by) + std::abs(m.bx * m.ay));
  if (std::abs(determinant) > kRounding * size) return determinant > 0;
  const Minors<Wide> exact(a, b, c, d);
  return exact.first() + exact.second() + exact.third() > 0;
}

// The place of (x, y), of 16 bits each, along Hilbert's curve.
std::uint32_t alongHilbert(std::uint32_t x, std::uint32_t y) {
  std::uint32_t place = 0;
  for (std::uint32_t s = 1U << 15; s > 0; s >>= 1) {
    const bool right = (x & s) != 0, up = (y & s) != 0;
    place += s * s * ((right ? 3U : 0U) ^ (up ? 1U : 0U));
    if (!up) {
      if (right) {
        x = ~x;
        y = ~y;
      }
      std::swap(x, y);
    }
  }
  return place;
}

struct Box {
  Eigen::RowVector2d low{0, 0};
  double size = 0;  // of the longer side
};

Box boxOf(const Eigen::Ref<const Net>& points) {
  if (points.cols() != 2) throw InvalidInput("a triangulation of the plane needs points with two coordinates");
  if (points.rows() > kMost) throw InvalidInput("too many points to be triangulated: thin them out");
  if (points.rows() == 0) return {};
  Box box{points.colwise().minCoeff(), 0};
  box.size = (points.colwise().maxCoeff() - box.low).maxCoeff();
  if (!points.allFinite() || !std::isfinite(box.size)) {
    throw InvalidInput("a point to be triangulated is not a finite number, or too large: remove it");
  }
  return box;
}

class Builder {
 public:
  explicit Builder(std::vector<Place> points) : places_(std::move(points)) {
    places_.insert(places_.begin(), {{-kFar, -kFar}, {kFar, -kFar}, {kFar, kFar}, {-kFar, kFar}});
    triangles_ = {{0, 1, 2}, {0, 2, 3}};
    neighbours_ = {{-1, 1, -1}, {-1, -1, 0}};
    triangles_.reserve(2 * places_.size());
    neighbours_.reserve(2 * places_.size());
  }

  void insert(std::int32_t point) {
    const std::int32_t t = locate(places_[static_cast<std::size_t>(point)]);
    const auto [a, b, c] = corners(t);
    for (std::int32_t corner : {a, b, c}) {
      if (place(corner).x == place(point).x && place(corner).y == place(point).y) return;
    }
    // On an edge a triangle without area comes to be; it is flipped away at once.
    const auto [na, nb, nc] = across(t);
    const auto t1 = static_cast<std::int32_t>(triangles_.size()), t2 = t1 + 1;
    set(t, {point, b, c}, {na, t1, t2});
    triangles_.push_back({point, c, a});
    neighbours_.push_back({nb, t2, t});
    triangles_.push_back({point, a, b});
    neighbours_.push_back({nc, t, t1});
    relink(nb, t, t1);
    relink(nc, t, t2);
    pending_ = {t, t1, t2};
    while (!pending_.empty()) {
      const std::int32_t next = pending_.back();
      pending_.pop_back();
      flip(next);
    }
    last_ = t;
  }

  Triangulation result() const {
    std::vector<std::int32_t> number(triangles_.size(), -1);
    Triangulation result;
    for (std::size_t t = 0; t < triangles_.size(); ++t) {
      const auto& v = triangles_[t];
      if (std::min({v[0], v[1], v[2]}) < kSquare) continue;
      number[t] = static_cast<std::int32_t>(result.triangles.size());
      result.triangles.push_back({v[0] - kSquare, v[1] - kSquare, v[2] - kSquare});
    }
    result.neighbours.reserve(result.triangles.size());
    for (std::size_t t = 0; t < triangles_.size(); ++t) {
      if (number[t] < 0) continue;
      std::array<std::int32_t, 3> own = neighbours_[t];
      for (auto& n : own) n = n < 0 ? -1 : number[static_cast<std::size_t>(n)];
      result.neighbours.push_back(own);
    }
    return result;
  }

 private:
  using Three = std::array<std::int32_t, 3>;

  const Place& place(std::int32_t point) const { return places_[static_cast<std::size_t>(point)]; }
  const Three& corners(std::int32_t t) const { return triangles_[static_cast<std::size_t>(t)]; }
  const Three& across(std::int32_t t) const { return neighbours_[static_cast<std::size_t>(t)]; }
  void set(std::int32_t t, const Three& own, const Three& next) {
    triangles_[static_cast<std::size_t>(t)] = own;
    neighbours_[static_cast<std::size_t>(t)] = next;
  }
  void relink(std::int32_t t, std::int32_t from, std::int32_t to) {
    if (t < 0) return;
    Three& next = neighbours_[static_cast<std::size_t>(t)];
    *std::find(next.begin(), next.end(), from) = to;
  }

  // Walks towards the point; in a Delaunay triangulation that ends.
  std::int32_t locate(const Place& point) const {
    std::int32_t t = last_;
    for (;;) {
      const Three& v = corners(t);
      int leave = -1;
      for (int k = 0; k < 3 && leave < 0; ++k) {
        const auto next = static_cast<std::size_t>((k + 1) % 3), after = static_cast<std::size_t>((k + 2) % 3);
        if (turn(place(v[next]), place(v[after]), point) < 0) leave = k;
      }
      if (leave < 0) return t;
      t = across(t)[static_cast<std::size_t>(leave)];
    }
  }

  // Makes the edge opposite to the new point, the first corner of t, a Delaunay edge.
  void flip(std::int32_t t) {
    const std::int32_t o = across(t)[0];
    if (o < 0) return;
    const Three& there = across(o);
    const auto k = static_cast<std::size_t>(std::find(there.begin(), there.end(), t) - there.begin());
    const auto [p, b, c] = corners(t);
    const std::int32_t d = corners(o)[k];
    if (!inCircle(place(p), place(b), place(c), place(d))) return;
    const std::int32_t beyondB = there[(k + 1) % 3], beyondC = there[(k + 2) % 3];
    const auto [ignored, besideC, besideB] = across(t);
    set(t, {p, b, d}, {beyondB, o, besideB});
    set(o, {p, d, c}, {beyondC, besideC, t});
    relink(beyondB, o, t);
    relink(besideC, t, o);
    pending_.push_back(t);
    pending_.push_back(o);
  }

  std::vector<Place> places_;
  std::vector<Three> triangles_, neighbours_;
  std::vector<std::int32_t> pending_;
  std::int32_t last_ = 0;
};

}  // namespace

std::vector<std::int32_t> orderInPlane(const Eigen::Ref<const Net>& points) {
  const Box box = boxOf(points);
  const double scale = box.size > 0 ? 65535 / box.size : 0;
  std::vector<std::int32_t> order(static_cast<std::size_t>(points.rows()));
  std::iota(order.begin(), order.end(), 0);
  std::vector<std::uint32_t> key(order.size());
  for (std::size_t i = 0; i < key.size(); ++i) {
    const Eigen::RowVector2d at = (points.row(static_cast<Index>(i)) - box.low) * scale;
    key[i] = alongHilbert(static_cast<std::uint32_t>(at[0]), static_cast<std::uint32_t>(at[1]));
  }
  std::sort(order.begin(), order.end(), [&](std::int32_t a, std::int32_t b) {
    const auto ka = key[static_cast<std::size_t>(a)], kb = key[static_cast<std::size_t>(b)];
    return ka != kb ? ka < kb : a < b;
  });
  return order;
}

Triangulation delaunay(const Eigen::Ref<const Net>& points) {
  const Box box = boxOf(points);
  const double scale = box.size > 0 ? std::ldexp(1.0, kBits) / box.size : 0;
  std::vector<Place> places(static_cast<std::size_t>(points.rows()));
  for (std::size_t i = 0; i < places.size(); ++i) {
    const auto row = static_cast<Index>(i);
    places[i] = {std::llround((points(row, 0) - box.low[0]) * scale),
                 std::llround((points(row, 1) - box.low[1]) * scale)};
  }
  Builder builder(std::move(places));
  for (std::int32_t point : orderInPlane(points)) builder.insert(point + kSquare);
  return builder.result();
}

}  // namespace strak
