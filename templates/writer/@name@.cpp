// write.@name@: writes survey observations as a file. Here a table of sightings with units in its header, one line a
// pointing; put your own format into text_of().
#include <cmath>
#include <cstdio>
#include <map>
#include <numbers>

#include "artifacts/file.hpp"
#include "artifacts/points.hpp"
#include "artifacts/survey_artifact.hpp"
#include "artifacts/survey_observations.hpp"
#include "plumbline/node.hpp"

using namespace plumbline;

namespace {

std::string fixed(double value, int decimals) {
  char text[40];
  std::snprintf(text, sizeof text, "%.*f", decimals, value);
  return std::isnan(value) ? "" : text;
}

std::string text_of(const survey::SurveyObservations& survey, int decimals) {
  struct Row {
    const survey::Observation* one = nullptr;
    double direction = survey::kNotGiven, zenith_angle = survey::kNotGiven, distance = survey::kNotGiven;
  };
  std::map<int, Row> rows;  // by pointing: what was read at one go
  for (const survey::Observation& o : survey.observations) {
    Row& row = rows[o.pointing];
    row.one = &o;
    if (o.kind == survey::ObservationKind::direction)
      row.direction = o.value;
    else if (o.kind == survey::ObservationKind::zenith_angle)
      row.zenith_angle = o.value;
    else if (o.kind == survey::ObservationKind::slope_distance)
      row.distance = o.value;
    else
      throw std::runtime_error("write.@name@ has no place for the reading to " + o.to + " of " +
                               survey::place(o.source));
  }
  std::string text = "station,target,hz [gon],v [gon],sd [m],ih [m],th [m]\n";
  constexpr double gon = 200 / std::numbers::pi;
  for (const auto& [pointing, row] : rows) {
    const survey::SetUp& at = survey.set_ups.at(static_cast<size_t>(row.one->set_up));
    const double own = row.one->instrument_height;
    text += at.station + "," + row.one->to + "," + fixed(gon * row.direction, decimals) + "," +
            fixed(gon * row.zenith_angle, decimals) + "," + fixed(row.distance, decimals) + "," +
            fixed(survey::or_zero(survey::or_else(own, at.instrument_height)), decimals) + "," +
            fixed(survey::or_zero(row.one->target_height), decimals) + "\n";
  }
  return text;
}

struct Writer : Node {
  static constexpr Info info{"write.@name@", "survey_writer", 1, "Writes sightings as a table"};
  In<SurveyObservations> observations{"observations", frame("frame=?S"), "observations of any source"};
  Optional<Points> points{"points", frame("frame=?S"), "coordinates from elsewhere; this format has none"};
  Out<File> file{"file", "the written file"};
  Param<int64_t> decimals{"decimals", 5, between(1, 9), "of all numbers"};

  void run(Context& context) override {
    if (points) context.warn("write.@name@ has no place for coordinates: 'points' is not written");
    const std::string text = text_of(survey::from_artifact(observations.unpack()), static_cast<int>(*decimals));
    FileT result;
    result.name = "@name@.csv", result.media_type = "text/csv";
    result.content.assign(text.begin(), text.end());
    file.commit(result);
  }
};

}  // namespace

PLUMBLINE_PLUGIN("@name@", "0.1.0", "MIT", Writer)
