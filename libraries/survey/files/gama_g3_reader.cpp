// Input of GNU Gama's gama-g3 (root gnu-gama-data): GNSS vectors, observed places and distances on the earth, with
// covariances. E and N are laid on a plane of the network's own, which is a map: libraries/survey/files/geodetic_frame.
#include <Eigen/Cholesky>
#include <cmath>
#include <map>
#include <numbers>
#include <optional>

#include "survey/files/gama.hpp"
#include "survey/files/gama_reader.hpp"
#include "survey/files/geodetic_frame.hpp"

namespace plumbline::survey::gama {

namespace {

using Eigen::MatrixXd;
using Eigen::Vector3d;
using text::child;
using text::child_text;

constexpr const char* kRead =
    "vector, xyz, distance or hdiff: GNSS vectors, observed places, distances, level differences";

class G3Reader {
 public:
  G3Reader(const text::XmlFile& xml, const std::string& file) : xml_(xml), builder_(file, "gama-xml") {}

  SurveyObservations read() {
    const auto model = child(xml_.root(), "g3-model");
    if (!model) throw SurveyReadError(xml_.position(xml_.root()), "gnu-gama-data without a g3-model", "<g3-model>");
    if (xml_.damage()) builder_.survey.skipped.push_back(*xml_.damage());
    builder_.survey.info.use_a_posteriori_sigma0 = true;  // as the program does, unless its options say otherwise
    builder_.survey.info.title = child_text(xml_.root(), "text");
    read_constants(child(model, "constants"));
    for (auto node = model.first_child(); node; node = node.next_sibling()) read_element(node);
    reach_by_vectors();
    lay_on_plane();
    for (const auto& node : clusters_) read_cluster(node);
    return builder_.finish("a gama-g3 network without observations that are read", kRead);
  }

 private:
  void skip(pugi::xml_node node, const std::string& found, const std::string& expected) {
    const SourcePosition at = xml_.position(node);
    builder_.skip(at.line, at.column, found, expected);
  }

  std::optional<double> number(pugi::xml_node parent, const char* name) {
    const std::string text = child_text(parent, name);
    const auto value = text::parse_number(text);
    if (!value)
      skip(parent, text.empty() ? "<" + std::string(parent.name()) + "> without " + name : text::quoted(text),
           "a number in <" + std::string(name) + ">");
    return value;
  }

  std::optional<Vector3d> triple(pugi::xml_node parent, const char* x, const char* y, const char* z) {
    const auto first = number(parent, x), second = number(parent, y), third = number(parent, z);
    if (!first || !second || !third) return std::nullopt;
    return Vector3d(*first, *second, *third);
  }

  /// What is not on GRS80, from which WGS84 differs by 0.1 mm, is refused: its heights would be wrong by hundreds of m.
  void read_constants(pugi::xml_node constants) {
    const auto ellipsoid = child(constants, "ellipsoid");
    const std::string id = text::to_lower(child_text(ellipsoid, "id"));
    const auto a = text::parse_number(child_text(ellipsoid, "a")), b = text::parse_number(child_text(ellipsoid, "b"));
    const bool axes = a && b && std::abs(*a - 6378137) < 1e-3 && std::abs(*b - 6356752.314) < 1e-3;
    if (!axes && (a || b || (!id.empty() && id != "wgs84" && id != "grs80")))
      throw SurveyReadError(xml_.position(ellipsoid), "the ellipsoid " + text::quoted(id.empty() ? "a, b" : id),
                            "wgs84 or grs80");
  }

  void read_element(pugi::xml_node node) {
    if (node.type() != pugi::node_element) return;
    const auto name = text::local_name(node);
    using R = CoordinateRole;
    if (name == "fixed" || name == "free" || name == "constr" || name == "unused") {
      const R role = name == "fixed"    ? R::fixed
                     : name == "free"   ? R::free
                     : name == "constr" ? R::constrained
                                        : R::unused;
      if (child(node, "n") || child(node, "e")) roles_[0] = roles_[1] = role;
      if (child(node, "u")) roles_[2] = role;
      if (!child(node, "n") != !child(node, "e")) skip(node, "one of n and e alone", "both, or u");
    } else if (name == "point") {
      read_point(node);
    } else if (name == "obs") {
      clusters_.push_back(node);
      for (const auto& one : text::children(node, "xyz")) see(one, child_text(one, "id"));
    } else if (name != "constants") {
      skip(node, "<" + std::string(name) + ">", "constants, fixed, free, constr, unused, point or obs");
    }
  }

  static bool is_on_earth(const Vector3d& at) {
    return std::abs(at.norm() - 6.37e6) < 5e4 && std::abs(from_geocentric(at).latitude) < 1.5;
  }

  /// A first place of a point; observed ones are as good.
  void see(pugi::xml_node node, const std::string& id) {
    if (child_text(node, "x").empty() || places_.contains(id)) return;
    const auto at = triple(node, "x", "y", "z");
    if (!at) return;
    if (is_on_earth(*at))
      places_[id] = *at;
    else
      skip(node, "a place " + text::format_fixed(at->norm() / 1000, 0) + " km from the centre",
           "one on the earth, below a latitude of 86 degrees");
  }

