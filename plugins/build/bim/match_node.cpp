#include "match_node.hpp"

#include <algorithm>
#include <limits>
#include <set>

#include "artifacts.hpp"
#include "artifacts/fitted_datum.hpp"
#include "building/ifc/mapping_table.hpp"

namespace plumbline::ifc {
namespace {

constexpr double kUnknown = std::numeric_limits<double>::quiet_NaN();

}  // namespace

std::vector<MappingRow> mapping_rows(const FileT& file) {
  return parse_mapping({file.content.begin(), file.content.end()}, file.name);
}

void MatchElements::run(Context& context) {
  const Design read = from_artifact(design.unpack());
  MatchOptions options;
  options.by = *by;
  if (mapping) options.mapping = mapping_rows(mapping.unpack());
  for (const std::string& text : *offsets) options.offsets.push_back(parse_offset(text));
  for (const std::string& text : *reference_points) options.references.push_back(parse_reference(text));
  std::vector<std::string> anchors;
  std::set<std::string> seen;
  for (const auto& plate : plates.unpack().plates)
    if (seen.insert(plate->anchor).second) anchors.push_back(plate->anchor);
  ElementMatchesT result;
  std::vector<NotApplied> not_applied;
  PointsT designed;
  mark_designed(designed);
  for (const MatchedElement& match : match_elements(read, anchors, options, result.warnings, &not_applied)) {
    auto entry = std::make_unique<ElementMatchT>();
    entry->anchor = match.anchor, entry->found_by = match.found_by, entry->note = match.note;
    entry->position.setConstant(kUnknown), entry->target_offset.setZero();
    if (match.element) {
      entry->guid = match.element->guid;
      entry->target_offset = match.target_offset;
      entry->position = match.reference + match.target_offset;
      auto point = std::make_unique<PointT>();
      point->id = match.anchor, point->position = entry->position;
      point->sigma.setConstant(kUnknown);
      designed.points.push_back(std::move(point));
    }
    entry->reference_rule = match.element ? match.reference_rule : "";
    result.matches.push_back(std::move(entry));
  }
  for (const std::string& warning : result.warnings) context.warn(warning);
  for (const NotApplied& idle : not_applied) {
    context.warn(idle.by + " '" + idle.asked + "': " + idle.reason);
    result.not_applied.push_back(to_artifact(idle));
  }
  matches.commit(result);
  points.commit(designed);
}

}  // namespace plumbline::ifc
