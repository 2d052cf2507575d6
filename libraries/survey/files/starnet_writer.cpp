#include <fmt/core.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <numbers>
#include <stdexcept>

#include "base/text/text.hpp"
#include "survey/files/pointings.hpp"
#include "survey/files/starnet.hpp"
#include "survey/files/starnet_reader.hpp"
#include "survey/files/survey_builder.hpp"

namespace plumbline::survey {
namespace {

constexpr double kArcSecond = std::numbers::pi / 180 / 3600;

[[noreturn]] void starnet_cannot(const std::string& what) { throw std::runtime_error("STAR*NET writer: " + what); }

/// 123-45-56.78901: to 1e-5", 5e-11 rad.
std::string dms(double angle) {
  constexpr long long kUnits = 100000, kTurn = 360LL * 3600 * kUnits;
  const long long units = std::llround(wrap_to_circle(angle) / kArcSecond * static_cast<double>(kUnits)) % kTurn;
  const long long seconds = units / kUnits;
  return fmt::format("{}-{:02}-{:02}.{:05}", seconds / 3600, seconds / 60 % 60, seconds % 60, units % kUnits);
}

class StarNetWriter {
 public:
  explicit StarNetWriter(const SurveyObservations& survey) : survey_(survey) {}
  std::string write();

 private:
  void refuse_what_has_no_place() const;
  void begin();
  void write_points();
  void write_set_up(const std::vector<const Pointing*>& sightings);
  void write_rest_of(const Pointing& sighting);
  void write_alone(const Observation& o);
  void delta(bool on);
  void line(const std::string& head, std::initializer_list<const Observation*> values, const Observation& any,
            bool heights);
  std::string value(const Observation& o) const;
  std::string sigma(const Observation& o) const;
  std::string joined(std::initializer_list<std::string> names) const;
  const std::string& name(const std::string& id) const;

