#include "survey/epochs/epoch_names.hpp"

#include <algorithm>
#include <map>
#include <set>

#include "base/text/words.hpp"
#include "survey/start/alike_names.hpp"

namespace plumbline::survey {

namespace {

constexpr size_t kMostNamed = 8;
// Pillars are read to a millimetre again and again: a few equal readings are chance, ten are none.
constexpr size_t kFewestReadings = 10;

/// Of every name the numbers of the epochs that have it.
std::map<std::string, std::set<size_t>> epochs_of_names(const std::vector<NamedEpoch>& epochs) {
  std::map<std::string, std::set<size_t>> found;
  for (size_t k = 0; k < epochs.size(); ++k)
    for (const std::string& id : epochs[k].ids) found[id].insert(k);
  return found;
}

bool have_common(const std::set<size_t>& a, const std::set<size_t>& b) {
  return std::any_of(a.begin(), a.end(), [&](size_t k) { return b.contains(k); });
}

void add_alike(const std::map<std::string, std::set<size_t>>& names, std::vector<std::string>& out) {
  std::map<std::string, std::vector<std::string>> by_fold;
  for (const auto& [id, epochs] : names) by_fold[folded_name(id)].push_back(id);
  for (const auto& [fold, ids] : by_fold)
    for (size_t i = 0; i < ids.size(); ++i)
      for (size_t j = i + 1; j < ids.size(); ++j)
        if (!have_common(names.at(ids[i]), names.at(ids[j])))
          out.push_back(ids[i] + " and " + ids[j] +
                        " are two points here, and no epoch has both: if they are one mark, its movement is not seen; "
                        "write its name the same way in all epochs");
}

}  // namespace

std::vector<std::string> names_not_followed(const std::vector<NamedEpoch>& epochs) {
  const auto names = epochs_of_names(epochs);
  std::vector<std::string> out, lost;
  add_alike(names, out);
  std::vector<std::pair<size_t, std::string>> last;  // the longest lost first
  for (const auto& [id, seen] : names)
    if (*seen.rbegin() + 1 < epochs.size()) last.emplace_back(*seen.rbegin(), id);
  std::sort(last.begin(), last.end());
  for (const auto& [k, id] : last) lost.push_back(epochs.size() == 2 ? id : id + " (" + epochs[k].name + ")");
  if (!lost.empty())
    out.push_back("not in " + epochs.back().name + ", so that no movement of theirs is seen" +
                  (epochs.size() == 2 ? ": " : "; last seen: ") + text::join(lost, kMostNamed));
  return out;
}

std::vector<EpochReading> readings_of(const SurveyObservations& survey) {
  std::vector<EpochReading> out;
  for (const Observation& o : survey.observations)
    out.push_back({std::to_string(static_cast<int>(o.kind)) + std::to_string(o.face) + '\n' + o.from + '\n' + o.to +
                       '\n' + o.second_to,
                   o.value});
  for (const LocalCoordinate& c : survey.local_coordinates)
    for (int k = 0; k < 3; ++k) out.push_back({std::to_string(k) + '\n' + c.point, c.position[k]});
  for (const VectorGroup& g : survey.vectors)
    for (size_t i = 0; i < g.vectors.size(); ++i)
      for (int k = 0; k < 3; ++k)
        out.push_back({std::to_string(k) + '\n' + g.vectors[i].from + '\n' + g.vectors[i].to,
                       g.values[static_cast<Eigen::Index>(3 * i) + k]});
  return out;
}

std::optional<std::pair<size_t, size_t>> find_one_measurement(std::vector<std::vector<EpochReading>> epochs) {
  std::map<std::vector<EpochReading>, size_t> known;
  for (size_t k = 0; k < epochs.size(); ++k) {
    std::erase_if(epochs[k], [](const EpochReading& r) { return r.value == 0; });  // of a circle that was set to it
    if (epochs[k].size() < kFewestReadings) continue;
    std::sort(epochs[k].begin(), epochs[k].end());
    const auto [at, is_new] = known.try_emplace(std::move(epochs[k]), k);
    if (!is_new) return std::pair{at->second, k};
  }
  return std::nullopt;
}

bool are_one_measurement(std::vector<EpochReading> first, std::vector<EpochReading> second) {
  return find_one_measurement({std::move(first), std::move(second)}).has_value();
}

std::string one_measurement_in_words(const std::string& first, const std::string& second) {
  return first + " and " + second +
         " have the same readings to the last digit: they are one measurement, not two epochs, and nothing could have "
         "moved between them; name each file once";
}

}  // namespace plumbline::survey
