#include "strak/exchange/json.h"

#include <fmt/format.h>

#include <nlohmann/json.hpp>

#include "strak/base/error.h"

namespace strak {
namespace {

using Json = nlohmann::ordered_json;

constexpr int kVersion = 1;

const char* kindName(int directions) { return directions == 1 ? "curve" : directions == 2 ? "surface" : "volume"; }

const Json& part(const Json& object, const char* key) {
  const auto at = object.find(key);
  if (at == object.end()) throw InvalidInput(fmt::format("\"{}\" is missing", key));
  return *at;
}

const Json& list(const Json& value, const char* what) {
  if (!value.is_array()) throw InvalidInput(fmt::format("{} must be a list", what));
  return value;
}

double number(const Json& value, const char* what) {
  if (!value.is_number()) throw InvalidInput(fmt::format("{} must be numbers", what));
  return value.get<double>();
}

std::string text(const Json& object, const char* key) {
  const auto at = object.find(key);
  if (at == object.end()) return "";
  if (!at->is_string()) throw InvalidInput(fmt::format("\"{}\" must be a text", key));
  return at->get<std::string>();
}

template <int D>
Spline<D> parseSpline(const Json& object) {
  const Json& degrees = list(part(object, "degrees"), "\"degrees\"");
  const Json& knotLists = list(part(object, "knots"), "\"knots\"");
  if (degrees.size() != D || knotLists.size() != D) {
    throw InvalidInput(fmt::format("a {} needs {} degree(s) and {} knot vector(s), there are {} and {}", kindName(D), D,
                                   D, degrees.size(), knotLists.size()));
  }
  std::array<KnotVector, D> knots;
  for (std::size_t k = 0; k < D; ++k) {
    if (!degrees[k].is_number_integer() || degrees[k].get<double>() < 0 || degrees[k].get<double>() > 1e6) {
      throw InvalidInput("\"degrees\" must be whole numbers from 0 on");
    }
    std::vector<double> values;
    for (const Json& value : list(knotLists[k], "each of \"knots\"")) values.push_back(number(value, "\"knots\""));
    knots[k] = KnotVector(degrees[k].get<int>(), std::move(values), directionName(static_cast<int>(k)));
  }
  const auto flag = object.find("rational");
  if (flag != object.end() && !flag->is_boolean()) throw InvalidInput("\"rational\" must be true or false");
  const bool rational = flag != object.end() && flag->get<bool>();

  const Json& points = list(part(object, "points"), "\"points\"");
  const std::size_t columns = points.empty() ? 0 : list(points[0], "each of \"points\"").size();
  if (columns < (rational ? 2U : 1U)) throw InvalidInput("\"points\" has no coordinates");
  Net net(static_cast<Index>(points.size()), static_cast<Index>(columns));
  for (std::size_t r = 0; r < points.size(); ++r) {
    if (list(points[r], "each of \"points\"").size() != columns) {
      throw InvalidInput(fmt::format("point {} has {} coordinates and point 1 has {}: all must have as many", r + 1,
                                     points[r].size(), columns));
    }
    for (std::size_t c = 0; c < columns; ++c) {
      net(static_cast<Index>(r), static_cast<Index>(c)) = number(points[r][c], "\"points\"");
    }
  }
  return Spline<D>(std::move(knots), std::move(net), rational);
}

AnySpline parseObject(const Json& object) {
  if (!object.is_object()) throw InvalidInput("it must be an object {...}");
  const std::string kind = text(object, "kind");
  if (kind == kindName(1)) return parseSpline<1>(object);
  if (kind == kindName(2)) return parseSpline<2>(object);
  if (kind == kindName(3)) return parseSpline<3>(object);
  throw InvalidInput(fmt::format("\"kind\" is \"{}\": it must be curve, surface or volume", kind.substr(0, 40)));
}

template <int D>
Json toJson(const Spline<D>& spline, const std::string& name) {
  Json object;
  if (!name.empty()) object["name"] = name;
  object["kind"] = kindName(D);
  for (int k = 0; k < D; ++k) {
    object["degrees"].push_back(spline.degree(k));
    object["knots"].push_back(spline.knots(k).knots());
  }
  object["rational"] = spline.isRational();
  Json& points = object["points"] = Json::array();
  for (Index r = 0; r < spline.net().rows(); ++r) {
    Json point = Json::array();
    for (Index c = 0; c < spline.net().cols(); ++c) point.push_back(spline.net()(r, c));
    points.push_back(std::move(point));
  }
  return object;
}

}  // namespace

JsonContent parseJson(std::string_view input) {
  Json root;
  try {
    root = Json::parse(input);
  } catch (const nlohmann::json::exception& error) {
    // The library's own words name line and column, behind a tag in brackets.
    const std::string words = error.what();
    const auto tag = words.find("] ");
    throw InvalidInput("this is not valid JSON: " + (tag == words.npos ? words : words.substr(tag + 2)));
  }
  if (!root.is_object() || !root.contains("strak")) {
    throw InvalidInput("this JSON holds no splines of strak: \"strak\": 1 and \"objects\" are missing at the top");
  }
  if (root["strak"] != kVersion) {
    throw InvalidInput(fmt::format("\"strak\" must be {}: this program knows no other version", kVersion));
  }
  JsonContent content;
  content.unit = text(root, "unit");
  for (const Json& object : list(part(root, "objects"), "\"objects\"")) {
    try {
      AnySpline spline = parseObject(object);
      content.objects.push_back({text(object, "name"), std::move(spline), "", ""});
    } catch (const InvalidInput& error) {
      throw InvalidInput(fmt::format("object {}: {}", content.objects.size() + 1, error.what()));
    }
  }
  if (content.objects.empty()) throw InvalidInput("\"objects\" is empty: at least one spline was expected");
  return content;
}

std::string formatJson(const JsonContent& content) {
  Json root;
  root["strak"] = kVersion;
  if (!content.unit.empty()) root["unit"] = content.unit;
  Json& objects = root["objects"] = Json::array();
  for (const PlainObject& object : content.objects) {
    if (!object.spline) continue;
    objects.push_back(std::visit([&](const auto& spline) { return toJson(spline, object.name); }, *object.spline));
  }
  // Names from other files may hold broken UTF-8; it is replaced rather than refused.
  return root.dump(-1, ' ', false, Json::error_handler_t::replace) + "\n";
}

}  // namespace strak
