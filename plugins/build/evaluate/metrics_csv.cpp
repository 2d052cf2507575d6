// metrics.csv: a row for each anchor, from the artifacts of the judgement. No library: it knows artifacts.
#include <charconv>
#include <cmath>
#include <map>

#include "base/text/csv_table.hpp"
#include "base/text/text.hpp"
#include "build/evaluate/metrics.hpp"

namespace plumbline::judgement {

namespace {

/// Fixed decimals without a locale; an unknown number is an empty cell.
std::string number(double value, int decimals) {
  return std::isfinite(value) ? text::format_fixed(value, decimals) : "";
}

std::string millimetres(double metres) { return number(1e3 * metres, 4); }

std::string difference_cells(const AnchorDifferenceT* d) {
  if (!d) return ",,,,,,,";
  return millimetres(d->dx) + "," + millimetres(d->dy) + "," + millimetres(d->dz) + "," + millimetres(d->u_dz) + "," +
         millimetres(d->distance) + "," + EnumNameToleranceVerdict(d->verdict) + "," +
         number(d->conformance_probability, 4) + ",";
}

/// As-built minus design: the anchor's deviation, its axes and its verdict.
std::string deviation_header() {
  std::string text = "guid,design_dx_mm,design_dy_mm,design_dz_mm,";
  for (const char* axis : {"horizontal", "vertical", "in_plane", "out_of_plane", "space"})
    for (const char* what : {"mm", "u_mm", "tolerance_mm", "verdict"})
      text += std::string("design_") + axis + "_" + what + ",";
  return text + "design_verdict,design_decided_by,design_pass_probability,";
}

std::string deviation_cells(const AnchorDeviationT* d) {
  if (!d) return std::string(4 + 20 + 3, ',');
  std::string text = text::csv_field(d->guid) + "," + millimetres(d->deviation.x()) + "," +
                     millimetres(d->deviation.y()) + "," + millimetres(d->deviation.z()) + ",";
  for (const auto& axis : d->axes)
    text += millimetres(axis->value) + "," + millimetres(axis->u) + "," + millimetres(axis->tolerance) + "," +
            verdict_word(*axis) + ",";
  return text + EnumNameToleranceVerdict(d->verdict) + "," + text::csv_field(d->decided_by) + "," +
         number(d->pass_probability, 4) + ",";
}

std::string header(const std::string& reference) {
  std::string text;
  for (const char* name : {"dx_mm", "dy_mm", "dz_mm", "u_dz_mm", "distance_mm", "verdict", "conformance_probability"})
    text += reference + "_" + name + ",";
  return text;
}

}  // namespace

std::string metrics_csv(const AccuracyT& accuracy, const DeviationT* deviation) {
  std::map<std::string, const AnchorDeviationT*> built;
  if (deviation)
    for (const auto& anchor : deviation->anchors) built[anchor->id] = anchor.get();
  std::string text =
      "anchor,floor,column,row,use,x_m,y_m,z_m," + header("survey") + header("truth") + deviation_header() + "note\n";
  for (const auto& a : accuracy.anchors) {
    text += text::csv_field(a->id) + "," + std::to_string(a->floor) + "," + std::to_string(a->column) + "," +
            std::to_string(a->row) + "," + EnumNameAnchorUse(a->use) + "," + number(a->x, 6) + "," + number(a->y, 6) +
            "," + number(a->z, 6) + ",";
    const auto found = built.find(a->id);
    text += difference_cells(a->survey.get()) + difference_cells(a->truth.get()) +
            deviation_cells(found == built.end() ? nullptr : found->second);
    text += text::csv_field(a->note) + "\n";
    if (found != built.end()) built.erase(found);
  }
  if (!deviation) return text;
  for (const auto& anchor : deviation->anchors) {  // those that only the design knows, in its order
    if (!built.contains(anchor->id)) continue;
    text += text::csv_field(anchor->id) + "," + std::to_string(anchor->floor) + "," + std::to_string(anchor->column) +
            ",,,,,," + difference_cells(nullptr) + difference_cells(nullptr) + deviation_cells(anchor.get()) +
            text::csv_field(anchor->note) + "\n";
  }
  return text;
}

}  // namespace plumbline::judgement
