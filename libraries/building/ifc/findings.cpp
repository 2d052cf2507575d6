#include "building/ifc/findings.hpp"

#include <algorithm>
#include <map>
#include <memory>
#include <utility>

#include "building/ifc/doubt_words.hpp"
#include "building/ifc/shift_words.hpp"

namespace plumbline::ifc {
namespace {

bool is_open(const AnchorDeviationT& anchor) {
  return anchor.verdict == ToleranceVerdict::fail || anchor.verdict == ToleranceVerdict::undecided;
}

/// A finding of an older record says in words alone what it is about.
std::string topic_of(const char* kind, const MeasurementDoubtT& found) {
  return std::string(kind) + ": " + EnumNameMeasurementPart(found.part) + "/" +
         (found.about.empty() ? found.reason : found.about);
}

Finding of_doubt(const MeasurementDoubtT& doubt) {
  return {
      "doubt", topic_of("doubt", doubt), std::string("Measurement not to be trusted: ") + name_of(doubt.part),
      "Not to be trusted, " + in_words(doubt) + ". Nothing is decided, and no order is given, before it is mended."};
}

Finding of_misfit(const MeasurementDoubtT& misfit) {
  return {"misfit", topic_of("misfit", misfit), std::string("Measurement less certain: ") + name_of(misfit.part),
          "Less certain, " + in_words(misfit)};
}

/// What names elements may name others in the next campaign: it is known again by who asks.
std::string topic_of(const JudgementRequestT& request) {
  const bool names_elements =
      request.by == kUnmeasuredPanels || request.by == kCampaignBefore || request.by == kCampaignBeforeJoint;
  return "not judged: " + (names_elements ? request.by : request.asked);
}

Finding of_request(const JudgementRequestT& request) {
  return {"request", topic_of(request), "Not judged: " + request.asked,
          "Asked for and not judged: " + request.asked + ": " + request.not_judged +
              ". Nothing is ready to install before it is."};
}

std::vector<const AnchorDeviationT*> anchors_of(const DeviationT& deviation, const std::vector<int>& members) {
  std::vector<const AnchorDeviationT*> anchors;
  for (const int member : members)
    if (member >= 0 && static_cast<std::size_t>(member) < deviation.anchors.size())
      anchors.push_back(deviation.anchors[static_cast<std::size_t>(member)].get());
  std::stable_sort(anchors.begin(), anchors.end(), [](const auto* a, const auto* b) {
    return static_cast<int>(a->verdict) > static_cast<int>(b->verdict);
  });
  return anchors;
}

/// All that are significant, that of the building first.
std::vector<Finding> shifts_of(const DeviationT& deviation) {
  std::vector<Finding> all;
  const auto add = [&](Finding found) { all.push_back(std::move(found)); };
  if (const auto& common = deviation.common_shift; common && common->significant)
    add({"shift", "shift of the building", shift_in_short(*common), common->words, 0, "",
         anchors_of(deviation, common->members)});
  for (const auto& group : deviation.group_shifts)
    if (group->significant)
      add({"shift", group->kind == "building" ? "shift of the building" : "shift of " + group->name,
           shift_in_short(*group), group->words, group->floor, group->facade, anchors_of(deviation, group->members)});
  return all;
}

bool has_open(const Finding& found) {
  return std::any_of(found.anchors.begin(), found.anchors.end(), [](const auto* a) { return is_open(*a); });
}

}  // namespace

std::string shift_title(const DeviationT& deviation, const std::string& topic) {
  for (Finding& found : shifts_of(deviation))
    if (found.topic == topic) return std::move(found.title);
  return "";
}

std::vector<Finding> findings_of(const DeviationT& deviation) {
  std::vector<Finding> all;
  for (const auto& doubt : deviation.doubts) all.push_back(of_doubt(*doubt));
  for (const auto& misfit : deviation.misfits) all.push_back(of_misfit(*misfit));
  for (Finding& shift : shifts_of(deviation))
    if (has_open(shift)) all.push_back(std::move(shift));
  for (const auto& request : deviation.requests)
    if (!request->not_judged.empty()) all.push_back(of_request(*request));
  std::map<std::string, int> known;
  for (Finding& found : all)
    if (const int n = ++known[found.topic]; n > 1) found.topic += "#" + std::to_string(n);
  return all;
}

}  // namespace plumbline::ifc
