#include "strak/fairing/plan_face.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <tuple>

#include "strak/base/error.h"
#include "strak/fairing/held_rows.h"
#include "strak/spline/knot_insertion.h"

namespace strak {
namespace {

constexpr double kSamePoint = 1e-9;      // of the size of the net: points closer than this are one
constexpr double kNoInfluence = 1e-9;    // of a point's move: what an edge that strays from its side may feel of it
constexpr double kAlwaysAllowed = 4096;  // points that a refined net may have whatever its growth
constexpr Index kPoleRows = 3;           // rows that keep tangent plane and curvature at a pole

Index countFree(const std::vector<std::uint8_t>& held) { return std::count(held.begin(), held.end(), 0); }

// The control points with index i in direction k, in space.
template <int D>
Net slice(const Spline<D>& spline, int k, Index i) {
  Index inner = 1;
  for (int l = k + 1; l < D; ++l) inner *= spline.size(l);
  const Index outer = spline.net().rows() / inner / spline.size(k);
  const Index dimension = spline.pointDimension();
  Net rows(outer * inner, dimension);
  for (Index o = 0; o < outer; ++o) {
    const auto from = spline.net().middleRows((o * spline.size(k) + i) * inner, inner);
    rows.middleRows(o * inner, inner) = from.leftCols(dimension);
    if (spline.isRational()) {
      rows.middleRows(o * inner, inner).array().colwise() /= from.col(dimension).array();
    }
  }
  return rows;
}

template <int D>
bool isClosed(const Spline<D>& spline, int k, double size) {
  const KnotVector& knots = spline.knots(k);
  const Index n = knots.size();
  const Index overlap =
      knots.isClamped() ? 1 : knots.degree() + 1 - std::min(knots.degree(), knots.multiplicity(knots.from()));
  if (n < 2 * overlap) return false;
  for (Index i = 0; i < overlap; ++i) {
    const Net apart = slice(spline, k, i) - slice(spline, k, n - overlap + i);
    if (apart.cwiseAbs().maxCoeff() > kSamePoint * size) return false;
  }
  return true;
}

template <int D>
bool isPole(const Spline<D>& spline, int k, Index i, double size) {
  const Net rows = slice(spline, k, i);
  return rows.rows() > 1 && (rows.rowwise() - rows.row(0)).cwiseAbs().maxCoeff() <= kSamePoint * size;
}

// "rows", "rows and columns" ... of a net in words: 12 x 9.
template <int D>
std::string sizeText(const Spline<D>& spline) {
  std::string text = fmt::format("{}", spline.size(0));
  for (int k = 1; k < D; ++k) text += fmt::format(" x {}", spline.size(k));
  return text;
}

// The borders of every direction; tells about creases, seams and poles.
template <int D>
std::array<HeldBorders, D> findBorders(const Spline<D>& spline, const FairingPlanOptions<D>& options,
                                       const std::array<bool, 2 * D>& bordered, double size,
                                       std::vector<std::string>& notes) {
  std::array<HeldBorders, D> borders;
  for (int k = 0; k < D; ++k) {
    const std::size_t at = 2 * static_cast<std::size_t>(k);
    const Index wished = std::max<Index>(1, std::max(options.rows[at], options.rows[at + 1]));
    HeldBorders& b = borders[static_cast<std::size_t>(k)];
    b.low = bordered[at] && !options.joined[at] ? options.rows[at] : 0;
    b.high = bordered[at + 1] && !options.joined[at + 1] ? options.rows[at + 1] : 0;
    b.crease = wished;
    const char* name = directionName(k);

    Index creases = 0;
    for (const auto& knot : spline.knots(k).innerKnots()) {
      if (isCrease(spline.knots(k), knot.multiplicity, options.energyOrder)) ++creases;
    }
    if (creases > 0) {
      notes.push_back(fmt::format(
          "{} inner knot line{} of direction {} with too high a multiplicity for the energy {} kept "
          "as a crease: {} row{} on each side are held.",
          creases, creases == 1 ? "" : "s", name, creases == 1 ? "is" : "are", wished, wished == 1 ? "" : "s"));
    }
    const bool joined = options.joined[at] && options.joined[at + 1];
    if (bordered[at] && bordered[at + 1] && !joined && isClosed(spline, k, size)) {
      b.low = b.high = wished;
      notes.push_back(fmt::format("Closed in direction {}: {} row{} on each side of the seam are held.", name, wished,
                                  wished == 1 ? "" : "s"));
    }
    if (D == 1) continue;
    for (std::size_t side : {at, at + 1}) {
      if (!isPole(spline, k, side == at ? 0 : spline.size(k) - 1, size)) continue;
      Index& rows = side == at ? b.low : b.high;
      rows = std::max(rows, kPoleRows);
      notes.push_back(fmt::format("The {} side of direction {} is shrunk to one point: {} rows there are held.",
                                  side == at ? "low" : "high", name, rows));
    }
  }
  return borders;
}

template <int D>
HeldPoints holdBorders(const Spline<D>& spline, const std::array<HeldBorders, D>& borders, int energyOrder) {
  HeldPoints held(static_cast<std::size_t>(spline.net().rows()), 0);
  std::array<std::vector<std::uint8_t>, D> rows;
  for (int k = 0; k < D; ++k) {
    const auto at = static_cast<std::size_t>(k);
    rows[at] = heldRows(spline.knots(k), borders[at], energyOrder);
  }
  for (std::size_t r = 0; r < held.size(); ++r) {
    auto rest = static_cast<Index>(r);
    for (int k = D - 1; k >= 0; --k) {
      if (rows[static_cast<std::size_t>(k)][static_cast<std::size_t>(rest % spline.size(k))]) held[r] = 1;
      rest /= spline.size(k);
    }
  }
  return held;
}

// More rows where the edges stray from their side, until a free row moves them by next to nothing: the row `rows`
// from the side weighs about (p over rows) (stray / span)^rows there.
Index rowsAgainstStray(const KnotVector& knots, bool low, Index rows, double stray) {
  const std::vector<Index> spans = knots.spans();
  const Index span = low ? spans.front() : spans.back();
  const double reach = stray / (knots[span + 1] - knots[span]);
  const int p = knots.degree();
  const auto weight = [&](Index r) {
    double value = 1;
    for (Index i = 0; i < r; ++i) value *= reach * static_cast<double>(p - i) / static_cast<double>(i + 1);
    return value;
  };
  while (rows > 0 && rows <= p && weight(rows) > kNoInfluence) ++rows;
  return rows;
}

// Whether a direction has straight parameter lines and so no room: every knot inserted there would be a crease.
template <int D>
bool isStraight(const Spline<D>& spline, int k, const FairingPlanOptions<D>& options) {
  return spline.degree(k) < options.energyOrder;
}

// The fewest rows with a free point over all directions that may have more.
template <int D>
Index freeRows(const Spline<D>& spline, const HeldPoints& held, const FairingPlanOptions<D>& options) {
  std::array<std::vector<std::uint8_t>, D> none;
  for (int k = 0; k < D; ++k) none[static_cast<std::size_t>(k)].assign(static_cast<std::size_t>(spline.size(k)), 1);
  for (std::size_t r = 0; r < held.size(); ++r) {
    if (held[r]) continue;
    auto rest = static_cast<Index>(r);
    for (int k = D - 1; k >= 0; --k) {
      none[static_cast<std::size_t>(k)][static_cast<std::size_t>(rest % spline.size(k))] = 0;
      rest /= spline.size(k);
    }
  }
  Index fewest = std::numeric_limits<Index>::max();
  for (int k = 0; k < D; ++k) {
    const Index free = countFree(none[static_cast<std::size_t>(k)]);
    if (!isStraight(spline, k, options) || free == 0) fewest = std::min(fewest, free);
  }
  return fewest;
}

// Inserts the knots if the net may grow that far.
template <int D>
bool refineBy(Spline<D>& spline, const std::array<std::vector<double>, D>& added, const Spline<D>& original,
              const FairingPlanOptions<D>& options) {
  double points = 1;
  for (int k = 0; k < D; ++k) {
    points *= static_cast<double>(spline.size(k)) + static_cast<double>(added[static_cast<std::size_t>(k)].size());
  }
  if (points > std::max(options.maxGrowth * static_cast<double>(original.net().rows()), kAlwaysAllowed)) return false;
  for (int k = 0; k < D; ++k) {
    const auto& knots = added[static_cast<std::size_t>(k)];
    if (!knots.empty()) spline = insertKnots(spline, k, knots);
  }
  return true;
}

template <int D>
FairingPlan<D> planOn(const Spline<D>& spline, const FairingPlanOptions<D>& options, const FaceBorder* border) {
  for (Index rows : options.rows) {
    if (rows < 0) throw InvalidInput(fmt::format("cannot hold {} rows: give 0 or more", rows));
  }
  if (options.energyOrder < 0) throw InvalidInput("the order of an energy cannot be negative");

  FairingPlan<D> plan;
  plan.spline = spline;
  plan.held.assign(static_cast<std::size_t>(spline.net().rows()), 1);
  if (spline.isRational() && !options.rational) {
    plan.leftAlone = "its energy in parameters is not defined for rational splines: use --energy exact";
    return plan;
  }
  for (int k = 0; k < D; ++k) {
    if (!isStraight(spline, k, options)) continue;
    // Of a ruled surface free borders and what lies between them can get fairer along the other direction.
    const auto at = 2 * static_cast<std::size_t>(k);
    const bool mayMove = options.rational && spline.degree(k) == 1 && D == 2 && spline.degree(1 - k) > 1 &&
                         std::min(options.rows[at], options.rows[at + 1]) < 2 &&
                         std::none_of(options.joined.begin(), options.joined.end(), [](bool joined) { return joined; });
    if (!mayMove) {
      plan.leftAlone =
          fmt::format("its degree {} in direction {} is below the energy's order {}: raise the degree first{}",
                      spline.degree(k), directionName(k), options.energyOrder,
                      options.rational && spline.degree(k) == 1 ? ", or hold fewer than 2 rows of points there" : "");
      return plan;
    }
  }
  const Net points = spline.euclideanNet();
  const double size = (points.colwise().maxCoeff() - points.colwise().minCoeff()).stableNorm();
  if (size == 0) {
    plan.leftAlone = "all its control points are one point";
    return plan;
  }

  std::array<bool, 2 * D> bordered;
  bordered.fill(true);
  SideEdges edges;
  if constexpr (D == 2) {
    if (border) {
      edges = edgesAlongSides(spline, *border);
      bordered = edges.bordered;
    }
  }
  const std::array<HeldBorders, D> wished = findBorders(spline, options, bordered, size, plan.notes);
  const auto bordersOf = [&](const Spline<D>& s) {
    std::array<HeldBorders, D> borders = wished;
    if constexpr (D == 2) {
      for (std::size_t k = 0; k < 2; ++k) {
        const KnotVector& knots = s.knots(static_cast<int>(k));
        borders[k].low = rowsAgainstStray(knots, true, borders[k].low, edges.stray[2 * k]);
        borders[k].high = rowsAgainstStray(knots, false, borders[k].high, edges.stray[2 * k + 1]);
      }
    }
    return borders;
  };
  const auto hold = [&](const Spline<D>& s) {
    HeldPoints held = holdBorders<D>(s, bordersOf(s), options.energyOrder);
    if constexpr (D == 2) {
      if (border) held = holdBoth(held, holdTrimmed(s, *border, edges.along));
    }
    return held;
  };
  // Knots for the strips and creases first; where trimming curves leave too little, all spans of the face are halved.
  const auto knotsToInsert = [&](const Spline<D>& s, const HeldPoints& held) {
    std::array<std::vector<double>, D> added;
    const std::array<HeldBorders, D> borders = bordersOf(s);
    bool any = false;
    for (int k = 0; k < D; ++k) {
      if (isStraight(s, k, options)) continue;
      const auto at = static_cast<std::size_t>(k);
      added[at] = knotsForRoom(s.knots(k), borders[at], options.energyOrder, options.minFree);
      any = any || !added[at].empty();
    }
    if (any || freeRows(s, held, options) >= options.minFree) return added;
    for (int k = 0; k < D; ++k) {
      if (isStraight(s, k, options)) continue;
      double from = s.knots(k).from(), to = s.knots(k).to();
      if (border && !border->trims.empty()) std::tie(from, to) = borderExtent(*border, k);
      added[static_cast<std::size_t>(k)] = midSpans(s.knots(k), from, to);
    }
    return added;
  };

  plan.held = hold(plan.spline);
  bool mayGrow = options.refine;
  while (mayGrow) {
    const auto added = knotsToInsert(plan.spline, plan.held);
    if (std::all_of(added.begin(), added.end(), [](const auto& knots) { return knots.empty(); })) break;
    mayGrow = refineBy<D>(plan.spline, added, spline, options);
    if (mayGrow) plan.held = hold(plan.spline);
  }

  plan.freePoints = countFree(plan.held);
  for (int k = 0; k < D; ++k) plan.knotsInserted += plan.spline.size(k) - spline.size(k);
  if (plan.knotsInserted > 0) {
    plan.notes.push_back(fmt::format(
        "{} knot{} inserted to make room: the net grew from {} to {} points, the shape is "
        "the same.",
        plan.knotsInserted, plan.knotsInserted == 1 ? " was" : "s were", sizeText(spline), sizeText(plan.spline)));
  }
  int straight = -1;
  for (int k = 0; k < D; ++k) straight = isStraight(spline, k, options) ? k : straight;
  if (plan.freePoints == 0 && straight >= 0) {
    plan.leftAlone = fmt::format("its degree {} in direction {} leaves no room between what is held: hold less there",
                                 spline.degree(straight), directionName(straight));
  } else if (plan.freePoints == 0) {
    plan.leftAlone = options.refine ? fmt::format(
                                          "no control point is free and the net may not grow beyond {} times "
                                          "its points: hold fewer rows",
                                          options.maxGrowth)
                                    : "no control point is free and no knots may be inserted: hold fewer rows";
  } else if (options.refine && !mayGrow) {
    plan.notes.push_back(fmt::format("Only {} points are free: the net may not grow further.", plan.freePoints));
  }
  return plan;
}

}  // namespace

template <int D>
FairingPlan<D> planFairing(const Spline<D>& spline, const FairingPlanOptions<D>& options) {
  return planOn<D>(spline, options, nullptr);
}

FacePlan planFace(const Surface& surface, const FaceBorder& border, const PlanOptions& options) {
  FacePlan result = planOn<2>(surface, options, &border);
  if (!border.trims.empty() && result.leftAlone.empty()) {
    result.notes.push_back(
        "Trimmed: every control point with influence on a trimming curve, or on the cut-away part "
        "only, is held.");
  }
  return result;
}

template FairingPlan<1> planFairing(const Spline<1>&, const FairingPlanOptions<1>&);
template FairingPlan<2> planFairing(const Spline<2>&, const FairingPlanOptions<2>&);
template FairingPlan<3> planFairing(const Spline<3>&, const FairingPlanOptions<3>&);

}  // namespace strak
