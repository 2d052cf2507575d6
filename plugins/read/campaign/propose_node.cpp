#include "propose_node.hpp"

#include <algorithm>
#include <map>
#include <set>

#include "artifacts/input_files_text.hpp"
#include "artifacts/survey_artifact.hpp"
#include "held_together.hpp"
#include "propose_campaign.hpp"
#include "reader_files_node.hpp"
#include "survey/model/several_instruments.hpp"
#include "survey/start/measured_names.hpp"
#include "unused_files.hpp"

namespace plumbline::campaign {
namespace {

FileT text_file(const char* name, const char* media_type, const std::string& text) {
  FileT file;
  file.name = name, file.media_type = media_type;
  file.content.assign(text.begin(), text.end());
  return file;
}

/// What survey.adjust will warn of when it is not told of a profile.
void warn_of_instruments(const SurveyObservationsT& survey, Context& context) {
  std::string remark;
  const std::string instrument = survey.info ? survey.info->instrument : "";
  const survey::InstrumentProfile whole = survey::choose_profile("automatic", "", instrument, remark);
  if (!remark.empty()) context.warn(remark);
  const auto own = survey::choose_instruments("automatic", "", survey.instruments);
  for (const std::string& text : survey::instruments_without_profile(survey.instruments, own, whole))
    context.warn(text);
}

/// The run tells it where their tags agree to the last digit; by then hours may have gone.
void warn_of_copies(const InputFilesT& read, Context& context) {
  std::map<std::string, std::string> first;
  std::string such;
  std::size_t copies = 0;
  for (const auto& file : read.files) {
    if (!file->read || file->use != "photograph") continue;
    const auto [known, is_new] = first.emplace(file->sha256, file->path);
    if (is_new) continue;
    if (copies++ == 0) such = known->second + " and " + file->path;
  }
  if (copies == 1) context.warn(such + " are the same photograph, which counts twice; take one away");
  if (copies > 1)
    context.warn(std::to_string(copies) + " photographs are there a second time and count twice, such as " + such +
                 "; take one of each away");
}

}  // namespace

void ProposeCampaign::run(Context& context) {
  const FolderT given = folder.unpack();
  std::vector<std::string> names;
  for (const auto& entry : given.files) names.push_back(entry->path);
  refuse_misnamed_campaign(context.resolve(given.uri), names);
  std::vector<std::string> readable;
  const SurveyReadingsT known = given_by(readings);
  for (const auto& file : known.files) readable.push_back(file->path);
  for (const auto& file : known.unnamed) readable.push_back(file->path);
  const Proposal proposal = propose_campaign(context.resolve(given.uri), names, readable);
  std::string text;
  for (const std::string& line : proposal.found) text += "  " + line + "\n";
  if (!text.empty()) text = "Recognised:\n" + text;
  if (!proposal.wrong.empty()) text += "To be mended:\n";
  for (const std::string& line : proposal.wrong) text += "  " + line + "\n";
  description.commit(text_file("campaign.yaml", "text/yaml", proposal.yaml));
  summary.commit(text_file("summary.txt", "text/plain", text));
  pipeline.commit(text_file("pipeline.txt", "text/plain", proposal.pipeline));
}

void AccountForCampaign::run(Context& context) {
  if (survey) warn_of_instruments(survey.unpack(), context);
  const PlatesT hung = plates ? plates.unpack() : PlatesT();
  std::vector<std::string> known, problems;
  if (control)
    for (const auto* point : *control->points()) known.push_back(point->id()->str());
  if (survey)
    if (const survey::SurveyObservations readings = survey::from_artifact(survey.unpack());
        !survey::measured_names(readings).empty()) {
      hold_control(readings, known, context, problems);
      std::set<std::string> surveyed = survey::measured_names(readings), designed;
      surveyed.insert(known.begin(), known.end());
      if (matches)
        for (const auto* match : *matches->matches())
          if (match->guid() && match->guid()->size() > 0) designed.insert(match->anchor()->str());
      hold_anchors(hung, surveyed, designed, context, problems);
    }
  const InputFilesT read = inputs.unpack(), left = unread.unpack();
  warn_of_copies(read, context);
  std::map<std::string, long> uses;
  for (const auto& file : read.files)
    if (file->read) ++uses[file->use];
  if (!uses.contains("observations")) hold_families(hung, *families, problems);
  std::vector<std::string> forgotten;
  for (const auto& file : left.files)
    if (file->use == "control") forgotten.push_back(file->path);
  if (!forgotten.empty()) problems.push_back(words_of_forgotten_control(forgotten));
  std::string wrong;
  for (const std::string& problem : problems) wrong += (wrong.empty() ? "" : "\n") + problem;
  if (!wrong.empty()) throw BadInput(wrong);
  std::string text = "The folder is whole.\n";
  for (const auto& [use, count] : uses)
    text += "  " + use + ": " + std::to_string(count) + (count == 1 ? " file\n" : " files\n");
  summary.commit(text_file("summary.txt", "text/plain", text + words_of_inputs(&read, &left)));
  pipeline.commit(
      text_file("pipeline.txt", "text/plain", uses.contains("observations") ? "site_observations" : "site_campaign"));
}

}  // namespace plumbline::campaign
