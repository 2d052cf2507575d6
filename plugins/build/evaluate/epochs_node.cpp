#include "build/evaluate/epochs_node.hpp"

#include <optional>

#include "build/evaluate/epoch_json.hpp"
#include "building/judgement/kept_open.hpp"

namespace plumbline::judgement {

namespace {

DesignElements elements_of(const DesignT& design) {
  DesignElements elements;
  for (const auto& element : design.elements)
    elements.guids.insert(element->guid), elements.names.insert(element->name);
  return elements;
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
  for (const std::string& warning : leave_open(result, judged)) context.warn(warning);
  if (earlier) compare_findings(*earlier, judged, result);
  if (judged.not_judged > deviation->not_judged()) context.metric("invalid", 1, "1");
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
