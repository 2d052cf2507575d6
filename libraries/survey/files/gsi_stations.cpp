#include "survey/files/gsi_stations.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "survey/files/survey_builder.hpp"

namespace plumbline::survey {
namespace {

using Eigen::Vector2d;

constexpr double kSamePlace = 0.03;         // [m]: coordinates and readings are rounded to 1 mm and 1 mgon
constexpr double kSameHeight = 0.006;       // [m]
constexpr double kOtherPoint = 0.5;         // [m] between sightings of one number
constexpr double kLargestReduction = 5e-4;  // of a distance: what maps and heights make of it
constexpr double kLongestOffset = 5;        // [m]: what is keyed in for a point that cannot be sighted
constexpr std::size_t kMostOffsets = 4;     // in a row: two points in both faces
constexpr double kSameDistance = 0.05;      // [m] between a reading and coordinates that were measured before

/// What one block is to the planning.
struct Fact {
  enum class Kind { other, station, point, sighting, names_its_station } kind = Kind::other;
  std::string name;                                           // of the station, point or target
  Eigen::Vector3d at = Eigen::Vector3d::Constant(kNotGiven);  // of station or point, or the target's coordinates
  double instrument_height = kNotGiven;                       // word 88
  double correction = kNotGiven;  // word 25: azimuth minus circle reading of what was measured before
  double horizontal = kNotGiven, direction = kNotGiven, rise = kNotGiven;  // rise: target's point above the axis
  bool has_target_height = false;
  bool has_coordinates() const { return !std::isnan(at.x()) && !std::isnan(at.y()); }
  bool is_polar() const { return !std::isnan(horizontal) && !std::isnan(direction); }
  /// Where the instrument stood if its circle reads azimuths, and the height of its axis.
  Vector2d implied() const { return at.head<2>() - horizontal * Vector2d(std::sin(direction), std::cos(direction)); }
  double implied_axis() const { return at.z() - rise; }
};

class Planner {
 public:
  Planner(const std::vector<GsiBlock>& blocks, const GsiOptions& options, double foot)
      : blocks_(blocks), options_(options), foot_(foot) {}
  GsiStations run();

 private:
  Fact fact_of(const GsiBlock& block);
  void read_sighting(const GsiBlock& block, Fact& fact);
  double length(const GsiBlock& block, int index) const;
  double angle(const GsiBlock& block, int index) const;
  void give_tails_to_their_station();
  bool belongs_ahead(std::size_t first, std::size_t station, std::size_t before) const;
  double misfit(std::size_t sighting, const Fact& station) const;
  void follow_computed_coordinates();
  void join_tails();
  void tell_numbers_apart();
  std::size_t last_of_repeated(std::size_t station) const;
  void follow_axis(std::size_t i, double station_height, double& axis);
  std::size_t offsets_from(std::size_t first, const Vector2d& here) const;
  bool axis_returns(std::size_t i, double axis, double tolerance) const;
  void note_offset(std::size_t i, const Vector2d& here, double axis);
  std::size_t run_from(std::size_t first) const;
  GsiStart start_at(const Fact& first) const;
  void index_places();
  const Fact* place_of(const Vector2d& at) const;
  std::size_t next_sighting(std::size_t i) const;