  void read_point(pugi::xml_node node) {
    const std::string id = child_text(node, "id");
    if (id.empty()) return skip(node, "<point> without id", "<id>");
    builder_.point(id, xml_.position(node)).roles = roles_;
    if (child(node, "b") || child(node, "l"))
      skip(node, "latitude and longitude of " + id, "x, y and z (they are approximate where vectors lead there)");
    see(node, id);
  }

  /// Points without coordinates are where vectors from points with them lead.
  void reach_by_vectors() {
    for (bool grows = true; grows;) {
      grows = false;
      for (const auto& cluster : clusters_)
        for (const auto& v : text::children(cluster, "vector")) {
          const std::string from = child_text(v, "from"), to = child_text(v, "to");
          if (places_.contains(from) == places_.contains(to)) continue;
          const auto x = text::parse_number(child_text(v, "dx")), y = text::parse_number(child_text(v, "dy")),
                     z = text::parse_number(child_text(v, "dz"));
          if (!x || !y || !z) continue;
          const Vector3d d(*x, *y, *z);
          if (places_.contains(from))
            places_[to] = places_[from] + d;
          else
            places_[from] = places_[to] - d;
          grows = true;
        }
    }
  }

  void lay_on_plane() {
    if (places_.empty()) return;
    Vector3d mean = Vector3d::Zero();
    for (const auto& [id, at] : places_) mean += at / static_cast<double>(places_.size());
    plane_.emplace(from_geocentric(mean));
    for (const auto& [id, at] : places_) {
      if (!builder_.has_point(id)) continue;  // no <point> declares it
      const Vector3d p = plane_->place(at);
      const SourcePosition source = builder_.point(id, {}).source;
      if (!(p.head<2>().norm() < kFarthestStation))
        throw SurveyReadError(source,
                              "point " + text::quoted(id) + " " + text::format_fixed(p.head<2>().norm() / 1000, 0) +
                                  " km from the middle of the network",
                              "a network within 500 km; gama-g3 is for larger ones");
      builder_.give_coordinates(id, p, source);
    }
    builder_.survey.info.coordinate_system = plane_->as_map();
    builder_.warn(
        "E and N are of a plane about the middle of the network (a map of the network's own, to which lengths are "
        "reduced), heights are above the ellipsoid");
  }

  /// Upper band by rows in mm^2; empty if wrong. `size` of the cluster.
  MatrixXd covariance_of(pugi::xml_node cluster, int size) {
    const auto node = child(cluster, "cov-mat");
    const auto dimension = number(node, "dim"), band = number(node, "band");
    const auto values = text::children(node, "flt");
    if (!dimension || !band) return {};
    MatrixXd covariance = MatrixXd::Zero(size, size);
    size_t k = 0;
    bool good = *dimension == size && *band >= 0 && *band < size;
    for (int i = 0; good && i < size; ++i)
      for (int j = i; good && j < size && j <= i + static_cast<int>(*band); ++j, ++k) {
        const auto value = k < values.size() ? text::parse_number(values[k].text().get()) : std::nullopt;
        good = value.has_value();
        if (good) covariance(i, j) = covariance(j, i) = kMillimetre * kMillimetre * *value;
      }
    if (good && k == values.size() && Eigen::LLT<MatrixXd>(covariance).info() == Eigen::Success) return covariance;
    skip(node,
         "a cov-mat of dimension " + child_text(node, "dim") + " with " + std::to_string(values.size()) + " numbers",
         "a positive definite one of dimension " + std::to_string(size) + ", its upper band by rows");
    return {};
  }

  void read_cluster(pugi::xml_node cluster) {
    std::vector<pugi::xml_node> nodes;
    for (auto node = cluster.first_child(); node; node = node.next_sibling())
      if (node.type() == pugi::node_element && text::local_name(node) != "cov-mat") nodes.push_back(node);
    if (nodes.empty()) return;
    const std::string kind(text::local_name(nodes.front()));
    for (const auto& node : nodes)
      if (text::local_name(node) != kind)
        return skip(node, "<" + std::string(node.name()) + "> beside <" + kind + "> in one obs",
                    "an obs for each kind");
    if (kind == "vector") return read_vectors(cluster, nodes);
    if (kind == "xyz") return read_places(cluster, nodes);
    if (kind == "distance" || kind == "hdiff") return read_lengths(cluster, nodes, kind == "hdiff");
    skip(nodes.front(), "<" + kind + ">", kRead);
  }

  bool are_points(pugi::xml_node node, const std::string& from, const std::string& to) {
    if (!from.empty() && !to.empty() && from != to && builder_.has_point(from) && builder_.has_point(to)) return true;
    skip(node, "<" + std::string(node.name()) + "> from " + text::quoted(from) + " to " + text::quoted(to),
         "two points that the file declares");
    return false;
  }

  double height(pugi::xml_node node, const char* name) {
    return child_text(node, name).empty() ? 0 : number(node, name).value_or(0);
  }

