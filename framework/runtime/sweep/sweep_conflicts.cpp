#include "runtime/sweep/sweep_conflicts.hpp"

#include <algorithm>
#include <set>

namespace plumbline::runtime {

namespace {

/// What two groups both set would be that of one of them, under the name of the other.
void require_set_once(std::map<std::string, std::string>& set_by, const std::string& group, const std::string& key) {
  const auto [found, fresh] = set_by.emplace(key, group);
  if (!fresh && found->second != group)
    throw std::runtime_error("the groups '" + found->second + "' and '" + group + "' both set " + key +
                             ": only one of them could hold; make them one group, or exclude this combination");
}

/// Where a setting was written, or the setting itself where that was the command line.
Position place_of(const SweepFile& file, const std::string& text) {
  const auto place = file.places.find(text);
  return place == file.places.end() ? Position{"'" + text + "'", 0, 0} : place->second;
}

void throw_by_line(std::vector<Problem> problems) {
  std::stable_sort(problems.begin(), problems.end(),
                   [](const Problem& a, const Problem& b) { return a.at.line < b.at.line; });
  if (!problems.empty()) throw InvalidPipeline(problems);
}

}  // namespace

SettingConflicts::Held SettingConflicts::around(const Combination& way) {
  Held held;
  const auto set = [&](const std::string& who, const std::string& text) {
    note(held, text);
    const size_t equals = text.find('=');
    held.around.emplace(text.substr(0, equals), std::pair(who, text.substr(equals + 1)));
  };
  for (const std::string& text : overrides_)
    held.around[text.substr(0, text.find('='))] = {"the command line", text.substr(text.find('=') + 1)};
  if (!file_.seeds.empty()) {
    if (held.around.count("seed")) note(held, "seed=each of its 'seeds'", file_.seeds_at);
    held.around["seed"] = {"'seeds'", "each of them"};
  }
  for (const std::string& text : way.scenario->overrides) set("scenario '" + way.scenario->name + "'", text);
  for (const auto& [name, value] : way.values) set("the matrix", name + "=" + value);
  if (!way.scenario->pipeline.empty())
    held.around["pipeline"] = {"scenario '" + way.scenario->name + "'", way.scenario->pipeline.string()};
  return held;
}

void SettingConflicts::add(Held& held, const std::string& group, const SweepAlternative& choice) {
  if (!choice.pipeline.empty()) {
    require_set_once(held.groups, group, "pipeline");
    note(held, "pipeline=" + choice.pipeline.string(), choice.at);
  }
  for (const std::string& text : choice.overrides) {
    require_set_once(held.groups, group, text.substr(0, text.find('=')));
    note(held, text);
  }
}

void SettingConflicts::add_kind(Held& held, const std::string& group, const SweepAlternative& choice,
                                const std::string& node) {
  require_set_once(held.groups, group, node + ".use");
  note(held, node + ".use=" + choice.kind, choice.at);
}

/// `text` ("KEY=VALUE") where the key is set to something else already.
void SettingConflicts::note(const Held& held, const std::string& text, Position at) {
  const size_t equals = text.find('=');
  const std::string key = text.substr(0, equals), value = text.substr(equals + 1);
  const auto found = held.around.find(key);
  if (found == held.around.end() || found->second.second == value) return;
  if (const auto place = file_.places.find(text); at.file.empty() && place != file_.places.end()) at = place->second;
  const std::string& who = found->second.first;
  conflicts_.emplace(
      text + "\n" + who,
      Problem{at, "'" + key + "' is set to '" + value + "' here and to '" + found->second.second + "' by " + who +
                      ": only one of them could hold; leave one of them away, or exclude this combination"});
}

/// Who sets each "KEY=VALUE" of a combination.
std::map<std::string, std::string> SettingConflicts::setters_of(const Combination& way) const {
  std::map<std::string, std::string> setters;
  for (const std::string& text : overrides_) setters.emplace(text, "the command line");
  for (const std::string& text : way.scenario->overrides)
    setters.emplace(text, "scenario '" + way.scenario->name + "'");
  for (const auto& [name, value] : way.values) setters.emplace(name + "=" + value, "the matrix");
  for (const auto& [group, choice] : way.choices)
    for (const std::string& text : choice->overrides) setters.emplace(text, "'" + choice->name + "' of " + group);
  return setters;
}

void SettingConflicts::add_unreached(const Combination& way, const std::filesystem::path& pipeline,
                                     const Overrides& all, SettingReach& reach) {
  const std::map<std::string, std::string> setters = setters_of(way);
  for (const auto& [text, who] : setters) {
    std::string by;
    for (const std::string& other : reach.replacing(pipeline, all, text)) {
      const auto setter = setters.find(other);
      by += (by.empty() ? "" : ", ") + ("'" + other + "' of ") +
            (setter == setters.end() ? "a list of kinds" : setter->second);
    }
    if (by.empty()) continue;
    conflicts_.emplace(
        text + "\n" + by,
        Problem{place_of(file_, text), "'" + text + "' of " + who + " reaches nothing: all that takes it is set by " +
                                           by + "; leave one of them away, or exclude this combination"});
  }
}

void SettingConflicts::refuse() const {
  std::vector<Problem> problems;
  for (const auto& [text, problem] : conflicts_) problems.push_back(problem);
  throw_by_line(std::move(problems));
}

/// Kinds of a list are not asked: one that is not built is shown with its cells.
bool SettingTries::was_written(const std::string& text) const {
  return file_.places.count(text) > 0 || std::find(overrides_.begin(), overrides_.end(), text) != overrides_.end();
}

void SettingTries::count(const Overrides& overrides, const InvalidPipeline* error) {
  for (const std::string& text : std::set<std::string>(overrides.begin(), overrides.end())) {
    if (!was_written(text)) continue;
    Tried& tried = tried_[text];
    ++tried.times;
    if (!error) continue;
    const auto& problems = error->problems();
    const auto own =
        std::find_if(problems.begin(), problems.end(), [&](const Problem& p) { return p.at.file == "'" + text + "'"; });
    if (own != problems.end()) ++tried.wrong, tried.message = own->message;
  }
}

void SettingTries::refuse_what_never_holds() const {
  std::vector<Problem> problems;
  for (const auto& [text, tried] : tried_)
    if (tried.wrong > 0 && tried.wrong == tried.times)
      problems.push_back({place_of(file_, text), "'" + text + "' holds in no combination: " + tried.message});
  throw_by_line(std::move(problems));
}

}  // namespace plumbline::runtime
