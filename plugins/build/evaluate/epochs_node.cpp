#include "build/evaluate/epochs_node.hpp"

#include <optional>

#include "build/evaluate/epoch_json.hpp"
#include "building/judgement/figures.hpp"

namespace plumbline::judgement {

namespace {

DesignElements elements_of(const DesignT& design) {
  DesignElements elements;
  for (const auto& element : design.elements)
    elements.guids.insert(element->guid), elements.names.insert(element->name);
  return elements;
}

/// What was open and nobody measured again is as open as before: with it nothing is ready to install.
void leave_open(const AsBuiltChangesT& changes, DeviationT& judged) {
  constexpr std::size_t kNamed = 8;
  std::vector<std::string> names;
  int panels = 0;
  for (const auto& change : changes.changes) {
    const bool open = change->before == ToleranceVerdict::fail || change->before == ToleranceVerdict::undecided;
    // An anchor that was not measured is counted as such already.
    if (!open || change->change != ChangeKind::unseen || change->kind == "anchor") continue;
    names.push_back(change->kind + " " + change->id), panels += change->kind == "panel";
  }
  if (names.empty()) return;
  auto request = std::make_unique<JudgementRequestT>();
  request->asked = list_of(names, kNamed);
  request->by = "campaign before", request->panels = panels;
  request->not_judged =
      "open" + (changes.before.empty() ? std::string() : " since " + changes.before) + " and not measured again";
  judged.requests.push_back(std::move(request));
  ++judged.not_judged;
  if (judged.verdict == ToleranceVerdict::pass) judged.verdict = ToleranceVerdict::undecided;
}

}  // namespace

void EvaluateEpochs::run(Context& context) {
  DeviationT judged = deviation.unpack();
  std::optional<EpochRecord> earlier;
  if (!before->path.empty()) earlier = read_epoch(before->path);
  std::optional<DesignElements> elements;
  if (design) elements = elements_of(design.unpack());
  const DesignElements* built = elements ? &*elements : nullptr;
  AsBuiltChangesT result;
  result.together = Eigen::Vector3d::Zero();
  if (earlier) find_again(judged, *earlier, built);
  if (earlier) result = compare_epochs(*earlier, judged, *epoch, built);
  for (const std::string& warning : result.warnings) context.warn(warning);
  const std::size_t asked = judged.requests.size();
  leave_open(result, judged);
  for (std::size_t i = asked; i < judged.requests.size(); ++i)
    context.warn("Not judged: " + judged.requests[i]->asked + ": " + judged.requests[i]->not_judged + ".");
  if (judged.requests.size() > asked) context.metric("invalid", 1, "1");
  if (earlier)
    context.info("since " + (earlier->epoch.empty() ? "the campaign before" : earlier->epoch) + ": " +
                 words_of_changes(result));
  changes.commit(result);
  judgement.commit(judged);
  FileT file;
  file.name = "as_built.json", file.media_type = "application/json";
  const std::string text = epoch_json(record_of(judged, *epoch, earlier ? &*earlier : nullptr, built, &result), result);
  file.content.assign(text.begin(), text.end());
  record.commit(file);
}

}  // namespace plumbline::judgement
