#include <charconv>
#include <cmath>

#include "evaluate/metrics.hpp"
#include "text/csv_table.hpp"

namespace plumbline::evaluate {

namespace {

/// Fixed decimals without a locale; an unknown number is an empty cell.
std::string number(double value, int decimals) {
  if (!std::isfinite(value)) return "";
  char buffer[64];
  const auto end = std::to_chars(buffer, buffer + sizeof buffer, value, std::chars_format::fixed, decimals);
  return end.ec == std::errc() ? std::string(buffer, end.ptr) : std::string();
}

std::string millimetres(double metres) { return number(1e3 * metres, 4); }

std::string difference_cells(const AnchorDifferenceT* d) {
  if (!d) return ",,,,,,,";
  return millimetres(d->dx) + "," + millimetres(d->dy) + "," + millimetres(d->dz) + "," + millimetres(d->u_dz) + "," +
         millimetres(d->distance) + "," + EnumNameToleranceVerdict(d->verdict) + "," +
         number(d->conformance_probability, 4) + ",";
}

std::string header(const std::string& reference) {
  std::string text;
  for (const char* name : {"dx_mm", "dy_mm", "dz_mm", "u_dz_mm", "distance_mm", "verdict", "conformance_probability"})
    text += reference + "_" + name + ",";
  return text;
}

}  // namespace

std::string metrics_csv(const AccuracyT& accuracy) {
  std::string text =
      "anchor,floor,column,row,use,x_m,y_m,z_m," + header("survey") + header("truth") + header("design") + "note\n";
  for (const auto& a : accuracy.anchors) {
    text += formats::csv_field(a->id) + "," + std::to_string(a->floor) + "," + std::to_string(a->column) + "," +
            std::to_string(a->row) + "," + EnumNameAnchorUse(a->use) + "," + number(a->x, 6) + "," + number(a->y, 6) +
            "," + number(a->z, 6) + ",";
    text += difference_cells(a->survey.get()) + difference_cells(a->truth.get()) + difference_cells(a->design.get());
    text += formats::csv_field(a->note) + "\n";
  }
  return text;
}

}  // namespace plumbline::evaluate
