#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <map>
#include <numbers>
#include <set>

#include "formats/gama.hpp"
#include "formats/survey_builder.hpp"
#include "formats/text.hpp"
#include "formats/xml_file.hpp"

namespace plumbline::survey {

namespace {

using formats::attribute;
using formats::parse_number;

constexpr double kGon = std::numbers::pi / 200;
constexpr double kCc = kGon * 1e-4;
constexpr double kArcsecond = std::numbers::pi / 180 / 3600;
constexpr double kMillimetre = 1e-3;

/// One observation while its cluster is read: the unit of its standard deviation decides how the cov-mat is scaled.
struct ClusterItem {
  int observation = -1;
  double sigma_unit = kMillimetre;
  double sense = 1;  // -1: the sign of the value was changed
};

class GamaReader {
 public:
  GamaReader(std::string_view bytes, const std::string& file)
      : xml_(bytes, file, {"obs", "point", "height-differences", "coordinates", "vectors"}),
        builder_(file, "gama-xml"),
        file_(file) {}

  SurveyObservations read() {
    const auto root = xml_.root();
    const auto root_name = formats::local_name(root);
    const auto network = formats::child(root, "network");
    if ((root_name != "gama-local" && root_name != "gama-xml") || !network)
      throw SurveyReadError(xml_.position(root), "an XML file with root <" + std::string(root_name) + ">",
                            "<gama-local> with a <network>");
    if (xml_.damage()) builder_.survey.skipped.push_back(*xml_.damage());
    read_network(network);
    const auto parameters = formats::child(network, "parameters");
    read_parameters(parameters);
    for (const auto& block : formats::children(network, "points-observations")) read_block(block);
    using R = CoordinateRole;
    for (Point& p : builder_.survey.points)
      if (!declared_.contains(p.id)) p.roles = {R::unused, R::unused, R::unused};
    SurveyObservations survey =
        builder_.finish("a gama-local network without points and observations", "<point> and <obs> elements");
    check_fixed_points(survey);
    return survey;
  }

 private:
  void skip(pugi::xml_node node, const std::string& found, const std::string& expected) {
    const SourcePosition at = xml_.position(node);
    builder_.skip(at.line, at.column, found, expected);
  }

  void read_network(pugi::xml_node network) {
    NetworkInfo& info = builder_.survey.info;
    std::string axes = attribute(network, "axes-xy");
    if (axes.empty()) axes = "ne";
    static const std::map<char, Eigen::Vector2d> directions = {
        {'e', {1, 0}}, {'n', {0, 1}}, {'w', {-1, 0}}, {'s', {0, -1}}};
    if (axes.size() != 2 || !directions.contains(axes[0]) || !directions.contains(axes[1]) ||
        std::abs(directions.at(axes[0]).dot(directions.at(axes[1]))) > 0.5)
      throw SurveyReadError(xml_.position(network), "axes-xy=\"" + axes + "\"",
                            "one of ne, sw, es, wn, en, nw, se, ws");
    axes_.col(0) = directions.at(axes[0]);
    axes_.col(1) = directions.at(axes[1]);
    const std::string angles = attribute(network, "angles");
    if (!angles.empty() && angles != "left-handed" && angles != "right-handed")
      throw SurveyReadError(xml_.position(network), "angles=\"" + angles + "\"", "left-handed or right-handed");
    info.axes_xy = axes;
    info.angles_right_handed = angles == "right-handed";
    info.axes_inconsistent = info.angles_right_handed != (axes_.determinant() > 0);
    sense_ = info.angles_right_handed ? -1 : 1;
    info.description = formats::child_text(network, "description");
    info.title = info.description.substr(0, info.description.find('\n'));
  }

  void read_parameters(pugi::xml_node node) {
    NetworkInfo& info = builder_.survey.info;
    info.a_priori_sigma0 = number(node, "sigma-apr", 10.0);
    info.confidence_level = number(node, "conf-pr", 0.95);
    const std::string used = attribute(node, "sigma-act");
    info.use_a_posteriori_sigma0 = used != "apriori";
    std::string unit = attribute(node, "angular");
    if (unit.empty()) unit = attribute(node, "angles");
    info.angles_in_degrees = unit == "360";
  }

