#include "survey/files/gama_reader.hpp"

#include <Eigen/LU>
#include <cmath>
#include <map>

#include "base/text/text.hpp"
#include "survey/files/gama.hpp"

namespace plumbline::survey {

namespace gama {

using text::attribute;
using text::parse_number;

SurveyObservations GamaReader::read() {
  const auto root = xml_.root();
  const auto root_name = text::local_name(root);
  if (root_name == "gnu-gama-data") return read_g3(xml_, file_);
  const auto network = text::child(root, "network");
  if ((root_name != "gama-local" && root_name != "gama-xml") || !network)
    throw SurveyReadError(xml_.position(root), "an XML file with root <" + std::string(root_name) + ">",
                          "<gama-local> with a <network>, or <gnu-gama-data> with a <g3-model>");
  if (xml_.damage()) builder_.survey.skipped.push_back(*xml_.damage());
  skip_unknown_attributes();
  read_network(network);
  const auto parameters = text::child(network, "parameters");
  read_parameters(parameters);
  for (const auto& block : text::children(network, "points-observations")) read_block(block);
  using R = CoordinateRole;
  for (Point& p : builder_.survey.points)
    if (!declared_.contains(p.id)) p.roles = {R::unused, R::unused, R::unused};
  SurveyObservations survey =
      builder_.finish("a gama-local network without points and observations", "<point> and <obs> elements");
  check_fixed_points(survey);
  return survey;
}

void GamaReader::skip(pugi::xml_node node, const std::string& found, const std::string& expected) {
  const SourcePosition at = xml_.position(node);
  builder_.skip(at.line, at.column, found, expected);
}

// Attributes of gama-local.xsd (gama 2.33), and those that older files have.
void GamaReader::skip_unknown_attributes() {
  using Names = std::set<std::string_view>;
  static const std::map<std::string_view, Names> known = {
      {"network", {"axes-xy", "angles", "epoch"}},
      {"parameters",
       {"sigma-apr", "conf-pr", "tol-abs", "sigma-act", "algorithm", "language", "encoding", "angular", "angles",
        "latitude", "ellipsoid", "cov-band", "iterations", "update-constrained-coordinates"}},
      {"points-observations",
       {"distance-stdev", "direction-stdev", "angle-stdev", "zenith-angle-stdev", "azimuth-stdev"}},
      {"point", {"id", "x", "y", "z", "fix", "adj", "extern"}},
      {"obs", {"from", "from_dh", "orientation"}},
      {"direction", {"from", "to", "val", "stdev", "from_dh", "to_dh", "extern"}},
      {"distance", {"from", "to", "val", "stdev", "from_dh", "to_dh", "extern"}},
      {"s-distance", {"from", "to", "val", "stdev", "from_dh", "to_dh", "extern"}},
      {"z-angle", {"from", "to", "val", "stdev", "from_dh", "to_dh", "extern"}},
      {"azimuth", {"from", "to", "val", "stdev", "from_dh", "to_dh", "extern"}},
      {"angle", {"from", "bs", "fs", "val", "stdev", "from_dh", "bs_dh", "fs_dh", "extern"}},
      {"dh", {"from", "to", "val", "stdev", "dist", "extern"}},
      {"vec", {"from", "to", "dx", "dy", "dz", "from_dh", "to_dh", "extern"}},
      {"cov-mat", {"dim", "band"}},
      {"coordinates", {"extern"}},
      {"height-differences", {}},
      {"vectors", {}}};
  for (pugi::xml_node node :
       text::descendants(xml_.root(), {"network", "parameters", "points-observations", "point", "obs", "direction",
                                       "distance", "s-distance", "z-angle", "azimuth", "angle", "dh", "vec", "cov-mat",
                                       "coordinates", "height-differences", "vectors"}))
    for (const pugi::xml_attribute a : node.attributes())
      if (const std::string_view name = a.name();
          !known.at(text::local_name(node)).contains(name) && !name.starts_with("xml"))
        skip(node, std::string(name) + "=\"" + a.value() + "\"",
             "an attribute of <" + std::string(text::local_name(node)) + "> that gama-local defines");
}

void GamaReader::read_network(pugi::xml_node network) {
  NetworkInfo& info = builder_.survey.info;
  std::string axes = attribute(network, "axes-xy");
  if (axes.empty()) axes = "ne";
  static const std::map<char, Eigen::Vector2d> directions = {
      {'e', {1, 0}}, {'n', {0, 1}}, {'w', {-1, 0}}, {'s', {0, -1}}};
  if (axes.size() != 2 || !directions.contains(axes[0]) || !directions.contains(axes[1]) ||
      std::abs(directions.at(axes[0]).dot(directions.at(axes[1]))) > 0.5)
    throw SurveyReadError(xml_.position(network), "axes-xy=\"" + axes + "\"", "one of ne, sw, es, wn, en, nw, se, ws");
  axes_.col(0) = directions.at(axes[0]);
  axes_.col(1) = directions.at(axes[1]);
  const std::string angles = attribute(network, "angles");
  if (!angles.empty() && angles != "left-handed" && angles != "right-handed")
    throw SurveyReadError(xml_.position(network), "angles=\"" + angles + "\"", "left-handed or right-handed");
  info.axes_xy = axes;
  info.angles_right_handed = angles == "right-handed";
  info.axes_inconsistent = info.angles_right_handed != (axes_.determinant() > 0);
  sense_ = info.angles_right_handed ? -1 : 1;
  info.description = text::child_text(network, "description");
  info.title = info.description.substr(0, info.description.find('\n'));
}

void GamaReader::read_parameters(pugi::xml_node node) {
  NetworkInfo& info = builder_.survey.info;
  info.a_priori_sigma0 = number(node, "sigma-apr", 10.0);
  info.largest_misclosure = number(node, "tol-abs", 1000.0) * kMillimetre;
  if (!(info.largest_misclosure > 0)) {
    skip(node, "tol-abs=\"" + attribute(node, "tol-abs") + "\"", "a length above zero [mm]");
    info.largest_misclosure = 1.0;
  }
  info.confidence_level = number(node, "conf-pr", 0.95);
  const std::string used = attribute(node, "sigma-act");
  info.use_a_posteriori_sigma0 = used != "apriori";
  std::string unit = attribute(node, "angular");
  if (unit.empty()) unit = attribute(node, "angles");
  info.angles_in_degrees = unit == "360";
}

double GamaReader::number(pugi::xml_node node, const char* name, double fallback) {
  const std::string text = attribute(node, name);
  if (text.empty()) return fallback;
  if (const auto value = parse_number(text)) return *value;
  skip(node, std::string(name) + "=\"" + text + "\"", "a number");
  return fallback;
}

void GamaReader::read_block(pugi::xml_node block) {
  direction_sigma_ = number(block, "direction-stdev", kNotGiven);
  angle_sigma_ = number(block, "angle-stdev", kNotGiven);
  zenith_sigma_ = number(block, "zenith-angle-stdev", kNotGiven);
  azimuth_sigma_ = number(block, "azimuth-stdev", kNotGiven);
  distance_model_.clear();
  const std::string model = attribute(block, "distance-stdev");
  for (const auto& token : text::split_blanks(model)) {
    const auto value = parse_number(token);
    if (value && *value >= 0)
      distance_model_.push_back(*value);
    else
      skip(block, "distance-stdev=\"" + model + "\"", "up to three numbers that are not negative");
  }
  for (pugi::xml_node node = block.first_child(); node; node = node.next_sibling()) {
    if (node.type() != pugi::node_element) continue;
    const auto name = text::local_name(node);
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

void GamaReader::read_point(pugi::xml_node node) {
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

void GamaReader::set_role(Point& point, char axis, CoordinateRole role, pugi::xml_node node) {
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

void GamaReader::ensure_points(std::initializer_list<std::string> ids, const SourcePosition& source) {
  for (const std::string& id : ids) {
    if (id.empty() || builder_.has_point(id)) continue;
    builder_.point(id, source);
  }
}

void GamaReader::read_coordinates(pugi::xml_node cluster) {
  struct Row {
    std::string point;
    double x, y, z;
  };
  std::vector<Row> rows;
  int size = 0;
  for (const auto& node : text::children(cluster, "point")) {
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

void GamaReader::read_vectors(pugi::xml_node cluster) {
  VectorGroup group;
  group.source = xml_.position(cluster);
  std::vector<double> values;
  for (const auto& node : text::children(cluster, "vec")) {
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

void GamaReader::check_fixed_points(const SurveyObservations& survey) const {
  for (const Point& p : survey.points)
    for (int k = 0; k < 3; ++k)
      if (p.roles[k] == CoordinateRole::fixed && std::isnan(p.coordinates[k]))
        throw SurveyReadError(p.source, "fixed point '" + p.id + "' without coordinate " + "xyz"[k],
                              "coordinates of every fixed point");
}

}  // namespace gama

SurveyObservations read_gama_xml(std::string_view bytes, const std::string& file) {
  return gama::GamaReader(bytes, file).read();
}

}  // namespace plumbline::survey
