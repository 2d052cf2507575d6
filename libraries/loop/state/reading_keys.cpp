#include "loop/state/reading_keys.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <tuple>

#include "base/text/words.hpp"
#include "loop/state/hash.hpp"

namespace plumbline::loop {
namespace {

constexpr double kStep = 1e-7;  ///< of the numbers [rad], [m]
constexpr std::size_t kSighting = 2, kRepeats = 3, kRounded = 10;
constexpr std::array kWritten{1e-3, 1e-4, 1e-5};  ///< steps of coordinates in files, coarsest first [m]
constexpr double kLastBits = 1e-3;                ///< of a step: what the last bits of large coordinates may be

ReadingKey key_of(const std::string& from, const std::string& to, const std::string& set_up,
                  const std::vector<double>& values) {
  return {sha256_hex(from + "\n" + to + "\n" + sha256_hex(values, kStep)).substr(0, 16), set_up, to, {}, {}};
}

/// Of coordinates that are multiples of the step.
std::string hash_at(const std::string& names, const std::vector<double>& values, double step) {
  return sha256_hex(names + "\n" + std::to_string(std::llround(1 / step)) + "\n" + sha256_hex(values, step))
      .substr(0, 16);
}

bool is_written(const std::vector<double>& values, double step) {
  return std::all_of(values.begin(), values.end(),
                     [&](double value) { return std::abs(value / step - std::round(value / step)) < kLastBits; });
}

/// Coordinates of points, by set-up.
class Coordinates {
 public:
  explicit Coordinates(std::vector<ReadingKey>& keys) : keys_(keys) {}

  void add(const std::string& from, const std::string& to, const std::string& set_up, std::vector<double> values) {
    keys_.push_back(key_of(from, to, set_up, values));
    const std::string names = from + "\n" + to;
    for (const double step : kWritten)
      if (values.size() <= 3) add_rounded(keys_.back().rounded, names, {}, values, step);
    set_ups_[set_up].push_back({keys_.size() - 1, names, std::move(values)});
  }

  void note_written() {
    for (const auto& [name, places] : set_ups_) {
      const auto step = std::find_if(kWritten.begin(), kWritten.end(), [&](double one) {
        return std::all_of(places.begin(), places.end(), [&](const Place& at) { return is_written(at.values, one); });
      });
      if (step == kWritten.end()) continue;
      for (const Place& at : places) keys_[at.key].written = hash_at(at.names, at.values, *step);
    }
  }

 private:
  struct Place {
    std::size_t key;
    std::string names;
    std::vector<double> values;
  };

  /// Whoever rounded them decided at ties: half up, to even, or by the last bit.
  static void add_rounded(std::vector<std::string>& hashes, const std::string& names, std::vector<double> begun,
                          const std::vector<double>& values, double step) {
    if (begun.size() == values.size()) {
      hashes.push_back(hash_at(names, begun, step));
      return;
    }
    const double steps = values[begun.size()] / step, below = std::floor(steps);
    begun.push_back(0);
    for (const int up : {0, 1}) {
      if (up ? steps - below < 0.5 - kLastBits : steps - below > 0.5 + kLastBits) continue;
      begun.back() = (below + up) * step;
      add_rounded(hashes, names, begun, values, step);
    }
  }

  std::vector<ReadingKey>& keys_;
  std::map<std::string, std::vector<Place>> set_ups_;
};

void add_pointings(const SurveyObservationsT& o, std::vector<ReadingKey>& keys) {
  // The order of the values within a pointing is that of the file.
  std::map<std::tuple<int, int, std::string>, std::vector<const SurveyObservationT*>> pointings;
  for (const auto& one : o.observations)
    if (one->pointing >= 0) pointings[{one->set_up, one->pointing, one->to}].push_back(one.get());
  for (const auto& [which, sighted] : pointings) {
    if (sighted.size() < kSighting) continue;
    std::vector<double> values;
    for (const SurveyObservationT* one : sighted)
      values.insert(values.end(), {static_cast<double>(one->kind), static_cast<double>(one->face), one->value});
    const int at = std::get<0>(which);
    const bool has_set_up = at >= 0 && at < static_cast<int>(o.set_ups.size());
    keys.push_back(key_of(sighted.front()->from, sighted.front()->to, has_set_up ? o.set_ups[at]->id : "", values));
  }
}

}  // namespace

std::vector<ReadingKey> reading_keys(const SurveyObservationsT& o) {
  std::vector<ReadingKey> keys;
  add_pointings(o, keys);
  Coordinates coordinates(keys);
  for (const auto& one : o.local_coordinates) {
    const bool has_set_up = one->set_up >= 0 && one->set_up < static_cast<int>(o.set_ups.size());
    const SurveySetUpT* set_up = has_set_up ? o.set_ups[one->set_up].get() : nullptr;
    coordinates.add(set_up ? set_up->station : "", one->point, set_up ? set_up->id : "",
                    {one->position.x(), one->position.y(), one->position.z()});
  }
  for (const auto& group : o.coordinates) {
    if (group->is_control) continue;
    std::map<std::string, std::vector<double>> values;
    for (std::size_t i = 0; i < group->points.size() && i < group->values.size(); ++i)
      values[group->points[i]].push_back(group->values[i]);
    for (const auto& [point, place] : values)
      if (place.size() >= kSighting) coordinates.add("", point, group->file, place);
  }
  for (const auto& group : o.vectors)
    for (std::size_t i = 0; i < group->from.size() && 3 * i + 2 < group->values.size(); ++i)
      coordinates.add(group->from[i], group->to[i], group->from[i],
                      {group->values[3 * i], group->values[3 * i + 1], group->values[3 * i + 2]});
  coordinates.note_written();
  return keys;
}

RepeatedReadings repeated_readings(const std::vector<ReadingKey>& readings, const std::vector<std::string>& known) {
  struct SetUp {
    std::size_t all = 0;
    std::vector<const ReadingKey*> known, rounded;
  };
  const auto is_known = [&](const std::string& hash) { return std::binary_search(known.begin(), known.end(), hash); };
  std::map<std::string, SetUp> set_ups;
  for (const ReadingKey& reading : readings) {
    SetUp& at = set_ups[reading.set_up];
    ++at.all;
    if (is_known(reading.hash)) at.known.push_back(&reading);
    if (!reading.written.empty() && is_known(reading.written)) at.rounded.push_back(&reading);
  }
  RepeatedReadings out;
  out.all = readings.size();
  for (auto& [name, at] : set_ups) {
    if (at.all >= kRounded && 10 * at.rounded.size() >= 9 * at.all && at.rounded.size() > at.known.size())
      at.known = at.rounded, out.fewer_digits = true;
    if (at.known.empty() || at.known.size() < std::min(kRepeats, at.all)) continue;
    out.count += at.known.size();
    out.set_ups.insert(name);
    for (const ReadingKey* reading : at.known) out.targets.insert(reading->target);
  }
  return out;
}

std::string words_of(const RepeatedReadings& repeated) {
  if (repeated.count == 0) return {};
  std::vector<std::string> names;
  for (const std::string& name : repeated.set_ups)
    if (!name.empty()) names.push_back(name);
  return std::to_string(repeated.count) + " of " + std::to_string(repeated.all) +
         " readings are those of a campaign before, " +
         (repeated.fewer_digits ? "with fewer digits" : "to the last digit") +
         (names.empty() ? ""
                        : std::string(names.size() > 1 ? " (set-ups " : " (set-up ") + text::join(names, 4) + ")") +
         ": the points that they see do not count as measured since, and this campaign counts alone. Give each round "
         "the readings of its own campaign only";
}

}  // namespace plumbline::loop
