#include "strak/report/fair_report.h"

#include <cmath>
#include <nlohmann/json.hpp>

namespace strak {

namespace {

using Json = nlohmann::ordered_json;

// nlohmann writes the shortest digits that read back to the same double, and null for infinities and NaN.
Json beforeAfter(const BeforeAfter& figure) { return {{"before", figure.before}, {"after", figure.after}}; }

Json fairness(const SurfaceFairness& f) {
  return {{"area", f.area},
          {"plate", f.plate},
          {"curvature_variation", f.curvatureVariation},
          {"isophote_roughness", f.isophoteRoughness},
          {"relative_error", f.relativeError}};
}

Json fairness(const CurveFairness& f) {
  return {{"length", f.length}, {"bending", f.bending}, {"curvature_variation", f.curvatureVariation}};
}

// A new one is refused, so one that is there was there before.
const char* meetingName(SelfMeeting meeting) {
  return meeting == SelfMeeting::intersects ? "as-before" : selfMeetingName(meeting);
}

Json objectJson(const FairedObject& object) {
  Json json{{"name", object.name}, {"kind", object.kind}, {"degree", object.degree}, {"points", object.points}};
  json["left_alone"] = object.leftAlone.empty() ? Json(nullptr) : Json(object.leftAlone);
  json["notes"] = object.notes;
  if (!object.faired()) return json;
  const FairingSummary& summary = object.summary;
  json["energy"] = {{"name", object.energyName}, {"before", summary.energyBefore}, {"after", summary.energyAfter}};
  json["plate"] = beforeAfter(object.plate);
  if (object.fairnessBefore && object.fairnessAfter)
    json["fairness"] = {{"before", fairness(*object.fairnessBefore)}, {"after", fairness(*object.fairnessAfter)}};
  if (object.curve) {
    json["curve"] = {{"before", fairness(object.curve->before)}, {"after", fairness(object.curve->after)}};
    json["curvature_extrema"] = {{"before", object.curve->extremaBefore}, {"after", object.curve->extremaAfter}};
  }
  json["deviation"] = {{"control_points", object.controlPointMove},
                       {"lower", object.deviationLower},
                       {"certified", object.deviationUpper}};
  if (object.meeting) json["self_intersection"] = meetingName(*object.meeting);
  json["held_max_move"] = object.heldMaxMove;
  json["free_points"] = summary.freePoints;
  json["active_points"] = summary.activePoints;
  json["steps"] = summary.steps;
  json["gap"] = summary.gap;
  json["stop_reason"] = stopReasonName(summary.stopReason);
  json["seconds"] = summary.seconds;
  if (object.smoothed) {
    json["smoothed_knots"] = {{"smoothed", object.smoothed->smoothed},
                              {"kept", object.smoothed->kept},
                              {"deviation", object.smoothed->deviation}};
  }
  if (object.simplified) {
    json["simplified"] = {{"knotsRemoved", object.simplified->knotsRemoved},
                          {"pointsBefore", object.simplified->pointsBefore},
                          {"pointsAfter", object.simplified->pointsAfter}};
  }
  return json;
}

Json auditJson(const Audit& audit) {
  return {{"valid", audit.valid},
          {"invalid_faces", audit.invalidFaces},
          {"largest_gap", audit.largestGap},
          {"largest_tolerance", audit.largestTolerance}};
}

Json joinJson(const EdgeJoin& join) {
  return {{"edge", join.name},
          {"faces", {join.faceA + 1, join.faceB + 1}},
          {"gap", beforeAfter(join.gap)},
          {"angle", beforeAfter(join.angle)},
          {"curvature", beforeAfter(join.curvature)},
          {"angle_rms", beforeAfter(join.angleMean)},
          {"curvature_rms", beforeAfter(join.curvatureMean)},
          {"kind", {{"before", jointKindName(join.kindBefore)}, {"after", jointKindName(join.kindAfter)}}}};
}

}  // namespace

FairedObject describe(const Object& object) {
  FairedObject out;
  out.name = object.name;
  out.kind = object.kind;
  out.trims = object.trims;
  out.leftAlone = object.leftAlone;
  out.before = object.spline;
  if (object.spline) {
    std::visit(
        [&](const auto& spline) {
          for (int k = 0; k < spline.kDirections; ++k) {
            out.degree.push_back(spline.degree(k));
            out.points.push_back(spline.size(k));
          }
        },
        *object.spline);
  }
  return out;
}

std::string fairReportJson(const FairReport& report) {
  Json json{{"version", report.version},
            {"command", report.command},
            {"inputs", Json::array({report.inputName})},
            {"output", report.outputName},
            {"unit", report.unit},
            {"size", report.size},
            {"tolerance", report.tolerance},
            {"tolerance_kind", report.toleranceKind},
            {"objects", Json::array()}};
  for (const FairedObject& object : report.objects) json["objects"].push_back(objectJson(object));
  json["audit"] = {{"before", auditJson(report.before)}, {"after", auditJson(report.after)}};
  json["joins"] = Json::array();
  for (const EdgeJoin& join : report.joins) json["joins"].push_back(joinJson(join));
  json["seconds"] = report.seconds;
  // Names from files need not be UTF-8.
  return json.dump(2, ' ', false, Json::error_handler_t::replace) + "\n";
}

}  // namespace strak