  void read_vectors(pugi::xml_node cluster, const std::vector<pugi::xml_node>& nodes) {
    VectorGroup group;
    group.is_geocentric = true;
    group.source = xml_.position(cluster);
    group.values.resize(static_cast<Eigen::Index>(3 * nodes.size()));
    for (size_t i = 0; i < nodes.size(); ++i) {
      const auto d = triple(nodes[i], "dx", "dy", "dz");
      const std::string from = child_text(nodes[i], "from"), to = child_text(nodes[i], "to");
      if (!d || !are_points(nodes[i], from, to)) return;
      group.values.segment<3>(static_cast<Eigen::Index>(3 * i)) = *d;
      group.vectors.push_back({from, to, height(nodes[i], "from-dh"), height(nodes[i], "to-dh")});
    }
    group.covariance = covariance_of(cluster, static_cast<int>(group.values.size()));
    if (group.covariance.size() > 0) builder_.survey.vectors.push_back(std::move(group));
  }

  /// Places of the earth: E, N, H of the plane, the covariance turned and scaled with them.
  void read_places(pugi::xml_node cluster, const std::vector<pugi::xml_node>& nodes) {
    CoordinateGroup group;
    group.source = xml_.position(cluster);
    const auto n = static_cast<Eigen::Index>(3 * nodes.size());
    group.values.resize(n);
    MatrixXd turn = MatrixXd::Zero(n, n);
    for (size_t i = 0; i < nodes.size(); ++i) {
      const std::string id = child_text(nodes[i], "id");
      const auto earth = triple(nodes[i], "x", "y", "z");
      if (!earth) return;
      if (!builder_.has_point(id) || !plane_ || !is_on_earth(*earth))
        return skip(nodes[i], "<xyz> of " + text::quoted(id), "a place on the earth of a point that the file declares");
      const auto at = static_cast<Eigen::Index>(3 * i);
      group.values.segment<3>(at) = plane_->place(*earth);
      turn.block<3, 3>(at, at) = plane_->change(*earth);
      for (int k = 0; k < 3; ++k) group.components.push_back({id, k});
    }
    const MatrixXd given = covariance_of(cluster, static_cast<int>(n));
    if (given.size() == 0) return;
    group.covariance = turn * given * turn.transpose();
    builder_.survey.coordinates.push_back(std::move(group));
  }

  /// Nothing if it is not taken, which is said. `together`: a cov-mat has its standard deviation.
  std::optional<Observation> length_of(pugi::xml_node node, bool levelled, bool together) {
    Observation o;
    o.kind = levelled ? ObservationKind::height_difference : ObservationKind::slope_distance;
    o.from = child_text(node, "from"), o.to = child_text(node, "to"), o.source = xml_.position(node);
    const auto value = number(node, "val");
    if (!value || !are_points(node, o.from, o.to)) return std::nullopt;
    o.value = *value;
    if (!levelled && o.value <= 0) {
      skip(node, "a distance of " + child_text(node, "val"), "one above zero");
      return std::nullopt;
    }
    o.instrument_height = height(node, "from-dh"), o.target_height = height(node, "to-dh");
    if (together) return o;
    const auto sigma = number(node, "stdev");
    if (!sigma) return std::nullopt;
    if (!(*sigma > 0)) {
      skip(node, "a stdev of " + child_text(node, "stdev"), "one above zero");
      return std::nullopt;
    }
    o.sigma = kMillimetre * *sigma;
    return o;
  }

  void read_lengths(pugi::xml_node cluster, const std::vector<pugi::xml_node>& nodes, bool levelled) {
    ObservationCovariance covariance;
    if (child(cluster, "cov-mat")) {
      covariance.covariance = covariance_of(cluster, static_cast<int>(nodes.size()));
      if (covariance.covariance.size() == 0) return;
    }
    const bool together = covariance.covariance.size() > 0;
    std::vector<Observation> read;
    for (size_t i = 0; i < nodes.size(); ++i)
      if (auto o = length_of(nodes[i], levelled, together))
        read.push_back(std::move(*o));
      else if (together && nodes.size() > 1)
        return skip(cluster, "an obs with a cov-mat of which a reading is not taken", "all of its readings");
    for (Observation& o : read) {
      const auto k = static_cast<Eigen::Index>(covariance.indices.size());
      if (together) o.sigma = std::sqrt(covariance.covariance(k, k));
      covariance.indices.push_back(static_cast<int>(builder_.survey.observations.size()));
      builder_.add(std::move(o));
    }
    if (together && !read.empty() && !covariance.covariance.isDiagonal(0))
      builder_.survey.covariances.push_back(std::move(covariance));
  }

  const text::XmlFile& xml_;
  SurveyBuilder builder_;
  std::array<CoordinateRole, 3> roles_ = {CoordinateRole::free, CoordinateRole::free, CoordinateRole::free};
  std::map<std::string, Vector3d> places_;  ///< geocentric [m]
  std::vector<pugi::xml_node> clusters_;
  std::optional<GroundPlane> plane_;
};

}  // namespace

SurveyObservations read_g3(const text::XmlFile& xml, const std::string& file) { return G3Reader(xml, file).read(); }

}  // namespace plumbline::survey::gama