  const SurveyObservations& survey_;
  std::string out_;
  char separator_ = '-';
  bool three_ = true, delta_ = false;
  std::map<std::string, std::array<double, 3>> sigmas_;  // of given coordinates
};

void StarNetWriter::refuse_what_has_no_place() const {
  const char* instead = "; write gama XML instead";
  if (!survey_.covariances.empty())
    starnet_cannot(std::string("the format has no place for correlated observations") + instead);
  if (!survey_.vectors.empty()) starnet_cannot(std::string("vectors are not written") + instead);
  if (!survey_.local_coordinates.empty())
    starnet_cannot(std::string("the format has no place for coordinates in a set-up's own frame") + instead);
}

const std::string& StarNetWriter::name(const std::string& id) const {
  if (id.empty() || id.find_first_of(" \t\r\n#'\"") != std::string::npos || id == "&" || id == "*" || id == "!")
    starnet_cannot("cannot hold the name " + text::quoted(id) +
                   ": names have no blanks, quotes or '#'; rename the point");
  return id;
}

std::string StarNetWriter::joined(std::initializer_list<std::string> names) const {
  std::string text;
  for (const std::string& id : names) text += (text.empty() ? "" : std::string(1, separator_)) + name(id);
  return text;
}

void StarNetWriter::begin() {
  const auto none_has = [&](char c) {
    return std::none_of(survey_.points.begin(), survey_.points.end(),
                        [&](const Point& p) { return p.id.find(c) != std::string::npos; }) &&
           std::none_of(survey_.observations.begin(), survey_.observations.end(), [&](const Observation& o) {
             return (o.from + o.to + o.second_to).find(c) != std::string::npos;
           });
  };
  const std::string candidates = "-|^~:=";
  const auto free = std::find_if(candidates.begin(), candidates.end(), none_has);
  if (free == candidates.end())
    starnet_cannot("the names use all of " + candidates + ", none is left to join them with");
  separator_ = *free;
  three_ = std::any_of(survey_.observations.begin(), survey_.observations.end(), [](const Observation& o) {
    return o.kind == ObservationKind::zenith_angle || o.kind == ObservationKind::slope_distance ||
           o.kind == ObservationKind::height_difference;
  });
  if (!survey_.info.title.empty()) {
    std::string title = survey_.info.title;
    std::replace_if(
        title.begin(), title.end(), [](char c) { return static_cast<unsigned char>(c) < 0x20; }, ' ');
    out_ += "# " + title + "\n";
  }
  out_ += ".UNITS METERS DMS\n.ORDER EN ATFROMTO\n";
  out_ += three_ ? ".3D\n" : ".2D\n";
  bool added = false, whole = false;  // centring, to standard deviations that are written
  for (const Observation& o : survey_.observations)
    if (!std::isnan(o.sigma) && o.kind != ObservationKind::height_difference)
      (o.without_centring ? added : whole) = true;
  if (added && whole)
    starnet_cannot(
        "standard deviations with centring and without are not written into one file; take one or the other");
  if (added) out_ += ".ADDCENTERING ON\n";
  if (separator_ != '-') out_ += std::string(".SEPARATOR ") + separator_ + "\n";
}

void StarNetWriter::write_points() {
  for (const CoordinateGroup& g : survey_.coordinates)
    for (std::size_t k = 0; k < g.components.size(); ++k) {
      const auto at = static_cast<Eigen::Index>(k);
      Eigen::VectorXd others = g.covariance.row(at);
      others[at] = 0;
      if (!g.is_control || others.cwiseAbs().maxCoeff() > 0)
        starnet_cannot("the format has no place for correlated coordinates; write gama XML instead");
      sigmas_.try_emplace(g.components[k].point, std::array{kNotGiven, kNotGiven, kNotGiven})
          .first->second[g.components[k].axis] = std::sqrt(g.covariance(at, at));
    }
  for (const Point& p : survey_.points) {
    const bool plan = !p.coordinates.head<2>().array().isNaN().any(), height = !std::isnan(p.coordinates.z()) && three_;
    if (!plan && !height) continue;
    std::string values, codes;
    const auto given = sigmas_.find(p.id);
    for (int axis = plan ? 0 : 2; axis < (height ? 3 : 2); ++axis) {
      const auto k = static_cast<std::size_t>(axis);
      values += " " + text::format_shortest(p.coordinates[axis]);
      const bool fixed = p.roles[k] == CoordinateRole::fixed;
      const bool known = given != sigmas_.end() && !std::isnan(given->second[k]);
      codes += fixed ? " !" : known ? " " + text::format_shortest(given->second[k]) : " *";
    }
    out_ += std::string(plan ? "C " : "E ") + name(p.id) + values + codes + "\n";
  }
}

/// Whether horizontal distances are meant.
void StarNetWriter::delta(bool on) {
  if (!three_ || on == delta_) return;
  delta_ = on;
  out_ += on ? ".DELTA ON\n" : ".DELTA OFF\n";
}

std::string StarNetWriter::value(const Observation& o) const {
  return is_angle_kind(o.kind) ? dms(o.value) : text::format_shortest(o.value);
}

std::string StarNetWriter::sigma(const Observation& o) const {
  if (std::isnan(o.sigma)) return "&";
  return text::format_shortest(is_angle_kind(o.kind) ? o.sigma / kArcSecond : o.sigma);
}

void StarNetWriter::line(const std::string& head, std::initializer_list<const Observation*> values,
                         const Observation& any, bool heights) {
  out_ += head;
  for (const Observation* o : values) out_ += " " + value(*o);
  if (std::any_of(values.begin(), values.end(), [](const Observation* o) { return !std::isnan(o->sigma); }))
    for (const Observation* o : values) out_ += " " + sigma(*o);
  double instrument = any.instrument_height;
  if (std::isnan(instrument) && any.set_up >= 0) instrument = survey_.set_ups.at(any.set_up).instrument_height;
  if (heights && three_ && !(std::isnan(instrument) && std::isnan(any.target_height)))
    out_ += " " + text::format_shortest(std::isnan(instrument) ? 0 : instrument) + "/" +
            text::format_shortest(std::isnan(any.target_height) ? 0 : any.target_height);
  out_ += "\n";
}

/// A direction set holds directions, and complete sightings; what else was measured follows behind it.
void StarNetWriter::write_set_up(const std::vector<const Pointing*>& sightings) {
  const auto has_direction = [](const Pointing* p) { return p->direction != nullptr; };
  delta(false);
  if (std::any_of(sightings.begin(), sightings.end(), has_direction)) {
    out_ += "DB " + name(sightings.front()->first->from) + "\n";
    for (const Pointing* p : sightings) {
      if (!p->direction) continue;
      const std::string to = name(p->first->to);
      if (p->slope_distance && p->zenith_angle)
        line("DM " + to, {p->direction, p->slope_distance, p->zenith_angle}, *p->first, true);
      else
        line("DN " + to, {p->direction}, *p->first, true);
    }
    out_ += "DE\n";
  }
  for (const Pointing* p : sightings) write_rest_of(*p);
}

void StarNetWriter::write_rest_of(const Pointing& p) {
  const std::string ends = joined({p.first->from, p.first->to});
  const bool complete = p.slope_distance && p.zenith_angle;
  if (complete && !p.direction) {
    delta(false);
    line("DV " + ends, {p.slope_distance, p.zenith_angle}, *p.first, true);
  } else if (!complete && (p.slope_distance || p.zenith_angle)) {
    delta(false);
    const Observation& only = p.slope_distance ? *p.slope_distance : *p.zenith_angle;
    line((p.slope_distance ? "D " : "V ") + ends, {&only}, *p.first, true);
  }
  if (p.horizontal_distance) {
    delta(true);
    line("D " + ends, {p.horizontal_distance}, *p.first, false);
  }
  if (p.height_difference) write_alone(*p.height_difference);
}

void StarNetWriter::write_alone(const Observation& o) {
  if (o.kind == ObservationKind::height_difference) {
    out_ += "L " + joined({o.from, o.to}) + " " + value(o);
    const double last = std::isnan(o.sigma) ? o.levelling_length : o.sigma;
    out_ += (std::isnan(last) ? "" : " " + text::format_shortest(last)) + "\n";
    return;
  }
  delta(o.kind == ObservationKind::horizontal_distance);
  const bool angle = o.kind == ObservationKind::angle;
  const std::string ends = angle ? joined({o.from, o.to, o.second_to}) : joined({o.from, o.to});
  const bool heights = o.kind == ObservationKind::slope_distance || o.kind == ObservationKind::zenith_angle;
  line((angle                                     ? "A "
        : o.kind == ObservationKind::azimuth      ? "B "
        : o.kind == ObservationKind::zenith_angle ? "V "
                                                  : "D ") +
           ends,
       {&o}, o, heights);
}

std::string StarNetWriter::write() {
  refuse_what_has_no_place();
  begin();
  write_points();
  SurveyObservations sighted = survey_;
  std::vector<const Observation*> alone;
  sighted.observations.clear();
  for (const Observation& o : survey_.observations) {
    if (std::isnan(o.value)) starnet_cannot("the observation " + o.from + " to " + o.to + " has no value");
    if (o.from == o.to || (o.kind == ObservationKind::angle && (o.second_to == o.from || o.second_to == o.to)))
      starnet_cannot("the observation " + o.from + " to " + o.to + " has one point twice; leave it out");
    if (o.face == 2 && is_angle_kind(o.kind)) starnet_cannot("readings in face 2 are to be reduced before");
    const bool alone_stands = o.set_up < 0 || o.kind == ObservationKind::angle || o.kind == ObservationKind::azimuth;
    if (alone_stands)
      alone.push_back(&o);
    else
      sighted.observations.push_back(o);
  }
  const std::vector<Pointing> all = pointings_of(sighted, "STAR*NET writer");
  for (std::size_t i = 0; i < all.size();) {
    std::vector<const Pointing*> sightings;
    for (const int set_up = all[i].first->set_up; i < all.size() && all[i].first->set_up == set_up; ++i)
      sightings.push_back(&all[i]);
    write_set_up(sightings);
  }
  for (const Observation* o : alone) write_alone(*o);
  return std::move(out_);
}

}  // namespace

std::string write_starnet(const SurveyObservations& survey) { return StarNetWriter(survey).write(); }

}  // namespace plumbline::survey