  /// A number of an attribute; `fallback` where it is missing, and where it is no number (which is listed).
  double number(pugi::xml_node node, const char* name, double fallback) {
    const std::string text = attribute(node, name);
    if (text.empty()) return fallback;
    if (const auto value = parse_number(text)) return *value;
    skip(node, std::string(name) + "=\"" + text + "\"", "a number");
    return fallback;
  }

  void read_block(pugi::xml_node block) {
    direction_sigma_ = number(block, "direction-stdev", kNotGiven);
    angle_sigma_ = number(block, "angle-stdev", kNotGiven);
    zenith_sigma_ = number(block, "zenith-angle-stdev", kNotGiven);
    azimuth_sigma_ = number(block, "azimuth-stdev", kNotGiven);
    distance_model_.clear();
    for (const auto& token : formats::split_blanks(attribute(block, "distance-stdev"))) {
      const auto value = parse_number(token);
      if (value)
        distance_model_.push_back(*value);
      else
        skip(block, "distance-stdev=\"" + attribute(block, "distance-stdev") + "\"", "up to three numbers");
    }
    for (pugi::xml_node node = block.first_child(); node; node = node.next_sibling()) {
      if (node.type() != pugi::node_element) continue;
      const auto name = formats::local_name(node);
      if (name == "point")
        read_point(node);
      else if (name == "obs")
        read_observations(node);
      else if (name == "height-differences")
        read_height_differences(node);
      else if (name == "coordinates")
        read_coordinates(node);
      else if (name == "vectors")
        read_vectors(node);
      else
        skip(node, "<" + std::string(name) + ">", "point, obs, height-differences, coordinates or vectors");
    }
  }

  Eigen::Vector2d to_frame(double x, double y) const { return axes_ * Eigen::Vector2d(x, y); }

  void read_point(pugi::xml_node node) {
    const std::string id = attribute(node, "id");
    if (id.empty()) return skip(node, "<point> without id", "<point id=\"...\">");
    Point& point = builder_.point(id, xml_.position(node));
    declared_.insert(id);
    const double x = number(node, "x", kNotGiven), y = number(node, "y", kNotGiven);
    if (!std::isnan(x) && !std::isnan(y)) point.coordinates.head<2>() = to_frame(x, y);
    const double z = number(node, "z", kNotGiven);
    if (!std::isnan(z)) point.coordinates.z() = z;
    using R = CoordinateRole;
    // A point may come twice, once with coordinates and once with its role: roles only change where an attribute
    // stands.
    if (!with_role_.contains(id)) point.roles = {R::unused, R::unused, R::unused};
    const std::string adj = attribute(node, "adj"), fix = attribute(node, "fix");
    if (adj.empty() && fix.empty()) return;
    with_role_.insert(id);
    for (char c : adj) set_role(point, c, c >= 'A' && c <= 'Z' ? R::constrained : R::free, node);
    for (char c : fix) set_role(point, c, R::fixed, node);
  }

  void set_role(Point& point, char axis, CoordinateRole role, pugi::xml_node node) {
    switch (axis) {
      case 'x':
      case 'y':
      case 'X':
      case 'Y':
        point.roles[0] = point.roles[1] = role;  // the axes of the file may be turned, the pair may not be split
        break;
      case 'z':
      case 'Z':
        point.roles[2] = role;
        break;
      default:
        skip(node, std::string("axis '") + axis + "'", "x, y, z or X, Y, Z in fix and adj");
    }
  }

