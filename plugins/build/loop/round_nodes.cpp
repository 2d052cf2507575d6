#include "build/loop/round_nodes.hpp"

#include <filesystem>

#include "base/text/whole_file.hpp"
#include "loop/exchange/vda5050.hpp"
#include "loop/job/job.hpp"
#include "loop/job/layout_files.hpp"
#include "loop/state/date.hpp"
#include "loop/state/hash.hpp"
#include "loop/state/state_file.hpp"

namespace plumbline::loop {
namespace {

std::string text_of(const FilePath& file) { return text::read_whole(file.path); }

std::string name_of_file(const FilePath& file) { return std::filesystem::path(file.path).filename().string(); }

}  // namespace

void ReadState::run(Context& context) {
  if (file->path.empty() != *first)
    throw std::runtime_error(*first
                                 ? "there is a state of a round before (" + file->path +
                                       "), and this is said to be the first round: give one of the two"
                                 : "no state is given: state=FOLDER/state.json of the round before, or first=true if "
                                   "nothing was set or hung yet");
  LoopStateT read;
  if (!*first) {
    read = read_state_json(text_of(*file), file->path);
    context.info("after round " + std::to_string(read.round) + ", revision " + std::to_string(read.revision));
  }
  state.commit(read);
}

void ReadReports::take(ActualsT read, const std::string& text, ActualsT& into) {
  // Of another tool, or of a day on which nothing was done.
  if (read.items.empty() && read.refused.empty() && !read.sources.empty())
    into.refused.push_back(read.sources.front() + ": has no report or point in it");
  const std::string digest = sha256_hex(text);
  for (auto& item : read.items) {
    if (item->at.empty()) item->at = *at;
    item->digest = digest;
    into.items.push_back(std::move(item));
  }
  into.sources.insert(into.sources.end(), read.sources.begin(), read.sources.end());
  into.refused.insert(into.refused.end(), read.refused.begin(), read.refused.end());
  into.ignored.insert(into.ignored.end(), read.ignored.begin(), read.ignored.end());
}

void ReadReports::run(Context& context) {
  if (!at->empty() && !seconds_of(*at))
    throw std::runtime_error("'at' is '" + *at + "'; expected ISO 8601 with a zone, such as 2026-05-02T08:00:00Z");
  if (states->size() != jobs->size())
    throw std::runtime_error("found " + std::to_string(states->size()) + " files of states and " +
                             std::to_string(jobs->size()) + " jobs; expected for each the job that it answers");
  const SurveyLink survey = frames ? survey_link(frames.unpack()) : SurveyLink();
  ActualsT all;
  for (const FilePath& file : *json) {
    const std::string text = text_of(file);
    take(read_actuals_json(text, name_of_file(file), survey), text, all);
  }
  const auto take_staked = [&](const std::vector<FilePath>& files, LayoutFormat format) {
    for (const FilePath& file : files) {
      const std::string text = text_of(file);
      take(read_staked(text, format, name_of_file(file), survey), text, all);
    }
  };
  take_staked(*hilti, LayoutFormat::hilti);
  take_staked(*trimble, LayoutFormat::trimble);
  take_staked(*leica, LayoutFormat::leica);
  for (std::size_t i = 0; i < states->size(); ++i) {
    const std::string text = text_of((*states)[i]);
    take(vda_actuals(text, read_job(text_of((*jobs)[i])), name_of_file((*states)[i]), survey), text, all);
  }
  for (const auto& item : all.items)
    if (item->at.empty()) {
      context.warn("the report on " + item->item +
                   " has no date, and perhaps others: where it is said when was "
                   "measured, nothing judges what was done nobody knows when; 'at' (reported_at) gives them one");
      break;
    }
  for (const std::string& line : all.ignored) context.warn(line);
  context.metric("reports", static_cast<double>(all.items.size()), "1");
  context.metric("refused", static_cast<double>(all.refused.size()), "1");
  actuals.commit(all);
}

}  // namespace plumbline::loop
