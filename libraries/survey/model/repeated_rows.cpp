#include "survey/model/repeated_rows.hpp"

#include <algorithm>
#include <cmath>
#include <cstring>
#include <map>
#include <set>
#include <string>
#include <utility>

#include "base/text/words.hpp"
#include "survey/model/reading_evidence.hpp"

namespace plumbline::survey {

namespace {

constexpr size_t kNamed = 8;

void put_bits(double value, std::string& key) {
  char bits[sizeof value];
  if (std::isnan(value)) value = kNotGiven;
  if (value == 0) value = 0;  // -0
  std::memcpy(bits, &value, sizeof value);
  key.append(bits, sizeof bits);
}

std::string row_key(const Observation& o) {
  std::string key = (o.set_up < 0 ? o.from : "") + '\n' + o.to + '\n' + o.second_to + '\n' +
                    static_cast<char>('a' + static_cast<int>(o.kind)) + static_cast<char>('0' + o.face);
  for (const double value :
       {o.value, o.sigma, o.levelling_length, o.instrument_height, o.target_height, o.second_target_height})
    put_bits(value, key);
  return key;
}

/// Readings of one sight: of one pointing, or where there is none of one line of a file.
struct RowSight {
  std::vector<int> rows;
  std::string key;
};

std::vector<RowSight> row_sights(const SurveyObservations& s, const std::vector<int>& rows) {
  std::map<std::pair<int, std::string>, RowSight> by_pointing;
  std::vector<std::pair<int, std::string>> order;
  for (const int row : rows) {
    const Observation& o = s.observations[row];
    const std::pair<int, std::string> at = {o.pointing, o.pointing < 0 ? place({o.source.file, o.source.line}) : ""};
    RowSight& sight = by_pointing[at];
    if (sight.rows.empty()) order.push_back(at);
    sight.rows.push_back(row);
  }
  std::vector<RowSight> sights;
  for (const auto& at : order) {
    RowSight sight = std::move(by_pointing.at(at));
    std::vector<std::string> keys;
    for (const int row : sight.rows) keys.push_back(row_key(s.observations[row]));
    std::sort(keys.begin(), keys.end());
    for (const std::string& key : keys) sight.key += key + '\n';
    sights.push_back(std::move(sight));
  }
  return sights;
}

std::string place_of(const SurveyObservations& s, int row) { return place(s.observations[row].source); }

/// The sights of one set-up; marks the rows that go.
void find_repeats(const SurveyObservations& s, const std::vector<int>& rows, const std::string& of,
                  std::vector<bool>& goes, std::vector<Finding>& findings) {
  const std::vector<RowSight> sights = row_sights(s, rows);
  std::vector<const Observation*> readings;
  for (const int row : rows) readings.push_back(&s.observations[row]);
  const Digits digits = digits_of(readings);
  std::map<std::string, const RowSight*> first;
  std::vector<std::pair<const RowSight*, const RowSight*>> repeats;  // of which
  double chance = 0;
  for (const RowSight& sight : sights) {
    const auto [at, is_new] = first.try_emplace(sight.key, &sight);
    if (is_new) continue;
    repeats.emplace_back(&sight, at->second);
    for (const int row : sight.rows) {
      const Observation& o = s.observations[row];
      // A zero is a convention (the backsight, a level line at its start), no coincidence of two sights.
      if (o.value != 0) chance += log_chance(o, 0.5 * (is_angle_reading(o) ? digits.angle : digits.length));
    }
  }
  chance += log_choices(static_cast<int>(sights.size()), static_cast<int>(repeats.size()));
  if (repeats.empty() || chance > kNoCoincidence) return;
  size_t count = 0;
  for (const auto& [sight, earlier] : repeats)
    for (const int row : sight->rows) goes[row] = true, ++count;
  const auto& [sight, earlier] = repeats.front();
  findings.push_back({Finding::Severity::warning,
                      std::to_string(count) + " of " + std::to_string(rows.size()) + " readings" + of +
                          " repeat others to the last digit (" + place_of(s, sight->rows.front()) + " is " +
                          place_of(s, earlier->rows.front()) +
                          "): they are the same readings and count once; take the rows that were pasted twice out",
                      {}});
}

void drop_rows(SurveyObservations& s, const std::vector<bool>& goes) {
  std::vector<int> new_row(s.observations.size(), -1);
  std::vector<Observation> kept;
  for (size_t i = 0; i < s.observations.size(); ++i) {
    if (goes[i]) continue;
    new_row[i] = static_cast<int>(kept.size());
    kept.push_back(std::move(s.observations[i]));
  }
  s.observations = std::move(kept);
  std::erase_if(s.covariances, [&](ObservationCovariance& c) {
    for (int& i : c.indices) i = new_row[i];
    return std::find(c.indices.begin(), c.indices.end(), -1) != c.indices.end();
  });
}

void take_out_sights(SurveyObservations& s, std::vector<Finding>& findings) {
  std::vector<std::vector<int>> rows(s.set_ups.size() + 1);
  for (size_t i = 0; i < s.observations.size(); ++i)
    rows.at(s.observations[i].set_up + 1).push_back(static_cast<int>(i));
  std::vector<bool> goes(s.observations.size());
  for (size_t k = 0; k < rows.size(); ++k)
    find_repeats(s, rows[k], k == 0 ? " without a set-up" : " of set-up " + s.set_ups[k - 1].id, goes, findings);
  if (std::find(goes.begin(), goes.end(), true) != goes.end()) drop_rows(s, goes);
}

void add_matrix(const Eigen::MatrixXd& matrix, std::string& key) {
  for (Eigen::Index i = 0; i < matrix.size(); ++i) put_bits(matrix.data()[i], key);
}

std::string group_key(const CoordinateGroup& g) {
  std::string key = g.is_control ? "known\n" : "measured\n";
  for (const auto& c : g.components) key += c.point + '\n' + "ENH"[c.axis];
  add_matrix(g.values, key);
  add_matrix(g.covariance, key);
  return key;
}

std::string group_key(const VectorGroup& g) {
  std::string key = g.is_geocentric ? "earth\n" : "plane\n";
  for (const auto& v : g.vectors) {
    key += v.from + '\n' + v.to + '\n';
    put_bits(v.from_height, key), put_bits(v.to_height, key);
  }
  add_matrix(g.values, key);
  add_matrix(g.covariance, key);
  return key;
}

/// Keeps the first of each; `taken` and `kept` get the repeats and what they repeat.
template <typename Group>
std::vector<std::pair<Group, SourcePosition>> take_out_groups(std::vector<Group>& groups) {
  std::map<std::string, SourcePosition> first;
  std::vector<std::pair<Group, SourcePosition>> taken;
  std::vector<Group> kept;
  for (Group& g : groups) {
    const auto [at, is_new] = first.try_emplace(group_key(g), g.source);
    if (is_new)
      kept.push_back(std::move(g));
    else
      taken.emplace_back(std::move(g), at->second);
  }
  groups = std::move(kept);
  return taken;
}

void take_out_coordinates(SurveyObservations& s, std::vector<Finding>& findings) {
  std::set<std::string> known, measured;
  SourcePosition one, other;
  for (const auto& [group, first] : take_out_groups(s.coordinates)) {
    if (known.empty() && measured.empty()) one = group.source, other = first;
    for (const auto& c : group.components) (group.is_control ? known : measured).insert(c.point);
  }
  const auto say = [&](const std::set<std::string>& points, Finding::Severity severity, const std::string& what) {
    const std::vector<std::string> ids(points.begin(), points.end());
    if (ids.empty()) return;
    findings.push_back({severity,
                        "stated twice with the same values: " + what + text::join(ids, kNamed) + " (" + place(one) +
                            " is " + place(other) + "); they count once",
                        ids});
  };
  // Every file of a campaign may begin with the same known points.
  say(known, Finding::Severity::note, "known points ");
  say(measured, Finding::Severity::warning, "measured coordinates of ");
}

/// Files of which one has the vectors of the other.
using FilePairs = std::set<std::pair<std::string, std::string>>;

FilePairs take_out_vectors(SurveyObservations& s, std::vector<Finding>& findings) {
  const auto taken = take_out_groups(s.vectors);
  FilePairs pairs;
  size_t count = 0;
  for (const auto& [group, first] : taken) {
    count += group.vectors.size();
    if (group.source.file != first.file) pairs.insert({group.source.file, first.file});
  }
  if (count > 0)
    findings.push_back({Finding::Severity::warning,
                        std::to_string(count) + " of the vectors stand a second time with the same values (" +
                            place(taken.front().first.source) + " is " + place(taken.front().second) +
                            "): they are the same measurement and count once; take one "
                            "of the two out",
                        {}});
  return pairs;
}

/// One levelled line alone may come out alike on two days; not where the file's vectors are those of the other, too.
void take_out_lines(SurveyObservations& s, const FilePairs& pairs, std::vector<Finding>& findings) {
  std::map<std::string, std::vector<std::string>> holders;  // of a reading: files
  std::vector<bool> goes(s.observations.size());
  size_t count = 0;
  for (size_t i = 0; i < s.observations.size(); ++i) {
    const Observation& o = s.observations[i];
    if (o.set_up >= 0) continue;
    std::vector<std::string>& files = holders[row_key(o)];
    goes[i] = std::any_of(files.begin(), files.end(), [&](const std::string& file) {
      return pairs.contains({o.source.file, file});
    });
    if (goes[i])
      ++count;
    else
      files.push_back(o.source.file);
  }
  if (count == 0) return;
  drop_rows(s, goes);
  findings.push_back({Finding::Severity::warning,
                      std::to_string(count) + " of the single readings of " + pairs.begin()->first + " stand in " +
                          pairs.begin()->second + " too, as its vectors do: counted once",
                      {}});
}

}  // namespace

std::vector<Finding> take_out_repeated_rows(SurveyObservations& survey) {
  std::vector<Finding> findings;
  take_out_sights(survey, findings);
  take_out_coordinates(survey, findings);
  if (const FilePairs pairs = take_out_vectors(survey, findings); !pairs.empty())
    take_out_lines(survey, pairs, findings);
  return findings;
}

}  // namespace plumbline::survey
