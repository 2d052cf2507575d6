// What a common error is called: its size, what to check, and which of the usual mistakes has that size.
#include <algorithm>
#include <cmath>
#include <numbers>

#include "survey/adjust/adjuster.hpp"
#include "survey/words/network_words.hpp"

namespace plumbline::survey {

namespace {

/// Differences between the constants of common reflectors [mm], for a hint.
const char* known_difference(double millimetres, double sigma) {
  const auto near = [&](double value) { return std::abs(std::abs(millimetres) - value) < std::max(0.3, 3 * sigma); };
  if (sigma > 1.0) return "";
  if (near(34.4)) return " (34.4 mm lie between a round prism and measuring without reflector)";
  if (near(23.1)) return " (23.1 mm lie between a round and a 360 degree prism)";
  if (near(17.5)) return " (17.5 mm lie between a round and a mini prism)";
  return "";
}

/// A height that was noted in feet and read as metres.
const char* noted_in_feet(double noted, double too_large) {
  constexpr double kFeet = 1 / 0.3048, kClose = 0.01;
  const double true_height = noted - too_large;
  return true_height > 0 && std::abs(noted / true_height / kFeet - 1) < kClose ? " (it looks noted in feet)" : "";
}

std::vector<Eigen::Vector3d> known_places(const NetworkModel& m) {
  std::vector<Eigen::Vector3d> places;
  for (size_t i = 0; i < m.ids.size(); ++i)
    if (m.roles[i][0] != CoordinateRole::unused) places.push_back(m.initial[i]);
  return m.datum == DatumMode::inner ? std::vector<Eigen::Vector3d>{} : places;
}

/// Of the distances, by the map.
double mean_map_scale(const NetworkModel& m) {
  double sum = 0, count = 0;
  for (size_t i = 0; i < m.corrections.size(); ++i)
    if (group_of(m.observations[i].observation.kind) == kDistances && !m.dropped[i])
      sum += m.corrections[i].scale, ++count;
  return count > 0 ? sum / count : 1;
}

/// Distances that somebody has brought to the map already are too short by the map's scale a second time. Else the
/// scale that the readings have may be that of another map.
std::string beside_the_map(const NetworkModel& m, double size, double sigma) {
  constexpr double kClose = 1.5e-5;  // heights of the geoid, a wide site
  const double scale = mean_map_scale(m);
  if (std::abs(size - (scale - 1)) > std::max(kClose, 3 * sigma))
    return "check the ppm setting, the unit, and the map: its scale here is " + fixed_digits(scale, 6) +
           ", by the readings it would be " + fixed_digits(scale / (1 + size), 6);
  return "they look as if they had been reduced to the map already (its scale here is " + fixed_digits(scale, 6) +
         "): switch that off in the instrument or its export, or leave out map";
}

}  // namespace

std::string Adjuster::describe(const CommonError& e) const {
  const std::string owner = e.set_up < 0 ? "" : " of set-up " + m_.survey.set_ups[e.set_up].id;
  const std::string all = "all " + std::to_string(e.observations) + " ";
  std::string text;
  switch (e.kind) {
    case CommonError::Kind::constant:
      text = all + "distances" + owner + " look too " + (e.size > 0 ? "long" : "short") + " by " +
             fixed_digits(std::abs(e.size) * 1000, 1) + " mm: check the prism constant" +
             known_difference(e.size * 1000, e.sigma * 1000);
      break;
    case CommonError::Kind::scale:
      text = all + "distances" + owner + " look too " + (e.size > 0 ? "long" : "short") + " by " +
             fixed_digits(std::abs(e.size) * 1e6, 0) + " ppm: ";
      if (e.set_up < 0)
        text += m_.map ? beside_the_map(m_, e.size, e.sigma)
                       : map_that_explains(1 / (1 + e.size), e.sigma, known_places(m_));
      if (text.ends_with(": ")) text += "check the ppm setting and the unit";
      break;
    case CommonError::Kind::index:
      text = all + "zenith angles" + owner + " look wrong by " + fixed_digits(e.size * 200000 / std::numbers::pi, 1) +
             " mgon: check the vertical index, and whether the instrument was level";
      break;
    case CommonError::Kind::height:
      text = "the instrument height" + owner + " looks too " + (e.size > 0 ? "large" : "small") + " by " +
             fixed_digits(std::abs(e.size) * 1000, 1) + " mm: check it, and the point the instrument stood on" +
             noted_in_feet(m_.survey.set_ups[e.set_up].instrument_height, e.size);
      break;
    case CommonError::Kind::target:
      text = "the target height of " + fixed_digits(e.target_height, 3) + " m noted in " +
             std::to_string(e.observations) + " readings" + owner + " looks too " + (e.size > 0 ? "large" : "small") +
             " by " + fixed_digits(std::abs(e.size) * 1000, 1) + " mm: check the length of the pole" +
             noted_in_feet(e.target_height, e.size);
      break;
    case CommonError::Kind::face_index:
    case CommonError::Kind::collimation: {
      const bool index = e.kind == CommonError::Kind::face_index;
      text = all + (index ? "zenith angles" : "directions") + owner + " look wrong by " +
             fixed_digits(e.size * 200000 / std::numbers::pi, 1) +
             " mgon in face 1 and by as much the other way in face 2: the instrument's " +
             (index ? "vertical index" : "collimation") +
             ", which only targets read in both faces are free of; read them so, or determine it in the instrument";
      break;
    }
    case CommonError::Kind::reflector:
      text = std::to_string(e.observations) + " distances " + e.set + " look too " + (e.size > 0 ? "long" : "short") +
             " by " + fixed_digits(std::abs(e.size) * 1000, 1) +
             " mm, the others do not: check which reflector was sighted there, and its constant" +
             known_difference(e.size * 1000, e.sigma * 1000);
      break;
    case CommonError::Kind::tilt:
      text = "the vertical axis" + owner + " looks tilted by " + fixed_digits(e.size * 200000 / std::numbers::pi, 1) +
             " mgon: check its level and compensator, and measure from there again, or estimate the tilt "
             "(network.with.tilt_sigma)";
      break;
    case CommonError::Kind::sink:
      text = "the instrument" + owner + " looks as if it had " + (e.size > 0 ? "sunk" : "risen") + " by " +
             fixed_digits(std::abs(e.size) * 1000, 1) +
             " mm while it was read: check what its tripod stood on, and measure from there again";
      break;
    case CommonError::Kind::twist:
      text = "the circle" + owner + " looks as if it had turned by " +
             fixed_digits(e.size * 200000 / std::numbers::pi, 1) +
             " mgon bit by bit while it was read: check the tripod, and measure from there again";
      break;
    case CommonError::Kind::edge:
      text = "all " + std::to_string(e.observations) + " distances to " + e.set + " look too " +
             (e.size > 0 ? "long" : "short") + " by " + fixed_digits(std::abs(e.size) * 1000, 1) +
             " mm: check its prism; without one the beam passed it, or was sent back from an edge beside it";
      break;
    case CommonError::Kind::circle: {
      const std::string at = place(m_.rows[e.first].source);
      text = "the circle" + owner + " looks turned by " + fixed_digits(e.size * 200000 / std::numbers::pi, 1) +
             " mgon before " + m_.rows[e.first].to + " was sighted" + (at.empty() ? "" : " (" + at + ")");
      break;
    }
  }
  return text + " (w = " + fixed_digits(e.w, 1) + ")";
}

}  // namespace plumbline::survey
