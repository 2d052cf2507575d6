#include "propose_node.hpp"

#include <algorithm>
#include <map>
#include <set>

#include "artifacts/input_files_text.hpp"
#include "artifacts/survey_artifact.hpp"
#include "base/text/words.hpp"
#include "propose_campaign.hpp"
#include "reader_files_node.hpp"
#include "survey/model/several_instruments.hpp"
#include "survey/start/alike_names.hpp"
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

/// Known points that nothing measured, or whose names are written otherwise there: what the run would miss of them.
/// Names that are alike may be two marks: as long as other control is measured that is for a person to look at.
void hold_control(const survey::SurveyObservations& survey, const std::vector<std::string>& known, Context& context,
                  std::vector<std::string>& problems) {
  const std::set<std::string> measured = survey::measured_names(survey);
  const auto is_measured = [&](const std::string& id) { return measured.contains(id); };
  const bool none = !known.empty() && std::none_of(known.begin(), known.end(), is_measured);
  if (none)
    problems.push_back("none of the control points (" + text::join(known, 8) + ") is in the readings, which have " +
                       text::join({measured.begin(), measured.end()}, 8) +
                       ": is the control that of this site? Names have to be the same, or nothing holds the survey");
  for (const survey::Finding& finding : survey::examine_known_names(survey, known)) {
    if (finding.severity != survey::Finding::Severity::warning) continue;
    if (none)
      problems.push_back(finding.text);
    else
      context.warn(finding.text);
  }
}

/// A table whose names are in no other file is whole by itself, and the run goes on without them.
void hold_anchors(const PlatesT& plates, const std::set<std::string>& surveyed, const std::set<std::string>& designed,
                  Context& context, std::vector<std::string>& problems) {
  std::vector<std::string> nowhere, unsurveyed;
  for (const auto& plate : plates.plates)
    if (plate->role != "tie" && !surveyed.contains(plate->anchor))
      (designed.contains(plate->anchor) ? unsurveyed : nowhere).push_back(plate->anchor);
  if (!nowhere.empty())
    problems.push_back("neither the readings, nor the control, nor the design have these anchors of the plate table: " +
                       text::join(nowhere, 8) +
                       "; they hold nothing, and nothing can be said of them. Measure them, or write their names the "
                       "same way; marks that only tie photographs have the role 'tie'");
  if (!unsurveyed.empty())
    context.warn("neither the readings nor the control have these anchors of the plate table: " +
                 text::join(unsurveyed, 8) + "; photographs alone measure them, and nothing checks that");
}

/// Detectors look for one family unless they are told.
void hold_families(const PlatesT& plates, const std::vector<std::string>& looked_for,
                   std::vector<std::string>& problems) {
  std::set<std::string> others;
  for (const auto& plate : plates.plates)
    if (!plate->tag_family.empty() &&
        std::find(looked_for.begin(), looked_for.end(), plate->tag_family) == looked_for.end())
      others.insert(plate->tag_family);
  if (others.empty()) return;
  const std::string list = text::join({others.begin(), others.end()}, 8);
  problems.push_back("the plate table has tags of " + list + ", and a run looks for " + text::join(looked_for, 8) +
                     " alone: correct the table, or tell the run (tags.with.families=[" + list +
                     "]) and this check (account.with.families=[" + list + "])");
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