  /// Value of an angle [rad] and the unit of its standard deviation [rad].
  bool read_angle(pugi::xml_node node, double& value, double& unit) {
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

  bool read_length(pugi::xml_node node, double& value) {
    const auto metres = parse_number(attribute(node, "val"));
    if (metres)
      value = *metres;
    else
      skip(node, "val=\"" + attribute(node, "val") + "\"", "a length in metres");
    return metres.has_value();
  }

  /// a + b D^c mm with D in km; b and c default to 0 and 1.
  double default_distance_sigma(double length) const {
    if (distance_model_.empty()) return kNotGiven;
    const double b = distance_model_.size() > 1 ? distance_model_[1] : 0;
    const double c = distance_model_.size() > 2 ? distance_model_[2] : 1;
    return distance_model_[0] + b * std::pow(length / 1000, c);
  }

  void read_observations(pugi::xml_node cluster) {
    const std::string from = attribute(cluster, "from");
    const double height = number(cluster, "from_dh", kNotGiven);
    int set_up = -1;
    if (!from.empty()) set_up = builder_.start_set_up(from, height, xml_.position(cluster));
    std::vector<ClusterItem> items;
    for (pugi::xml_node node = cluster.first_child(); node; node = node.next_sibling()) {
      if (node.type() != pugi::node_element || formats::local_name(node) == "cov-mat") continue;
      items.push_back(read_observation(node, from, set_up));
    }
    finish_cluster(cluster, items);
  }

  ClusterItem read_observation(pugi::xml_node node, const std::string& cluster_from, int set_up) {
    static const std::map<std::string_view, ObservationKind> kinds = {
        {"direction", ObservationKind::direction},  {"distance", ObservationKind::horizontal_distance},
        {"angle", ObservationKind::angle},          {"s-distance", ObservationKind::slope_distance},
        {"z-angle", ObservationKind::zenith_angle}, {"azimuth", ObservationKind::azimuth},
        {"dh", ObservationKind::height_difference},
    };
    const auto name = formats::local_name(node);
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

  /// Value and standard deviation by kind, then into the survey.
  ClusterItem add(pugi::xml_node node, Observation o) {
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
    builder_.survey.observations.push_back(std::move(o));
    return item;
  }

  /// Points that no <point> declares are not part of the network.
  void ensure_points(std::initializer_list<std::string> ids, const SourcePosition& source) {
    for (const std::string& id : ids) {
      if (id.empty() || builder_.has_point(id)) continue;
      builder_.point(id, source);
    }
  }

  /// Upper band by rows, as the file writes it, n x n in its own units; empty if absent or wrong.
  Eigen::MatrixXd read_covariance(pugi::xml_node cluster, int size) {
    const auto node = formats::child(cluster, "cov-mat");
    if (!node) return {};
    const int dimension = static_cast<int>(number(node, "dim", -1)), band = static_cast<int>(number(node, "band", -1));
    const auto tokens = formats::split_blanks(node.text().get());
    const std::string expected = "cov-mat of dimension " + std::to_string(size) + " with its upper band by rows";
    if (dimension != size || band < 0 || band >= std::max(1, dimension)) {
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

  /// Covariances replace standard deviations; what then has none is not usable and leaves the survey.
  void finish_cluster(pugi::xml_node cluster, const std::vector<ClusterItem>& items) {
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

  void read_height_differences(pugi::xml_node cluster) {
    std::vector<ClusterItem> items;
    for (pugi::xml_node node = cluster.first_child(); node; node = node.next_sibling()) {
      if (node.type() != pugi::node_element || formats::local_name(node) == "cov-mat") continue;
      items.push_back(read_observation(node, "", -1));
    }
    finish_cluster(cluster, items);
  }

  void read_coordinates(pugi::xml_node cluster) {
    struct Row {
      std::string point;
      double x, y, z;
    };
    std::vector<Row> rows;
    int size = 0;
    for (const auto& node : formats::children(cluster, "point")) {
      const Row row{attribute(node, "id"), number(node, "x", kNotGiven), number(node, "y", kNotGiven),
                    number(node, "z", kNotGiven)};
      if (row.point.empty() || std::isnan(row.x) != std::isnan(row.y))
        return skip(node, "observed coordinates without id, or with one of x and y only", "id, x and y, or z");
      // A role here declares the point, with the observed coordinates as approximate ones.
      if (!attribute(node, "adj").empty() || !attribute(node, "fix").empty())
        read_point(node);
      else
        ensure_points({row.point}, xml_.position(node));
      rows.push_back(row);
      size += (std::isnan(row.x) ? 0 : 2) + (std::isnan(row.z) ? 0 : 1);
    }
    const Eigen::MatrixXd given = read_covariance(cluster, size);
    if (given.size() == 0) return skip(cluster, "observed coordinates without cov-mat", "a cov-mat");
    CoordinateGroup group;
    group.source = xml_.position(cluster);
    Eigen::MatrixXd turn = Eigen::MatrixXd::Identity(size, size);
    Eigen::VectorXd values(size);
    int k = 0;
    for (const Row& row : rows) {
      if (!std::isnan(row.x)) {
        group.components.push_back({row.point, 0});
        group.components.push_back({row.point, 1});
        values.segment<2>(k) << row.x, row.y;
        turn.block<2, 2>(k, k) = axes_;
        k += 2;
      }
      if (std::isnan(row.z)) continue;
      group.components.push_back({row.point, 2});
      values[k++] = row.z;
    }
    group.values = turn * values;
    group.covariance = kMillimetre * kMillimetre * turn * given * turn.transpose();
    builder_.survey.coordinates.push_back(std::move(group));
  }

  void read_vectors(pugi::xml_node cluster) {
    VectorGroup group;
    group.source = xml_.position(cluster);
    std::vector<double> values;
    for (const auto& node : formats::children(cluster, "vec")) {
      VectorGroup::Vector v{attribute(node, "from"), attribute(node, "to"), number(node, "from_dh", 0),
                            number(node, "to_dh", 0)};
      for (const char* name : {"dx", "dy", "dz"}) values.push_back(number(node, name, kNotGiven));
      if (v.from.empty() || v.to.empty() || std::isnan(values.back() + values.end()[-2] + values.end()[-3]))
        return skip(node, "<vec> without its points or components", "from, to, dx, dy and dz");
      ensure_points({v.from, v.to}, xml_.position(node));
      group.vectors.push_back(std::move(v));
    }
    const int size = static_cast<int>(values.size());
    const Eigen::MatrixXd given = read_covariance(cluster, size);
    if (given.size() == 0) return skip(cluster, "vectors without cov-mat", "a cov-mat");
    Eigen::MatrixXd turn = Eigen::MatrixXd::Identity(size, size);
    for (int k = 0; k < size; k += 3) turn.block<2, 2>(k, k) = axes_;
    group.values = turn * Eigen::Map<const Eigen::VectorXd>(values.data(), size);
    group.covariance = kMillimetre * kMillimetre * turn * given * turn.transpose();
    builder_.survey.vectors.push_back(std::move(group));
  }

  void check_fixed_points(const SurveyObservations& survey) const {
    for (const Point& p : survey.points)
      for (int k = 0; k < 3; ++k)
        if (p.roles[static_cast<size_t>(k)] == CoordinateRole::fixed && std::isnan(p.coordinates[k]))
          throw SurveyReadError(p.source, "fixed point '" + p.id + "' without coordinate " + "xyz"[k],
                                "coordinates of every fixed point");
  }

  formats::XmlFile xml_;
  SurveyBuilder builder_;
  std::string file_;
  Eigen::Matrix2d axes_ = Eigen::Matrix2d::Identity();  // E, N of the file's x and y
  double sense_ = 1;
  double direction_sigma_ = kNotGiven, angle_sigma_ = kNotGiven, zenith_sigma_ = kNotGiven, azimuth_sigma_ = kNotGiven;
  std::vector<double> distance_model_;
  std::set<std::string> with_role_, declared_;
};

}  // namespace

bool parse_degrees_minutes_seconds(std::string_view text, double& radians) {
  text = formats::trim(text);
  double sign = 1;
  if (!text.empty() && (text.front() == '-' || text.front() == '+')) {
    sign = text.front() == '-' ? -1 : 1;
    text.remove_prefix(1);
  }
  const auto parts = formats::split(text, '-');
  if (parts.size() != 3) return false;
  double value[3];
  for (int k = 0; k < 3; ++k) {
    const auto number = parse_number(parts[static_cast<size_t>(k)]);
    if (!number || *number < 0 || (k > 0 && *number > 60)) return false;  // rounded programs write 60.00
    value[k] = *number;
  }
  radians = sign * (value[0] + value[1] / 60 + value[2] / 3600) * std::numbers::pi / 180;
  return true;
}

SurveyObservations read_gama_xml(std::string_view bytes, const std::string& file) {
  return GamaReader(bytes, file).read();
}

}  // namespace plumbline::survey
