#include <cmath>
#include <map>
#include <numbers>
#include <stdexcept>

#include "base/text/text.hpp"
#include "survey/files/gama.hpp"
#include "survey/files/xml_file.hpp"

namespace plumbline::survey {

namespace {

using text::format_shortest;
using text::xml_escaped;

constexpr double kGon = std::numbers::pi / 200;
constexpr double kCc = kGon * 1e-4;
constexpr double kMillimetre = 1e-3;

bool is_angular(ObservationKind kind) {
  return kind == ObservationKind::direction || kind == ObservationKind::zenith_angle ||
         kind == ObservationKind::angle || kind == ObservationKind::azimuth;
}

std::string attribute(const char* name, const std::string& value) {
  return std::string(" ") + name + "=\"" + xml_escaped(value) + "\"";
}

std::string height(const char* name, double value) {
  return std::isnan(value) ? "" : attribute(name, format_shortest(value));
}

/// Upper triangle by rows, in the unit of the format.
std::string covariance(const Eigen::MatrixXd& matrix) {
  const auto n = matrix.rows();
  std::string text = "<cov-mat dim=\"" + std::to_string(n) + "\" band=\"" + std::to_string(n - 1) + "\">\n";
  for (Eigen::Index i = 0; i < n; ++i)
    for (Eigen::Index j = i; j < n; ++j) text += format_shortest(matrix(i, j)) + (j + 1 == n ? "\n" : " ");
  return text + "</cov-mat>\n";
}

std::string point(const Point& p) {
  using R = CoordinateRole;
  std::string text = "<point" + attribute("id", p.id);
  if (!std::isnan(p.coordinates.x()) && !std::isnan(p.coordinates.y()))
    text += attribute("x", format_shortest(p.coordinates.x())) + attribute("y", format_shortest(p.coordinates.y()));
  if (!std::isnan(p.coordinates.z())) text += attribute("z", format_shortest(p.coordinates.z()));
  std::string fix, adj;
  const auto add = [&](R role, const char* small, const char* capital) {
    if (role == R::fixed) fix += small;
    if (role == R::free) adj += small;
    if (role == R::constrained) adj += capital;
  };
  add(p.roles[0], "xy", "XY");
  add(p.roles[2], "z", "Z");
  if (!fix.empty()) text += attribute("fix", fix);
  if (!adj.empty()) text += attribute("adj", adj);
  return text + "/>\n";
}

class GamaWriter {
 public:
  explicit GamaWriter(const SurveyObservations& survey) : s_(survey) {
    if (!s_.local_coordinates.empty())
      throw std::runtime_error("gama XML writer: the format cannot hold coordinates in the frame of a set-up");
    for (const Observation& o : s_.observations)
      if (o.face == 2 || !(o.sigma > 0) || o.without_centring)
        throw std::runtime_error("gama XML writer: " + o.from + " -> " + o.to +
                                 (o.face == 2 ? " is a reading in face 2; take means first"
                                  : o.without_centring
                                      ? " has a standard deviation without centring, to which an instrument adds it"
                                      : " has no standard deviation; the format needs one"));
  }

  std::string write() {
    text_ =
        "<?xml version=\"1.0\" ?>\n<gama-local xmlns=\"http://www.gnu.org/software/gama/gama-local\">\n"
        "<network axes-xy=\"en\" angles=\"left-handed\">\n<description>" +
        xml_escaped(s_.info.description.empty() ? s_.info.title : s_.info.description) + "</description>\n";
    const double sigma0 = std::isnan(s_.info.a_priori_sigma0) ? 1.0 : s_.info.a_priori_sigma0;
    text_ += "<parameters" + attribute("sigma-apr", format_shortest(sigma0)) +
             attribute("sigma-act", s_.info.use_a_posteriori_sigma0 ? "aposteriori" : "apriori");
    if (!std::isnan(s_.info.largest_misclosure))
      text_ += attribute("tol-abs", format_shortest(1000 * s_.info.largest_misclosure));
    text_ += "/>\n";
    text_ += "<points-observations>\n";
    for (const Point& p : s_.points) text_ += point(p);
    observations();
    for (const CoordinateGroup& g : s_.coordinates) coordinates(g);
    for (const VectorGroup& g : s_.vectors) vectors(g);
    return text_ + "</points-observations>\n</network>\n</gama-local>\n";
  }

