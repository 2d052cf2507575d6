// Clusters of observations of a gama-local file: values, standard deviations, covariances.
#include <algorithm>
#include <cmath>
#include <map>

#include "base/text/text.hpp"
#include "plumbline/stop.hpp"
#include "survey/files/gama.hpp"
#include "survey/files/gama_reader.hpp"

namespace plumbline::survey {

namespace gama {

using text::attribute;
using text::parse_number;

namespace {
constexpr int kLargestCluster = 5000;  // observations under one matrix of 200 MB; survey files have a few hundred
}

bool GamaReader::read_angle(pugi::xml_node node, double& value, double& unit) {
  const std::string text = attribute(node, "val");
  if (parse_degrees_minutes_seconds(text, value)) {
    unit = kArcsecond;
    return true;
  }
  const auto gon = parse_number(text);
  if (!gon) {
    skip(node, "val=\"" + text + "\"", "an angle in gon or d-m-s");
    return false;
  }
  value = *gon * kGon;
  unit = kCc;
  return true;
}

bool GamaReader::read_length(pugi::xml_node node, double& value) {
  const auto metres = parse_number(attribute(node, "val"));
  if (metres)
    value = *metres;
  else
    skip(node, "val=\"" + attribute(node, "val") + "\"", "a length in metres");
  return metres.has_value();
}

double GamaReader::default_distance_sigma(double length) const {
  if (distance_model_.empty()) return kNotGiven;
  const double b = distance_model_.size() > 1 ? distance_model_[1] : 0;
  const double c = distance_model_.size() > 2 ? distance_model_[2] : 1;
  return distance_model_[0] + b * std::pow(length / 1000, c);
}

void GamaReader::read_observations(pugi::xml_node cluster) {
  const std::string from = attribute(cluster, "from");
  const double height = number(cluster, "from_dh", kNotGiven);
  int set_up = -1;
  if (!from.empty()) set_up = builder_.start_set_up(from, height, xml_.position(cluster));
  std::vector<ClusterItem> items;
  for (pugi::xml_node node = cluster.first_child(); node; node = node.next_sibling()) {
    if (node.type() != pugi::node_element || text::local_name(node) == "cov-mat") continue;
    items.push_back(read_observation(node, from, set_up));
  }
  finish_cluster(cluster, items);
}

ClusterItem GamaReader::read_observation(pugi::xml_node node, const std::string& cluster_from, int set_up) {
  static const std::map<std::string_view, ObservationKind> kinds = {
      {"direction", ObservationKind::direction},  {"distance", ObservationKind::horizontal_distance},
      {"angle", ObservationKind::angle},          {"s-distance", ObservationKind::slope_distance},
      {"z-angle", ObservationKind::zenith_angle}, {"azimuth", ObservationKind::azimuth},
      {"dh", ObservationKind::height_difference},
  };
  const auto name = text::local_name(node);
  const auto kind = kinds.find(name);
  if (kind == kinds.end()) {
    skip(node, "<" + std::string(name) + ">", "direction, distance, angle, s-distance, z-angle, azimuth or dh");
    return {};
  }
  Observation o;
  o.kind = kind->second;
  o.from = attribute(node, "from");
  if (o.from.empty()) o.from = cluster_from;
  o.to = attribute(node, o.kind == ObservationKind::angle ? "bs" : "to");
  if (o.kind == ObservationKind::angle) o.second_to = attribute(node, "fs");
  o.set_up = o.from == cluster_from ? set_up : -1;
  o.source = xml_.position(node);
  if (o.from.empty() || o.to.empty() || (o.kind == ObservationKind::angle && o.second_to.empty())) {
    skip(node, "<" + std::string(name) + "> without its points", "from, and to (angles: bs and fs)");
    return {};
  }
  if (o.kind == ObservationKind::direction && o.set_up < 0) {
    skip(node, "a direction from another point than its set", "<obs from=\"" + o.from + "\">");
    return {};
  }
  o.instrument_height = number(node, "from_dh", kNotGiven);
  o.target_height = number(node, o.kind == ObservationKind::angle ? "bs_dh" : "to_dh", kNotGiven);
  o.second_target_height = number(node, "fs_dh", kNotGiven);
  return add(node, std::move(o));
}

ClusterItem GamaReader::add(pugi::xml_node node, Observation o) {
  ClusterItem item;
  double sigma = kNotGiven;
  switch (o.kind) {
    case ObservationKind::slope_distance:
    case ObservationKind::horizontal_distance:
      if (!read_length(node, o.value)) return {};
      if (!(o.value > 0)) {
        skip(node, "a distance of " + attribute(node, "val") + " m", "a positive length");
        return {};
      }
      sigma = default_distance_sigma(o.value);
      break;
    case ObservationKind::height_difference: {
      if (!read_length(node, o.value)) return {};
      const double kilometres = number(node, "dist", kNotGiven);
      if (!std::isnan(kilometres)) {
        o.levelling_length = kilometres * 1000;
        sigma = builder_.survey.info.a_priori_sigma0 * std::sqrt(kilometres);
      }
      break;
    }
    default:
      if (!read_angle(node, o.value, item.sigma_unit)) return {};
      sigma = o.kind == ObservationKind::direction      ? direction_sigma_
              : o.kind == ObservationKind::zenith_angle ? zenith_sigma_
              : o.kind == ObservationKind::azimuth      ? azimuth_sigma_
                                                        : angle_sigma_;
      if (o.kind != ObservationKind::zenith_angle) item.sense = sense_;
  }
  o.value *= item.sense;
  o.sigma = number(node, "stdev", sigma) * item.sigma_unit;
  item.observation = static_cast<int>(builder_.survey.observations.size());
  ensure_points({o.from, o.to, o.second_to}, o.source);
  stop_point();
  builder_.survey.observations.push_back(std::move(o));
  return item;
}

Eigen::MatrixXd GamaReader::read_covariance(pugi::xml_node cluster, int size) {
  const auto node = text::child(cluster, "cov-mat");
  if (!node) return {};
  const double dimension = number(node, "dim", -1), band = number(node, "band", -1);
  const auto tokens = text::split_blanks(node.text().get());
  const std::string expected = "cov-mat of dimension " + std::to_string(size) + " (at most " +
                               std::to_string(kLargestCluster) + ") with its upper band by rows";
  if (dimension != size || size > kLargestCluster || !(band >= 0 && band < std::max(1, size))) {
    skip(node, "cov-mat dim=\"" + attribute(node, "dim") + "\" band=\"" + attribute(node, "band") + "\"", expected);
    return {};
  }
  Eigen::MatrixXd covariance = Eigen::MatrixXd::Zero(size, size);
  size_t k = 0;
  for (int i = 0; i < size; ++i)
    for (int j = i; j < size && j <= i + band; ++j, ++k) {
      const auto value = k < tokens.size() ? parse_number(tokens[k]) : std::nullopt;
      if (!value) {
        skip(node, "cov-mat with " + std::to_string(tokens.size()) + " elements", expected);
        return {};
      }
      covariance(i, j) = covariance(j, i) = *value;
    }
  return covariance;
}

void GamaReader::finish_cluster(pugi::xml_node cluster, const std::vector<ClusterItem>& items) {
  const int size = static_cast<int>(items.size());
  const Eigen::MatrixXd given = read_covariance(cluster, size);
  auto& observations = builder_.survey.observations;
  if (given.size() > 0) {
    ObservationCovariance covariance;
    std::vector<int> kept;
    Eigen::VectorXd units(size);
    for (int i = 0; i < size; ++i) {
      units[i] = items[i].sigma_unit * items[i].sense;
      if (items[i].observation < 0) continue;
      covariance.indices.push_back(items[i].observation);
      kept.push_back(i);
      observations[items[i].observation].sigma = std::abs(units[i]) * std::sqrt(given(i, i));
    }
    const Eigen::MatrixXd scaled = units.asDiagonal() * given * units.asDiagonal();
    covariance.covariance = scaled(kept, kept);
    const bool diagonal = given.isDiagonal(0);
    if (!kept.empty() && !diagonal) builder_.survey.covariances.push_back(std::move(covariance));
  }
  for (auto item = items.rbegin(); item != items.rend(); ++item) {
    if (item->observation < 0 || observations[item->observation].sigma > 0) continue;
    const Observation& o = observations[item->observation];
    builder_.skip(o.source.line, o.source.column, "an observation without standard deviation",
                  "stdev, a cov-mat, or a default in <points-observations>");
    if (given.size() == 0) observations.erase(observations.begin() + item->observation);
  }
}

void GamaReader::read_height_differences(pugi::xml_node cluster) {
  std::vector<ClusterItem> items;
  for (pugi::xml_node node = cluster.first_child(); node; node = node.next_sibling()) {
    if (node.type() != pugi::node_element || text::local_name(node) == "cov-mat") continue;
    items.push_back(read_observation(node, "", -1));
  }
  finish_cluster(cluster, items);
}

}  // namespace gama

bool parse_degrees_minutes_seconds(std::string_view text, double& radians) {
  text = text::trim(text);
  double sign = 1;
  if (!text.empty() && (text.front() == '-' || text.front() == '+')) {
    sign = text.front() == '-' ? -1 : 1;
    text.remove_prefix(1);
  }
  const auto parts = text::split(text, '-');
  if (parts.size() != 3) return false;
  double value[3];
  for (int k = 0; k < 3; ++k) {
    const auto number = text::parse_number(parts[k]);
    if (!number || *number < 0 || (k > 0 && *number > 60)) return false;  // rounded programs write 60.00
    value[k] = *number;
  }
  radians = sign * (value[0] + value[1] / 60 + value[2] / 3600) * std::numbers::pi / 180;
  return true;
}

}  // namespace plumbline::survey
