#include "join_node.hpp"

#include "artifacts/survey_artifact.hpp"
#include "survey/start/merge_surveys.hpp"

namespace plumbline::survey_files {

void JoinSurveys::run(Context& context) {
  if (readings.size() == 1) return joined.commit(readings.unpack(0));
  std::vector<survey::SurveyObservations> all;
  for (size_t i = 0; i < readings.size(); ++i) all.push_back(survey::from_artifact(readings.unpack(i)));
  survey::MergeOptions options;
  if (known)
    for (const auto& point : known.unpack().points) options.known.push_back(point->id);
  survey::MergedSurvey merged = survey::merge_surveys(all, options);
  for (const survey::Finding& finding : merged.findings) {
    if (finding.severity == survey::Finding::Severity::note) {
      context.info(finding.text);
      continue;
    }
    merged.survey.warnings.push_back(finding.text);  // of which the network's findings, the verdict and the page tell
    context.warn(finding.text);
  }
  joined.commit(survey::to_artifact(merged.survey));
}

}  // namespace plumbline::survey_files
