// GNSS baselines (G), clusters of them (X) and of points (Y).
#include <Eigen/Cholesky>
#include <cmath>
#include <map>

#include "survey/files/dynaml_reader.hpp"

namespace plumbline::survey {

using text::child_text;

std::string name_of_dynaml_type(const std::string& type) {
  static const std::map<std::string, std::string> names = {
      {"B", "a geodetic azimuth"},     {"E", "an ellipsoid arc"},        {"G", "a GNSS baseline"},
      {"I", "an astronomic latitude"}, {"J", "an astronomic longitude"}, {"K", "an astronomic azimuth"},
      {"M", "a mean sea level arc"},   {"P", "a geodetic latitude"},     {"Q", "a geodetic longitude"},
      {"R", "an ellipsoidal height"},  {"X", "a GNSS baseline cluster"}, {"Y", "a GNSS point cluster"}};
  const auto found = names.find(type);
  return found == names.end() ? "the measurement type " + text::quoted(type) : found->second + " (" + type + ")";
}

bool DynaMlReader::read_covariance(pugi::xml_node block, const char* const (&names)[3][3],
                                   Eigen::Ref<Eigen::MatrixXd> c) {
  for (int i = 0; i < 3; ++i)
    for (int j = 0; j < 3; ++j) {
      const auto value = number(block, names[i][j], "a covariance in m^2");
      if (!value) return false;
      c(i, j) = *value;
    }
  return true;
}

Eigen::MatrixXd DynaMlReader::covariance_of(pugi::xml_node cluster, const std::vector<pugi::xml_node>& parts,
                                            const char* between) {
  static constexpr const char* kOwn[3][3] = {
      {"SigmaXX", "SigmaXY", "SigmaXZ"}, {"SigmaXY", "SigmaYY", "SigmaYZ"}, {"SigmaXZ", "SigmaYZ", "SigmaZZ"}};
  static constexpr const char* kBlock[3][3] = {{"m11", "m12", "m13"}, {"m21", "m22", "m23"}, {"m31", "m32", "m33"}};
  const auto n = static_cast<Eigen::Index>(3 * parts.size());
  Eigen::MatrixXd covariance = Eigen::MatrixXd::Zero(n, n);
  for (size_t i = 0; i < parts.size(); ++i) {
    const auto at = static_cast<Eigen::Index>(3 * i);
    if (!read_covariance(parts[i], kOwn, covariance.block<3, 3>(at, at))) return {};
    const auto blocks = text::children(parts[i], between);
    if (blocks.size() + i + 1 != parts.size()) {
      reject(parts[i], std::to_string(blocks.size()) + " blocks " + between,
             std::to_string(parts.size() - i - 1) + ", one for each behind it in the cluster");
      return {};
    }
    for (size_t j = 0; j < blocks.size(); ++j) {
      const auto other = static_cast<Eigen::Index>(3 * (i + 1 + j));
      if (!read_covariance(blocks[j], kBlock, covariance.block<3, 3>(at, other))) return {};
      covariance.block<3, 3>(other, at) = covariance.block<3, 3>(at, other).transpose();
    }
  }
  if (Eigen::LLT<Eigen::MatrixXd>(covariance).info() == Eigen::Success) return covariance;
  reject(cluster,
         "a covariance of " + name_of_dynaml_type(child_text(cluster, "Type")) + " that is not positive definite",
         "one that is: six numbers, or blocks, of the same processing");
  return {};
}

std::optional<std::array<double, 4>> DynaMlReader::scales_of(pugi::xml_node cluster) {
  static constexpr const char* kNames[] = {"Vscale", "Pscale", "Lscale", "Hscale"};
  std::array<double, 4> scales = {};
  for (size_t k = 0; k < 4; ++k) {
    const auto value = child_text(cluster, kNames[k]).empty() ? 1 : number(cluster, kNames[k], "a factor above zero");
    if (!value) return std::nullopt;
    scales[k] = *value;
    if (*value > 0) continue;
    reject(cluster, std::string(kNames[k]) + " of zero or less", "a factor above zero");
    return std::nullopt;
  }
  if (scales[1] == scales[2]) return scales;
  reject(cluster, "Pscale and Lscale that differ", "one factor for both, as nothing else is read");
  return std::nullopt;
}

bool DynaMlReader::read_axes(pugi::xml_node part, const char* expected, Eigen::Ref<Eigen::VectorXd> values) {
  static constexpr const char* kAxes[] = {"X", "Y", "Z"};
  for (int k = 0; k < 3; ++k) {
    const auto value = number(part, kAxes[k], expected);
    if (!value) return false;
    values[k] = *value;
  }
  return true;
}

/// First, Second and GPSBaseline of each baseline follow one another; in a cluster each baseline has blocks with its
/// covariance to those behind it. All variances times Vscale; Pscale, Lscale and Hscale are of north, east and height.
void DynaMlReader::read_baselines(pugi::xml_node node, const std::string& type) {
  const auto firsts = text::children(node, "First"), seconds = text::children(node, "Second"),
             baselines = text::children(node, "GPSBaseline");
  if (baselines.empty() || firsts.size() != baselines.size() || seconds.size() != baselines.size())
    return reject(node, name_of_dynaml_type(type) + " without First, Second and GPSBaseline of each",
                  "all three of each");
  const auto scales = scales_of(node);
  if (!scales) return;
  VectorGroup group;
  group.is_geocentric = true;
  group.source = xml_.position(node);
  group.horizontal_factor = std::sqrt((*scales)[1]), group.vertical_factor = std::sqrt((*scales)[3]);
  group.values.resize(static_cast<Eigen::Index>(3 * baselines.size()));
  for (size_t i = 0; i < baselines.size(); ++i) {
    if (!read_axes(baselines[i], "a difference in m", group.values.segment<3>(static_cast<Eigen::Index>(3 * i))))
      return;
    const std::string from(text::trim(firsts[i].text().get())), to(text::trim(seconds[i].text().get()));
    if (from.empty() || to.empty() || from == to) return reject(baselines[i], "a baseline", "two stations");
    group.vectors.push_back({from, to});
  }
  group.covariance = (*scales)[0] * covariance_of(node, baselines, "GPSCovariance");
  if (group.covariance.size() == 0) return;
  for (const auto& v : group.vectors)
    for (const std::string& id : {v.from, v.to}) builder_.point(id, group.source);
  builder_.survey.vectors.push_back(std::move(group));
}

/// First and Clusterpoint of each point follow one another, with their covariance as in a cluster of baselines. Places
/// of the earth: E, N, H of the plane that the stations lie in, the covariance turned and scaled with them.
void DynaMlReader::read_points(pugi::xml_node node) {
  const std::string type = name_of_dynaml_type("Y");
  const auto firsts = text::children(node, "First"), points = text::children(node, "Clusterpoint");
  if (points.empty() || firsts.size() != points.size())
    return reject(node, type + " without First and Clusterpoint of each", "both of each");
  if (child_text(node, "Coords") != "XYZ")
    return reject(node, type + " in " + text::quoted(child_text(node, "Coords")), "XYZ in Coords");
  if (!plane_)
    return reject(node, type + " in a file without stations", "its DnaStation, which say where the plane is");
  const auto scales = scales_of(node);
  if (!scales) return;
  const Eigen::Vector3d factors = Eigen::Vector3d((*scales)[1], (*scales)[1], (*scales)[3]).cwiseSqrt();
  const auto n = static_cast<Eigen::Index>(3 * points.size());
  CoordinateGroup group;
  group.source = xml_.position(node);
  group.values.resize(n);
  Eigen::MatrixXd turn = Eigen::MatrixXd::Zero(n, n);
  for (size_t i = 0; i < points.size(); ++i) {
    const std::string id(text::trim(firsts[i].text().get()));
    if (id.empty()) return reject(firsts[i], "a point of " + type + " without a name", "the name of a station");
    const auto at = static_cast<Eigen::Index>(3 * i);
    Eigen::Vector3d earth;
    if (!read_axes(points[i], "a coordinate in m", earth)) return;
    const Eigen::Vector3d place = plane_->place(earth);
    if (!(std::abs(earth.norm() - 6.37e6) < 5e4) || !(place.head<2>().norm() < kFarthestStation))
      return reject(points[i], "a point of " + type + " far from the stations", "X, Y, Z of the same frame");
    group.values.segment<3>(at) = place;
    turn.block<3, 3>(at, at) = factors.asDiagonal() * plane_->change(earth);
    for (int k = 0; k < 3; ++k) group.components.push_back({id, k});
  }
  const Eigen::MatrixXd given = covariance_of(node, points, "PointCovariance");
  if (given.size() == 0) return;
  group.covariance = (*scales)[0] * turn * given * turn.transpose();
  for (const auto& first : firsts) builder_.point(std::string(text::trim(first.text().get())), group.source);
  builder_.survey.coordinates.push_back(std::move(group));
  has_point_clusters_ = true;
}

}  // namespace plumbline::survey