 private:
  std::string element(const Observation& o, bool with_from) {
    static const std::map<ObservationKind, const char*> names = {
        {ObservationKind::direction, "direction"},  {ObservationKind::horizontal_distance, "distance"},
        {ObservationKind::angle, "angle"},          {ObservationKind::slope_distance, "s-distance"},
        {ObservationKind::zenith_angle, "z-angle"}, {ObservationKind::azimuth, "azimuth"},
        {ObservationKind::height_difference, "dh"},
    };
    const bool angle = o.kind == ObservationKind::angle;
    std::string text = std::string("<") + names.at(o.kind);
    if (with_from) text += attribute("from", o.from);
    text += attribute(angle ? "bs" : "to", o.to);
    if (angle) text += attribute("fs", o.second_to);
    const bool angular = is_angular(o.kind);
    // The format takes gon of [0, 400).
    const double turn = o.kind == ObservationKind::zenith_angle ? 0 : 400;
    double value = angular ? o.value / kGon : o.value;
    if (angular && turn > 0) value -= turn * std::floor(value / turn);
    text += attribute("val", format_shortest(value)) +
            attribute("stdev", format_shortest(o.sigma / (angular ? kCc : kMillimetre)));
    if (o.kind == ObservationKind::height_difference) {
      if (!std::isnan(o.levelling_length)) text += attribute("dist", format_shortest(o.levelling_length / 1000));
      return text + "/>\n";
    }
    double own = o.instrument_height;
    if (std::isnan(own) && o.set_up >= 0) own = s_.set_ups[o.set_up].instrument_height;
    text += height("from_dh", own) + height(angle ? "bs_dh" : "to_dh", o.target_height);
    if (angle) text += height("fs_dh", o.second_target_height);
    return text + "/>\n";
  }

  /// One cluster of the format. All observations of a set-up must stand in one, because each has its own orientation;
  /// so a covariance among some of them becomes the matrix of all.
  void cluster(const std::string& name, const std::string& from, const std::vector<int>& members) {
    if (members.empty()) return;
    text_ += "<" + name + (from.empty() ? "" : attribute("from", from)) + ">\n";
    for (int i : members) text_ += element(s_.observations[i], from.empty() || s_.observations[i].from != from);
    const auto n = static_cast<Eigen::Index>(members.size());
    Eigen::MatrixXd matrix = Eigen::MatrixXd::Zero(n, n);
    std::map<int, Eigen::Index> position;
    Eigen::VectorXd units(n);
    for (Eigen::Index k = 0; k < n; ++k) {
      const Observation& o = s_.observations[members[k]];
      position[members[k]] = k;
      units[k] = 1 / (is_angular(o.kind) ? kCc : kMillimetre);
      matrix(k, k) = o.sigma * o.sigma;
    }
    bool correlated = false;
    for (const ObservationCovariance& c : s_.covariances) {
      size_t inside = 0;
      for (int i : c.indices) inside += position.contains(i);
      if (inside == 0) continue;
      if (inside != c.indices.size())
        throw std::runtime_error(
            "gama XML writer: observations of two set-ups are correlated; the format cannot hold it");
      correlated = true;
      for (size_t a = 0; a < c.indices.size(); ++a)
        for (size_t b = 0; b < c.indices.size(); ++b)
          matrix(position[c.indices[a]], position[c.indices[b]]) =
              c.covariance(static_cast<Eigen::Index>(a), static_cast<Eigen::Index>(b));
    }
    if (correlated) text_ += covariance(units.asDiagonal() * matrix * units.asDiagonal());
    text_ += "</" + name + ">\n";
  }

  void observations() {
    std::vector<std::vector<int>> by_set_up(s_.set_ups.size());
    std::vector<int> lines, heights;
    for (int i = 0; i < static_cast<int>(s_.observations.size()); ++i) {
      const Observation& o = s_.observations[i];
      if (o.kind == ObservationKind::height_difference)
        heights.push_back(i);
      else if (o.set_up >= 0)
        by_set_up[o.set_up].push_back(i);
      else
        lines.push_back(i);
    }
    for (size_t k = 0; k < by_set_up.size(); ++k) cluster("obs", s_.set_ups[k].station, by_set_up[k]);
    cluster("obs", "", lines);
    cluster("height-differences", "", heights);
  }

  void coordinates(const CoordinateGroup& g) {
    std::string content;
    for (size_t k = 0; k < g.components.size();) {
      const std::string& id = g.components[k].point;
      content += "<point" + attribute("id", id);
      for (; k < g.components.size() && g.components[k].point == id; ++k)
        content += attribute(std::string(1, "xyz"[g.components[k].axis]).c_str(),
                             format_shortest(g.values[static_cast<Eigen::Index>(k)]));
      content += "/>\n";
    }
    text_ += "<coordinates>\n" + content + covariance(g.covariance * 1e6) + "</coordinates>\n";
  }

  void vectors(const VectorGroup& g) {
    if (g.is_geocentric)
      throw std::runtime_error("vectors in X, Y, Z of the earth are not written: gama-local's are of its plane");
    std::string content;
    for (size_t k = 0; k < g.vectors.size(); ++k) {
      const auto& v = g.vectors[k];
      content += "<vec" + attribute("from", v.from) + attribute("to", v.to);
      const char* const names[] = {"dx", "dy", "dz"};
      for (int c = 0; c < 3; ++c)
        content += attribute(names[c], format_shortest(g.values[static_cast<Eigen::Index>(3 * k) + c]));
      if (v.from_height != 0) content += attribute("from_dh", format_shortest(v.from_height));
      if (v.to_height != 0) content += attribute("to_dh", format_shortest(v.to_height));
      content += "/>\n";
    }
    text_ += "<vectors>\n" + content + covariance(g.covariance * 1e6) + "</vectors>\n";
  }

  const SurveyObservations& s_;
  std::string text_;
};

}  // namespace

std::string write_gama_xml(const SurveyObservations& survey) { return GamaWriter(survey).write(); }

}  // namespace plumbline::survey