  const std::vector<GsiBlock>& blocks_;
  const GsiOptions& options_;
  const double foot_;
  double target_height_ = 0;
  bool target_height_known_ = false;
  std::vector<Fact> facts_;
  std::map<std::string, Vector2d> targets_;  // coordinates that the file gives of a point, the first
  std::map<std::pair<long long, long long>, std::vector<std::size_t>> places_;  // named stations and points by cell
  std::map<std::size_t, std::size_t> tails_;  // first sighting before a station block that it belongs to -> that block
  GsiStations plan_;
};

double Planner::length(const GsiBlock& block, int index) const {
  const GsiWord* word = block.find(index);
  if (!word) return kNotGiven;
  const GsiValue value = gsi_length(*word, foot_);
  return value.expected ? kNotGiven : value.value;
}

double Planner::angle(const GsiBlock& block, int index) const {
  const GsiWord* word = block.find(index);
  if (!word) return kNotGiven;
  const GsiValue value = gsi_angle(*word);
  return value.expected ? kNotGiven : value.value;
}

void Planner::read_sighting(const GsiBlock& block, Fact& fact) {
  fact.kind = Fact::Kind::sighting;
  fact.direction = angle(block, 21);
  const double zenith = angle(block, 22), slope = length(block, 31), horizontal = length(block, 32);
  if (options_.vertical_reference != GsiVerticalReference::zenith) {
    fact.horizontal = horizontal;
  } else if (slope > 0 && !std::isnan(zenith)) {
    fact.horizontal = slope * std::abs(std::sin(zenith));
    fact.rise = slope * std::cos(zenith) - target_height_;
  } else if (horizontal > 0) {
    fact.horizontal = horizontal;
  }
  if (!std::isnan(zenith) && wrap_to_circle(zenith) > std::numbers::pi) fact.direction -= std::numbers::pi;
  fact.has_target_height = target_height_known_;
  for (int axis = 0; axis < 3; ++axis) fact.at[axis] = length(block, 81 + axis);
}

Fact Planner::fact_of(const GsiBlock& block) {
  Fact fact;
  if (block.words.front().index == 41) {
    const std::string_view code = block.words.front().text();
    for (const GsiStationCode& rule : options_.station_codes)
      if (rule.code == code) fact.kind = Fact::Kind::station;
    return fact;
  }
  if (const double height = length(block, 87); !std::isnan(height)) {
    target_height_ = height;
    target_height_known_ = true;
  }
  const GsiWord* id = block.find(11);
  if (id) fact.name = std::string(id->text());
  fact.instrument_height = length(block, 88);
  const bool measured = block.find(21) || block.find(22) || block.find(31);
  const bool station_coordinates = block.find(84) && block.find(85);
  if (measured) {
    read_sighting(block, fact);
    if (block.find(16) || station_coordinates) fact.kind = Fact::Kind::names_its_station;
  } else if (station_coordinates || block.find(16)) {
    fact.kind = Fact::Kind::station;
    for (int axis = 0; axis < 3; ++axis) fact.at[axis] = length(block, 84 + axis);
    fact.correction = angle(block, 25);
  } else if (block.find(81) && block.find(82)) {
    fact.kind = Fact::Kind::point;
    for (int axis = 0; axis < 3; ++axis) fact.at[axis] = length(block, 81 + axis);
  }
  return fact;
}

std::size_t Planner::next_sighting(std::size_t i) const {
  while (i < facts_.size() && facts_[i].kind != Fact::Kind::sighting) {
    if (facts_[i].kind == Fact::Kind::station) return facts_.size();
    ++i;
  }
  return i;
}

double Planner::misfit(std::size_t sighting, const Fact& station) const {
  const auto target = targets_.find(facts_[sighting].name);
  if (target == targets_.end() || !station.has_coordinates() || std::isnan(facts_[sighting].horizontal))
    return kNotGiven;
  return std::abs((target->second - station.at.head<2>()).norm() - facts_[sighting].horizontal);
}

/// Sightings [first, station) belong to the station block behind them if the instrument had no coordinates for their
/// targets though it had before, or if their distances to known targets fit the new station and not the one before.
bool Planner::belongs_ahead(std::size_t first, std::size_t station, std::size_t before) const {
  int fits = 0, contradicts = 0;
  for (std::size_t i = first; i < station; ++i) {
    if (facts_[i].kind != Fact::Kind::sighting) continue;
    const double there = misfit(i, facts_[station]);
    if (std::isnan(there)) continue;
    const double here = before < facts_.size() ? misfit(i, facts_[before]) : kNotGiven;
    if (there < kSameDistance && !(here < kSameDistance)) ++fits;
    if (there > kSameDistance) ++contradicts;
  }
  if (fits > 0 || contradicts > 0) return fits > contradicts;
  // Word 25 is the orientation found from the sightings before: nothing else would have written it.
  return !std::isnan(facts_[station].correction);
}

void Planner::give_tails_to_their_station() {
  const bool computes = std::any_of(facts_.begin(), facts_.end(), [](const Fact& f) {
    return f.kind == Fact::Kind::sighting && f.has_coordinates();
  });
  std::size_t before = facts_.size();
  for (std::size_t s = 0; s < facts_.size(); ++s) {
    if (facts_[s].kind != Fact::Kind::station || facts_[s].name.empty()) {
      if (facts_[s].kind == Fact::Kind::station) before = facts_.size();
      continue;
    }
    std::size_t first = s;
    for (std::size_t i = s; i-- > 0;) {
      if (facts_[i].kind == Fact::Kind::station) break;
      if (facts_[i].kind != Fact::Kind::sighting) continue;
      const bool computed = facts_[i].has_coordinates();
      if (computed || (!computes && !(misfit(i, facts_[s]) < kSameDistance))) break;
      first = i;
    }
    if (first < s && belongs_ahead(first, s, before)) {
      GsiStart start;
      start.station = facts_[s].name;
      start.instrument_height = facts_[s].instrument_height;
      start.orientation = facts_[s].correction;
      start.reason = "were measured before the block of station '" + facts_[s].name + "' in line " +
                     std::to_string(blocks_[s].line) + ", which was computed from them: they belong to it";
      plan_.starts[first] = start;
      tails_[first] = s;
    }
    before = s;
  }
}

/// Sightings in a row whose coordinates all come from one place; 0 if the first has none.
std::size_t Planner::run_from(std::size_t first) const {
  std::size_t length = 0;
  for (std::size_t i = first; i < facts_.size(); i = next_sighting(i + 1)) {
    const Fact& fact = facts_[i];
    if (plan_.starts.contains(i) || !fact.is_polar() || !fact.has_coordinates()) break;
    if ((fact.implied() - facts_[first].implied()).norm() > kSamePlace) break;
    ++length;
  }
  return length;
}

std::pair<long long, long long> cell_of(const Vector2d& at) {
  const auto index = [](double v) { return std::abs(v) < 1e12 ? std::llround(v / (2 * kSamePlace)) : 0LL; };
  return {index(at.x()), index(at.y())};
}

void Planner::index_places() {
  for (const Fact::Kind kind : {Fact::Kind::station, Fact::Kind::point})
    for (std::size_t i = 0; i < facts_.size(); ++i)
      if (facts_[i].kind == kind && !facts_[i].name.empty() && facts_[i].has_coordinates())
        places_[cell_of(facts_[i].at.head<2>())].push_back(i);
}

const Fact* Planner::place_of(const Vector2d& at) const {
  const auto [x, y] = cell_of(at);
  for (long long i = x - 1; i <= x + 1; ++i)
    for (long long j = y - 1; j <= y + 1; ++j)
      if (const auto cell = places_.find({i, j}); cell != places_.end())
        for (const std::size_t fact : cell->second)
          if ((facts_[fact].at.head<2>() - at).norm() < kSamePlace) return &facts_[fact];
  return nullptr;
}

GsiStart Planner::start_at(const Fact& first) const {
  GsiStart start;
  start.orientation = 0;
  if (const Fact* place = place_of(first.implied())) {
    start.station = place->name;
    start.reason =
        "have coordinates computed from '" + place->name + "', which the file gives: they were measured there";
    if (first.has_target_height && !std::isnan(place->at.z()) && !std::isnan(first.implied_axis()))
      start.instrument_height = first.implied_axis() - place->at.z();
  } else {
    start.coordinates.head<2>() = first.implied();
    if (first.has_target_height) start.coordinates.z() = first.implied_axis();
    start.reason = "have coordinates computed from a place that no station of the file has";
  }
  return start;
}

/// Sightings whose coordinates come from other places than `here`, where those before and after them were measured: the
/// instrument did not move twice for them. 0 if there are none, or if nothing comes back: that is another station.
std::size_t Planner::offsets_from(std::size_t first, const Vector2d& here) const {
  std::size_t count = 0;
  for (std::size_t i = first; i < facts_.size(); i = next_sighting(i + 1)) {
    const Fact& fact = facts_[i];
    if (plan_.starts.contains(i) || !fact.is_polar() || !fact.has_coordinates()) return 0;
    const double off = (fact.implied() - here).norm();
    if (off < kSamePlace) return count;
    if (!(off < kLongestOffset) || ++count > kMostOffsets || place_of(fact.implied())) return 0;
  }
  return 0;
}

/// The point that was meant and the one that was sighted are two. Where a point is known besides, its coordinates may
/// be those, and a difference of centimetres is what the network is to find.
void Planner::note_offset(std::size_t i, const Vector2d& here, double axis) {
  const Fact& fact = facts_[i];
  const auto given = [&](const Fact& f) {
    return f.name == fact.name && (f.kind == Fact::Kind::station || f.kind == Fact::Kind::point);
  };
  if (std::any_of(facts_.begin(), facts_.end(), given)) return;
  Eigen::Vector3d offset(kNotGiven, kNotGiven, kNotGiven);
  offset.head<2>() = fact.implied() - here;
  if (fact.has_target_height) offset.z() = fact.implied_axis() - axis;
  plan_.offsets[i] = offset;
}

void Planner::follow_computed_coordinates() {
  Vector2d here = Vector2d::Constant(kNotGiven);  // of the current set-up
  double station_height = kNotGiven, axis = kNotGiven;
  bool has_station = false;
  int fits = 0;  // sightings of the set-up whose coordinates were computed from `here`
  for (std::size_t i = 0; i < facts_.size(); ++i) {
    const Fact& fact = facts_[i];
    if (fact.kind == Fact::Kind::station || fact.kind == Fact::Kind::names_its_station || plan_.starts.contains(i)) {
      const bool stated = fact.kind == Fact::Kind::station;
      here = stated ? fact.at.head<2>().eval() : Vector2d::Constant(kNotGiven).eval();
      station_height = stated ? fact.at.z() : kNotGiven;
      axis = station_height + fact.instrument_height;
      has_station = true;
      fits = 0;
    }
    if (fact.kind != Fact::Kind::sighting || !fact.is_polar() || !fact.has_coordinates()) continue;
    if (here.array().isNaN().any() && has_station) here = fact.implied();
    if (!((fact.implied() - here).norm() < kSamePlace)) {
      const Fact* place = place_of(fact.implied());
      const std::size_t length = run_from(i), offsets = place ? 0 : offsets_from(i, here);
      if (offsets > 0 || (length < 2 && !place)) {  // one odd sighting shows no station
        // A turned orientation, or distances that were reduced to a map, move every sighting by as much as it is long.
        const double off = (fact.implied() - here).norm();
        if ((offsets > 0 || fits > 0) && off > kSamePlace + kLargestReduction * fact.horizontal && off < kLongestOffset)
          note_offset(i, here, axis);
        continue;
      }
      plan_.starts[i] = start_at(fact);
      here = fact.implied();
      station_height = place ? place->at.z() : kNotGiven;
      axis = fact.implied_axis();
      has_station = true;
      fits = 0;
    } else {
      ++fits;
      follow_axis(i, station_height, axis);
    }
    plan_.oriented.insert(i);
  }
}

/// Within the next sightings of the set-up: one that stands alone was measured to a target beside the point.
bool Planner::axis_returns(std::size_t i, double axis, double tolerance) const {
  const Fact& fact = facts_[i];
  std::size_t count = 0;
  for (std::size_t k = next_sighting(i + 1); k < facts_.size() && count < kMostOffsets; k = next_sighting(k + 1)) {
    const Fact& next = facts_[k];
    if (plan_.starts.contains(k) || !std::isnan(next.instrument_height)) return false;
    if (!next.has_target_height || std::isnan(next.implied_axis())) continue;
    if ((next.implied() - fact.implied()).norm() > kSamePlace) continue;
    ++count;
    if (std::abs(next.implied_axis() - axis) < tolerance) return true;
    const bool same_target = next.name == fact.name;  // in the other face
    if (!same_target && std::abs(next.implied_axis() - fact.implied_axis()) < tolerance) return false;
  }
  return false;
}

/// The height of the target's coordinates shows where the tilting axis was.
void Planner::follow_axis(std::size_t i, double station_height, double& axis) {
  const Fact& fact = facts_[i];
  if (!fact.has_target_height || std::isnan(fact.implied_axis()) || std::isnan(station_height)) return;
  if (!std::isnan(fact.instrument_height)) {
    axis = station_height + fact.instrument_height;
    return;
  }
  const double tolerance = kSameHeight + 7e-8 * fact.horizontal * fact.horizontal;  // curvature and refraction
  if (std::abs(fact.implied_axis() - axis) < tolerance) return;
  if (axis_returns(i, axis, tolerance)) {
    if (std::abs(fact.implied_axis() - axis) > kSamePlace) note_offset(i, fact.implied(), axis);
    return;
  }
  axis = fact.implied_axis();
  plan_.instrument_height[i] = axis - station_height;
}

/// The last of the station blocks that only repeat block `station`.
std::size_t Planner::last_of_repeated(std::size_t station) const {
  std::size_t last = station;
  for (std::size_t i = station + 1; i < facts_.size(); ++i) {
    const Fact& fact = facts_[i];
    if (fact.kind == Fact::Kind::sighting || fact.kind == Fact::Kind::names_its_station) break;
    if (fact.kind != Fact::Kind::station) continue;
    if (fact.name != facts_[station].name || fact.at.head<2>() != facts_[station].at.head<2>()) break;
    last = i;
  }
  return last;
}

/// Word 25 is by how much the circle was turned at the station block. Where the sightings behind it show that it then
/// read azimuths, those before and behind are one set-up with one circle.
void Planner::join_tails() {
  for (const auto& [first, station] : tails_) {
    const std::size_t last = last_of_repeated(station), next = next_sighting(last + 1);
    if (next >= facts_.size() || std::isnan(facts_[station].correction) || plan_.starts.contains(next)) continue;
    if (!plan_.oriented.contains(next) ||
        !((facts_[next].implied() - facts_[station].at.head<2>()).norm() < kSamePlace))
      continue;
    GsiStart& start = plan_.starts[first];
    start.turn = facts_[station].correction;
    start.orientation = 0;
    for (std::size_t i = station; i <= last; ++i)
      if (facts_[i].kind == Fact::Kind::station) plan_.continued.insert(i);
  }
}

/// Numbering begins again at 1 after a change of memory or of day: the instrument's coordinates show that it is another
/// point. Stations and points that the file gives keep their name, whatever was noted.
void Planner::tell_numbers_apart() {
  std::set<std::string> given;
  for (const Fact& fact : facts_)
    if (fact.kind == Fact::Kind::station || fact.kind == Fact::Kind::point) given.insert(fact.name);
  std::map<std::string, std::vector<Vector2d>> places;
  for (std::size_t i = 0; i < facts_.size(); ++i) {
    const Fact& fact = facts_[i];
    const Vector2d at = fact.at.head<2>();
    if (fact.kind != Fact::Kind::sighting || !plan_.oriented.contains(i) || given.contains(fact.name)) continue;
    std::vector<Vector2d>& known = places[fact.name];
    std::size_t k = 0;
    while (k < known.size() && !((known[k] - at).norm() < kOtherPoint)) ++k;
    if (k == known.size()) known.push_back(at);
    if (k > 0) plan_.renamed[i] = fact.name + "/" + std::to_string(k + 1);
  }
}

GsiStations Planner::run() {
  for (const GsiBlock& block : blocks_) facts_.push_back(fact_of(block));
  for (const Fact& fact : facts_)
    if (fact.has_coordinates() && !fact.name.empty()) targets_.try_emplace(fact.name, fact.at.head<2>());
  index_places();
  give_tails_to_their_station();
  follow_computed_coordinates();
  join_tails();
  tell_numbers_apart();
  return std::move(plan_);
}

}  // namespace

GsiStations plan_gsi_stations(const std::vector<GsiBlock>& blocks, const GsiOptions& options, double foot) {
  return Planner(blocks, options, foot).run();
}

}  // namespace plumbline::survey
