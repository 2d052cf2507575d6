#include "survey/model/repeated_readings.hpp"

#include <algorithm>
#include <cmath>
#include <cstring>
#include <map>
#include <set>
#include <unordered_map>
#include <vector>

#include "base/text/text.hpp"
#include "base/text/words.hpp"
#include "survey/model/rounded_readings.hpp"

namespace plumbline::survey {

namespace {

constexpr int kFewestReadings = 3;  // readings that are not zero: fewer may be the same by chance

/// A set-up of a file, or (set_up -1) what the file has without set-ups.
struct Part {
  size_t file = 0;
  int set_up = -1;
  int readings = 0;
  int not_zero = 0;
  std::vector<std::string> keys;  ///< one for each reading, sorted
};

void add_bits(double value, std::string& key) {
  char bits[sizeof value];
  if (value == 0) value = 0;  // -0
  std::memcpy(bits, &value, sizeof value);
  key.append(bits, sizeof bits);
}

std::string reading_key(const Observation& o) {
  std::string key = o.to + '\n' + o.second_to + '\n' + (o.set_up < 0 ? o.from : "") + '\n' +
                    static_cast<char>('a' + static_cast<int>(o.kind)) + static_cast<char>('0' + o.face);
  add_bits(o.value, key);
  return key;
}

std::string reading_key(const LocalCoordinate& c) {
  std::string key = c.point + "\nlocal";
  for (int k = 0; k < 3; ++k) add_bits(c.position[k], key);
  return key;
}

std::vector<Part> parts_of(const std::vector<SurveyObservations>& surveys) {
  std::vector<Part> parts;
  for (size_t file = 0; file < surveys.size(); ++file) {
    const SurveyObservations& s = surveys[file];
    std::vector<Part> own(s.set_ups.size() + 1);
    for (size_t i = 0; i < own.size(); ++i) own[i].file = file, own[i].set_up = static_cast<int>(i) - 1;
    const auto add = [&](int set_up, std::string key, bool not_zero) {
      Part& part = own.at(set_up + 1);
      part.keys.push_back(std::move(key));
      ++part.readings;
      part.not_zero += not_zero;
    };
    for (const Observation& o : s.observations) add(o.set_up, reading_key(o), o.value != 0);
    for (const LocalCoordinate& c : s.local_coordinates) add(c.set_up, reading_key(c), true);
    for (Part& part : own) {
      std::sort(part.keys.begin(), part.keys.end());
      if (part.not_zero >= kFewestReadings) parts.push_back(std::move(part));
    }
  }
  return parts;
}

std::string name_of(const SurveyObservations& s, size_t file) {
  return s.files.empty() ? "file " + std::to_string(file + 1) : s.files.front();
}

/// Every point that something in the file speaks of.
std::set<std::string> named_points(const SurveyObservations& s) {
  std::set<std::string> named;
  for (const SetUp& u : s.set_ups) named.insert(u.station);
  for (const Observation& o : s.observations) named.insert({o.from, o.to, o.second_to});
  for (const LocalCoordinate& c : s.local_coordinates) named.insert(c.point);
  for (const CoordinateGroup& g : s.coordinates)
    for (const auto& c : g.components) named.insert(c.point);
  for (const VectorGroup& g : s.vectors)
    for (const auto& v : g.vectors) named.insert({v.from, v.to});
  return named;
}

void take_out(SurveyObservations& s, const std::set<int>& set_ups) {
  const std::set<std::string> before = named_points(s);
  std::vector<int> new_set_up(s.set_ups.size()), new_row(s.observations.size(), -1);
  std::vector<SetUp> kept_set_ups;
  for (size_t i = 0; i < s.set_ups.size(); ++i) {
    new_set_up[i] = static_cast<int>(kept_set_ups.size());
    if (!set_ups.contains(static_cast<int>(i))) kept_set_ups.push_back(s.set_ups[i]);
  }
  std::vector<Observation> kept;
  for (size_t i = 0; i < s.observations.size(); ++i) {
    if (set_ups.contains(s.observations[i].set_up)) continue;
    new_row[i] = static_cast<int>(kept.size());
    kept.push_back(s.observations[i]);
    if (kept.back().set_up >= 0) kept.back().set_up = new_set_up[kept.back().set_up];
  }
  s.set_ups = std::move(kept_set_ups);
  s.observations = std::move(kept);
  std::erase_if(s.covariances, [&](ObservationCovariance& c) {
    for (int& i : c.indices) i = new_row[i];
    return std::find(c.indices.begin(), c.indices.end(), -1) != c.indices.end();
  });
  std::erase_if(s.local_coordinates, [&](LocalCoordinate& c) {
    if (set_ups.contains(c.set_up)) return true;
    if (c.set_up >= 0) c.set_up = new_set_up[c.set_up];
    return false;
  });
  const std::set<std::string> after = named_points(s);
  std::erase_if(s.points, [&](const Point& p) { return before.contains(p.id) && !after.contains(p.id); });
}

bool same_groups(const SurveyObservations& a, const SurveyObservations& b) {
  const auto same = [](const auto& x, const auto& y) {
    return x.values.size() == y.values.size() && x.values == y.values;
  };
  return std::equal(a.coordinates.begin(), a.coordinates.end(), b.coordinates.begin(), b.coordinates.end(), same) &&
         std::equal(a.vectors.begin(), a.vectors.end(), b.vectors.begin(), b.vectors.end(), same);
}

using Repeats = std::map<std::pair<size_t, size_t>, std::vector<size_t>>;  // file, file that has the same -> parts

/// Set-ups of two files that are the same but for the digits they are written in.
void find_rounded(const std::vector<SurveyObservations>& surveys, const std::vector<Part>& parts,
                  std::vector<std::set<int>>& out, Repeats& repeats) {
  std::map<std::string, std::vector<size_t>> alike;  // what was read, without values -> parts
  std::vector<std::vector<const Observation*>> readings(parts.size());
  for (size_t i = 0; i < parts.size(); ++i) {
    if (parts[i].set_up < 0 || out[parts[i].file].contains(parts[i].set_up)) continue;
    readings[i] = in_order(surveys[parts[i].file], parts[i].set_up);
    std::string key;
    for (const Observation* o : readings[i])
      key += o->to + '\n' + static_cast<char>('a' + static_cast<int>(o->kind)) + static_cast<char>('0' + o->face);
    alike[key].push_back(i);
  }
  for (const auto& [key, list] : alike)
    for (size_t k = 1; k < list.size(); ++k)
      for (size_t j = 0; j < k; ++j) {
        size_t goes = list[k], stays = list[j];
        if (parts[goes].file == parts[stays].file || out[parts[stays].file].contains(parts[stays].set_up)) continue;
        const Rounded rounded = same_when_rounded(readings[goes], readings[stays]);
        if (rounded == Rounded::no) continue;
        if (rounded == Rounded::second_is_coarser) std::swap(goes, stays);
        repeats[{parts[goes].file, parts[stays].file}].push_back(goes);
        out[parts[goes].file].insert(parts[goes].set_up);
        if (goes == list[k]) break;
      }
}

/// Known points that a copy has elsewhere than the original, as "K3 (E 540.000 m and 540.050 m)".
std::vector<std::string> known_elsewhere(const SurveyObservations& original, const SurveyObservations& copy) {
  constexpr double kSame = 0.001;  // [m]
  std::unordered_map<std::string, const Point*> points;
  for (const Point& p : original.points) points[p.id] = &p;
  std::vector<std::string> found;
  for (const Point& p : copy.points) {
    const auto at = points.find(p.id);
    for (int k = 0; k < 3 && at != points.end(); ++k) {
      const Point& first = *at->second;
      const auto axis = static_cast<size_t>(k);
      if (!p.known[axis] || !first.known[axis] || !(std::abs(p.coordinates[k] - first.coordinates[k]) > kSame))
        continue;
      found.push_back(p.id + " (" + "ENH"[k] + " " + text::format_fixed(first.coordinates[k], 3) + " m and " +
                      text::format_fixed(p.coordinates[k], 3) + " m)");
    }
  }
  return found;
}

}  // namespace

std::vector<std::string> take_out_repeated_readings(std::vector<SurveyObservations>& surveys) {
  const std::vector<Part> parts = parts_of(surveys);
  std::unordered_map<std::string, std::vector<size_t>> holders;  // of a reading
  for (size_t i = 0; i < parts.size(); ++i)
    for (const std::string& key : parts[i].keys)
      if (auto& list = holders[key]; list.empty() || list.back() != i) list.push_back(i);
  Repeats repeats;
  std::vector<std::set<int>> out(surveys.size());
  for (size_t i = 0; i < parts.size(); ++i) {
    // Whoever holds all of them holds the one that fewest have.
    const std::vector<size_t>* fewest = &holders.at(parts[i].keys.front());
    for (const std::string& key : parts[i].keys)
      if (holders.at(key).size() < fewest->size()) fewest = &holders.at(key);
    for (const size_t other : *fewest) {
      const bool larger = parts[other].keys.size() > parts[i].keys.size();
      const bool earlier = parts[other].keys.size() == parts[i].keys.size() && other < i;
      if (!larger && !earlier) continue;
      if (!std::includes(parts[other].keys.begin(), parts[other].keys.end(), parts[i].keys.begin(),
                         parts[i].keys.end()))
        continue;
      repeats[{parts[i].file, parts[other].file}].push_back(i);
      out[parts[i].file].insert(parts[i].set_up);
      break;
    }
  }
  find_rounded(surveys, parts, out, repeats);
  std::vector<std::string> sentences;
  for (const auto& [files, list] : repeats) {
    int readings = 0;
    std::string set_ups;
    for (const size_t i : list) {
      readings += parts[i].readings;
      if (parts[i].set_up >= 0)
        set_ups += (set_ups.empty() ? ", set-ups " : ", ") + surveys[files.first].set_ups[parts[i].set_up].id;
    }
    const std::string mine = name_of(surveys[files.first], files.first);
    const std::string other = name_of(surveys[files.second], files.second);
    sentences.push_back(std::to_string(readings) + " readings of " + mine + " stand " +
                        (files.first == files.second ? "in it a second time" : "in " + other + " too") + set_ups +
                        ": they are the same readings and count once; take one of the two out");
  }
  for (const auto& [files, list] : repeats) {
    const auto elsewhere = known_elsewhere(surveys[files.second], surveys[files.first]);
    if (files.first == files.second || elsewhere.empty()) continue;
    const std::string other = name_of(surveys[files.second], files.second);
    sentences.push_back("known points are keyed in with other coordinates in " + other + " than in " +
                        name_of(surveys[files.first], files.first) + ", whose readings are the same: " +
                        text::join(elsewhere, 8) + "; those of " + other + " hold. Give the right ones as control");
  }
  // Which files go is found while all of them are there: the groups of one are compared with those of another.
  std::vector<bool> goes(surveys.size());
  for (size_t file = 0; file < surveys.size(); ++file) {
    SurveyObservations& s = surveys[file];
    if (out[file].empty()) continue;
    take_out(s, out[file]);
    goes[file] = s.observations.empty() && s.local_coordinates.empty();
    if (goes[file] && !(s.coordinates.empty() && s.vectors.empty()))
      goes[file] = std::any_of(repeats.begin(), repeats.end(), [&](const auto& r) {
        return r.first.first == file && r.first.second != file && same_groups(s, surveys[r.first.second]);
      });
  }
  std::vector<SurveyObservations> left;
  for (size_t file = 0; file < surveys.size(); ++file)
    if (!goes[file]) left.push_back(std::move(surveys[file]));
  surveys = std::move(left);
  return sentences;
}

}  // namespace plumbline::survey
