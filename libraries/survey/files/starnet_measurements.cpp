// What was measured, in a file of STAR*NET: single values, direction sets, traverses and levelling.
#include <algorithm>
#include <cmath>
#include <map>

#include "survey/files/starnet_reader.hpp"

namespace plumbline::survey {

using enum ObservationKind;

bool StarNetReader::names(std::string_view joined, std::size_t count, std::vector<std::string>& out) {
  out.clear();
  for (const auto part : text::split(joined, separator_)) out.emplace_back(text::trim(part));
  if (out.size() == count && std::none_of(out.begin(), out.end(), [](const auto& n) { return n.empty(); })) return true;
  reject(joined, std::to_string(count) + " station names joined by '" + separator_ + "'");
  return false;
}

// Slope distance and zenith angle, or horizontal distance and height difference.
std::vector<ObservationKind> StarNetReader::polar() const {
  if (!three_) return {horizontal_distance};
  return delta_ ? std::vector{horizontal_distance, height_difference} : std::vector{slope_distance, zenith_angle};
}

void StarNetReader::take(const Parts& parts, std::size_t first, const std::vector<ObservationKind>& kinds,
                         Observation like) {
  const std::size_t n = kinds.size();
  if (parts.size() < first + n) return reject(parts[0], std::to_string(n) + " values behind the stations");
  std::size_t end = parts.size();
  if (end > first + n && parts[end - 1].find('/') != std::string_view::npos) {
    const auto heights = text::split(parts[--end], '/');
    const auto hi = text::parse_number(heights[0]), ht = text::parse_number(heights.back());
    if (heights.size() != 2 || !hi || !ht) return reject(parts[end], "HI/HT, the heights of instrument and target");
    like.instrument_height = *hi * metres_;
    like.target_height = *ht * metres_;
  }
  if (end > first + 2 * n) return reject(parts[first + 2 * n], "a standard deviation for each value, then HI/HT");
  std::vector<Observation> made;
  for (std::size_t i = 0; i < n; ++i) {
    Observation o = like;
    o.kind = kinds[i];
    o.instrument = instrument_;
    if (o.kind != ObservationKind::angle) o.second_to.clear();
    const std::string_view text = parts[first + i];
    if (text == "?" || text == "*") continue;  // not measured
    const auto value = value_of(text, o.kind);
    const bool is_distance = o.kind == slope_distance || o.kind == horizontal_distance;
    if (!value || (is_distance && *value <= 0))
      return reject(text, is_distance             ? "a distance above zero"
                          : is_angle_kind(o.kind) ? "an angle as 123-45-56.7"
                                                  : "a number");
    o.value = *value;
    if (first + n + i < end) {
      const auto sigma = sigma_of(parts[first + n + i], o.kind);
      if (!sigma) return reject(parts[first + n + i], "a standard deviation above zero, '&', '!' or '*'");
      if (*sigma == 0) {
        ++freed_;
        continue;
      }
      o.sigma = *sigma;
      const bool held = parts[first + n + i] == "!";
      o.without_centring = add_centring_ && !std::isnan(*sigma) && !held && o.kind != height_difference;
    }
    made.push_back(std::move(o));
  }
  // A zenith angle beyond half a circle is read in face 2, and so is the direction beside it; an included angle is the
  // same in both faces.
  const bool second_face = std::any_of(made.begin(), made.end(), [](const Observation& o) {
    return o.kind == zenith_angle && face_of_zenith_angle(o.value) == 2;
  });
  for (Observation& o : made) {
    if (second_face && (o.kind == direction || o.kind == zenith_angle)) o.face = 2;
    if (o.kind == ObservationKind::angle) {
      // From at, left arm, right arm. The rest of the line goes to the right arm.
      builder_.add(std::move(o));
      continue;
    }
    if (!like.second_to.empty()) o.to = like.second_to;
    builder_.add(std::move(o));
  }
}

void StarNetReader::read_measured(std::string_view code, const Parts& parts) {
  const bool three_names = code == "A" || code == "M" || code == "SS";
  std::vector<std::string> ids;
  if (parts.size() < 3) return reject(parts[0], "stations and values");
  if (!names(parts[1], three_names ? 3 : 2, ids)) return;
  Observation like;
  like.source = builder_.at(line_, 1);
  if (three_names) {
    used_angles_ = true;
    like.from = ids[from_at_to_ ? 1 : 0];
    like.to = ids[from_at_to_ ? 0 : 1];
    like.second_to = ids[2];
    if (like.from == like.to || like.from == ids[2] || like.to == ids[2]) return reject(parts[1], "three stations");
  } else {
    like.from = ids[0];
    like.to = ids[1];
    if (like.from == like.to) return reject(parts[1], "two stations");
  }
  std::vector<ObservationKind> kinds;
  const auto vertical = delta_ ? height_difference : zenith_angle;
  if (code == "A") kinds = {ObservationKind::angle};
  if (code == "D") kinds = {three_ && !delta_ ? slope_distance : horizontal_distance};
  if (code == "V") kinds = {vertical};
  if (code == "B") kinds = {azimuth};
  if (code == "DV") kinds = polar();
  if (code == "BM" || code == "M" || code == "SS") {
    kinds = polar();
    kinds.insert(kinds.begin(), code == "BM" ? azimuth : ObservationKind::angle);
  }
  if (code == "SS") side_shots_.insert(line_);
  take(parts, 2, kinds, std::move(like));
}

// Side shots place a point and take no part in the adjustment: one that leads to a point which anything else knows, a
// side shot before it too, would bend the network.
void StarNetReader::leave_out_side_shots() {
  std::vector<Observation>& all = builder_.survey.observations;
  const auto is_side_shot = [&](const Observation& o) { return side_shots_.contains(o.source.line); };
  const auto target_of = [](const Observation& o) { return o.second_to.empty() ? o.to : o.second_to; };
  std::set<std::string> measured;
  for (const Observation& o : all)
    if (!is_side_shot(o)) measured.insert({o.from, o.to, o.second_to});
  for (const VectorGroup& g : builder_.survey.vectors)
    for (const auto& v : g.vectors) measured.insert({v.from, v.to});
  std::map<std::string, int> first;  // line of the side shot that places a point
  for (const Observation& o : all)
    if (is_side_shot(o)) first.try_emplace(target_of(o), o.source.line);
  std::set<int> out;
  for (const Observation& o : all)
    if (is_side_shot(o) && (measured.contains(target_of(o)) || first.at(target_of(o)) != o.source.line))
      out.insert(o.source.line);
  if (out.empty()) return;
  std::erase_if(all, [&](const Observation& o) { return out.contains(o.source.line); });
  builder_.warn(std::to_string(out.size()) + " side shots (SS) lead to points that are placed without them (line " +
                std::to_string(*out.begin()) + " is the first): they take no part, as in STAR*NET");
}

// DB at; DN to direction; DM to direction distance zenith; DE
void StarNetReader::read_direction(std::string_view code, const Parts& parts) {
  if (code == "DE") {
    if (ends_at(parts, 1, "DE stands alone")) set_at_.clear();
    return;
  }
  if (parts.size() < 2) return reject(parts[0], "a station");
  if (code == "DB") {
    if (!ends_at(parts, 2, "DB has the occupied station alone")) return set_at_.clear();
    set_at_ = std::string(parts[1]);
    builder_.start_set_up(set_at_, kNotGiven, builder_.at(line_, 1));
    return;
  }
  if (set_at_.empty()) return reject(parts[0], "DB with the occupied station before it");
  Observation like;
  like.from = set_at_;
  like.to = std::string(parts[1]);
  like.set_up = builder_.current_set_up();
  like.source = builder_.at(line_, 1);
  if (like.to == set_at_) return reject(parts[1], "another point than the station");
  std::vector<ObservationKind> kinds = {direction};
  if (code == "DM")
    for (const ObservationKind kind : polar()) kinds.push_back(kind);
  take(parts, 2, kinds, std::move(like));
}

// TB backsight; T station angle distance zenith, each to the station of the next line; TE station [angle closing].
void StarNetReader::read_traverse(std::string_view code, const Parts& parts) {
  if (parts.size() < 2) return reject(parts[0], "a station");
  const std::string station(parts[1]);
  if (code == "TB" && !ends_at(parts, 2, "TB has the backsight alone")) return;
  if (code == "TE" && !ends_at(parts, 4, "TE has a station, an angle and where it closes")) return;
  if (code == "TB") {
    const bool names_an_angle = std::count(station.begin(), station.end(), '-') == 2;
    if (separator_ == '-' && names_an_angle && bearing(station))
      return reject(station,
                    "the name of a backsight: a bearing or azimuth in its place is not read; give it as a line "
                    "'B first-second bearing' and the first angle by a backsight that has coordinates");
    backsight_ = station;
    at_.clear();
    pending_.clear();
    return;
  }
  if (!pending_.empty()) {
    Observation like = pending_like_;
    like.second_to = station;
    const Parts of_line = text::split_blanks(pending_);
    const int here = line_;
    line_ = like.source.line;
    auto kinds = polar();
    kinds.insert(kinds.begin(), ObservationKind::angle);
    take(of_line, 2, kinds, like);
    line_ = here;
    pending_.clear();
  }
  if (!at_.empty()) backsight_ = at_;
  at_ = station;
  pending_like_ = {};
  pending_like_.from = at_;
  pending_like_.to = backsight_;
  pending_like_.source = builder_.at(line_, 1);
  if (code == "T") {
    if (backsight_.empty() || backsight_ == at_) return reject(parts[0], "TB with the backsight before it");
    pending_ = line_text_;
    return;
  }
  if (parts.size() >= 4 && !backsight_.empty()) {  // TE: the closing angle
    pending_like_.second_to = std::string(parts[3]);
    const Parts closing = {parts[0], parts[1], parts[2]};
    if (pending_like_.second_to != at_ && pending_like_.second_to != backsight_)
      take(closing, 2, {ObservationKind::angle}, pending_like_);
  }
  at_.clear();
  backsight_.clear();
}

// .LWEIGHT value: standard deviation of a levelled line of 1 km (1 mile in a file of feet), growing with the root.
void StarNetReader::read_level_weight(const Parts& parts) {
  const auto value = parts.size() == 2 ? text::parse_number(parts[1]) : std::nullopt;
  if (!value || *value <= 0) return reject(parts[0], ".LWEIGHT and the standard deviation of a line of 1 km or mile");
  const double unit = metres_ == 1 ? 1000.0 : 5280 * metres_;  // [m]
  level_weight_ = *value * metres_ * std::sqrt(1000.0 / unit);
}

// L from-to difference [length [standard deviation]]. A lone number below a metre is no length: some write the standard
// deviation there, which is said.
void StarNetReader::read_levelled(const Parts& parts) {
  std::vector<std::string> ids;
  if (parts.size() < 3) return reject(parts[0], "two stations and a height difference");
  if (!names(parts[1], 2, ids)) return;
  Observation o;
  o.kind = height_difference;
  o.instrument = instrument_;
  o.from = ids[0];
  o.to = ids[1];
  o.source = builder_.at(line_, 1);
  const auto value = text::parse_number(parts[2]);
  if (!value || o.from == o.to) return reject(parts[2], "a height difference");
  if (!ends_at(parts, 5, "L has two stations, a height difference, a length and a standard deviation")) return;
  o.value = *value * metres_;
  if (parts.size() > 3) {
    const auto length = text::parse_number(parts[3]);
    if (!length || *length <= 0) return reject(parts[3], "the length of the line");
    const bool is_sigma = parts.size() == 4 && *length * metres_ < 1;
    if (is_sigma)
      builder_.warn("line " + std::to_string(line_) + ": " + std::string(parts[3]) +
                    " is no length of a levelled line; it is taken as its standard deviation");
    (is_sigma ? o.sigma : o.levelling_length) = *length * metres_;
  }
  if (parts.size() > 4) {
    const auto sigma = sigma_of(parts[4], height_difference);
    if (!sigma) return reject(parts[4], "a standard deviation above zero, '&', '!' or '*'");
    if (*sigma == 0) return;
    o.sigma = *sigma;
  }
  if (std::isnan(o.sigma) && !std::isnan(level_weight_) && !std::isnan(o.levelling_length))
    o.sigma = level_weight_ * std::sqrt(o.levelling_length / 1000);
  builder_.add(std::move(o));
}

}  // namespace plumbline::survey
