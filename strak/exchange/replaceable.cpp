#include "strak/exchange/replaceable.h"

#include <fmt/format.h>

#include "strak/base/error.h"
#include "strak/spline/knot_insertion.h"

namespace strak {
namespace {

template <int D>
void requireSameForm(const std::string& name, const Spline<D>& original, const Spline<D>& next) {
  if (next.isRational() != original.isRational() || next.pointDimension() != original.pointDimension()) {
    throw InvalidInput(fmt::format("{}: the new spline must have points of the same kind, with {} coordinates", name,
                                   original.pointDimension()));
  }
  for (int k = 0; k < D; ++k) {
    const KnotVector& had = original.knots(k);
    const KnotVector& has = next.knots(k);
    if (had.degree() != has.degree() || had.from() != has.from() || had.to() != has.to()) {
      throw InvalidInput(
          fmt::format("{}: degree and domain of direction {} must stay ({} on [{}, {}], not {} on [{}, {}])", name,
                      directionName(k), had.degree(), had.from(), had.to(), has.degree(), has.from(), has.to()));
    }
    // Other knots keep the parameters, and with them all trimming curves; ends that are not clamped are the exception,
    // because control points beyond the domain would lose their knots.
    if (had.isClamped() && has.isClamped()) continue;
    try {
      missingKnots(had, has);
    } catch (const InvalidInput&) {
      throw InvalidInput(fmt::format(
          "{}: the new knots of direction {} must contain the file's own, because its ends are not clamped: "
          "insert knots, do not move or remove them",
          name, directionName(k)));
    }
  }
}

void requireKind(const Object& object, const std::optional<AnySpline>& original, const AnySpline& next) {
  if (!object.leftAlone.empty() || !original) {
    throw InvalidInput(fmt::format("{} cannot be changed: {}", object.name,
                                   object.leftAlone.empty() ? "it is not a spline" : object.leftAlone));
  }
  if (original->index() != next.index()) {
    throw InvalidInput(fmt::format("{}: a curve, surface or volume can only be replaced by another one", object.name));
  }
}

}  // namespace

void requireIndex(Index index, const std::vector<Object>& objects) {
  if (index < 0 || index >= static_cast<Index>(objects.size())) {
    throw InvalidInput(fmt::format("there is no object {}: the file has {}", index + 1, objects.size()));
  }
}

void requireSameDomain(const Object& object, const AnySpline& next) {
  requireKind(object, object.spline, next);
  std::visit(
      [&]<int D>(const Spline<D>& old) {
        const auto& other = std::get<Spline<D>>(next);
        bool same = old.pointDimension() == other.pointDimension();
        for (int k = 0; k < D; ++k) {
          same = same && old.knots(k).from() == other.knots(k).from() && old.knots(k).to() == other.knots(k).to();
        }
        if (!same) {
          throw InvalidInput(
              fmt::format("{}: the new spline must have the same domain and as many coordinates", object.name));
        }
      },
      *object.spline);
}

void requireReplaceable(const Object& object, const std::optional<AnySpline>& original, const AnySpline& next) {
  requireKind(object, original, next);
  std::visit([&]<int D>(const Spline<D>& old) { requireSameForm(object.name, old, std::get<Spline<D>>(next)); },
             *original);
}

}  // namespace strak
