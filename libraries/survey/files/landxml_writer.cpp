#include <cmath>
#include <numbers>
#include <stdexcept>

#include "survey/files/landxml.hpp"
#include "survey/files/pointings.hpp"
#include "survey/files/survey_builder.hpp"
#include "survey/files/xml_file.hpp"

namespace plumbline::survey {
namespace {

using text::format_shortest;
using text::xml_escaped;

class LandXmlWriter {
 public:
  explicit LandXmlWriter(const SurveyObservations& survey) : survey_(survey) {}
  std::string write();

 private:
  void text(const char* attribute, const std::string& value) {
    out_ += std::string(" ") + attribute + "=\"" + xml_escaped(value) + "\"";
  }
  void number(const char* attribute, double value) {
    if (!std::isnan(value)) text(attribute, format_shortest(value));
  }
  void angle(const char* attribute, const Observation* observation) {
    if (observation) number(attribute, wrap_to_circle(observation->value) * (200.0 / std::numbers::pi));
  }
  void length(const char* attribute, const Observation* observation) {
    if (observation) number(attribute, observation->value);
  }
  void write_points();
  void write_set_up(std::size_t index);
  void write_observation(const Pointing& pointing);

  const SurveyObservations& survey_;
  std::string out_;
};

// North east height; points without a plane position cannot be written.
void LandXmlWriter::write_points() {
  out_ += "    <CgPoints>\n";
  for (const Point& point : survey_.points) {
    if (std::isnan(point.coordinates[0]) || std::isnan(point.coordinates[1])) continue;
    out_ += "      <CgPoint";
    text("name", point.id);
    if (!point.code.empty()) text("code", point.code);
    if (!point.description.empty()) text("desc", point.description);
    out_ += ">" + format_shortest(point.coordinates[1]) + " " + format_shortest(point.coordinates[0]);
    if (!std::isnan(point.coordinates[2])) out_ += " " + format_shortest(point.coordinates[2]);
    out_ += "</CgPoint>\n";
  }
  out_ += "    </CgPoints>\n";
}

void LandXmlWriter::write_set_up(std::size_t index) {
  const SetUp& set_up = survey_.set_ups[index];
  out_ += "    <InstrumentSetup";
  text("id", set_up.id);
  text("stationName", set_up.station);
  // The schema asks for a height; zero is what "the point is the axis" means.
  number("instrumentHeight", std::isnan(set_up.instrument_height) ? 0.0 : set_up.instrument_height);
  out_ += ">\n      <InstrumentPoint";
  text("pntRef", set_up.station);
  out_ += "/>\n    </InstrumentSetup>\n";
}

void LandXmlWriter::write_observation(const Pointing& pointing) {
  const Observation& any = *pointing.first;
  const double height = survey_.set_ups[any.set_up].instrument_height;
  if (!std::isnan(any.instrument_height) && any.instrument_height != (std::isnan(height) ? 0.0 : height))
    throw std::runtime_error("LandXML writer: cannot hold the observation " + text::quoted(any.from) + " to " +
                             text::quoted(any.to) + ": its instrument height differs from its set-up's");
  if (pointing.height_difference)
    throw std::runtime_error("LandXML writer: cannot hold the height difference " + text::quoted(any.from) + " to " +
                             text::quoted(any.to) + " as a raw observation");
  out_ += "      <RawObservation";
  angle("horizAngle", pointing.direction);
  angle("zenithAngle", pointing.zenith_angle);
  length("slopeDistance", pointing.slope_distance);
  length("horizDistance", pointing.horizontal_distance);
  number("targetHeight", any.target_height);
  if (any.face != 0) text("directFace", any.face == 2 ? "false" : "true");
  out_ += ">\n        <TargetPoint";
  text("name", any.to);
  out_ += "/>\n      </RawObservation>\n";
}

std::string LandXmlWriter::write() {
  out_ =
      "<?xml version=\"1.0\" encoding=\"UTF-8\"?>\n"
      "<LandXML xmlns=\"http://www.landxml.org/schema/LandXML-1.2\" version=\"1.2\" date=\"1970-01-01\" "
      "time=\"00:00:00\" readOnly=\"false\">\n"
      "  <Units>\n    <Metric areaUnit=\"squareMeter\" linearUnit=\"meter\" volumeUnit=\"cubicMeter\" "
      "temperatureUnit=\"celsius\" pressureUnit=\"milliBars\" angularUnit=\"grads\" directionUnit=\"grads\"/>\n"
      "  </Units>\n";
  if (!survey_.info.title.empty()) {
    out_ += "  <Project";
    text("name", survey_.info.title);
    out_ += "/>\n";
  }
  out_ += "  <Application name=\"Plumbline\"/>\n  <Survey>\n    <SurveyHeader name=\"survey\"/>\n";
  write_points();
  const std::vector<Pointing> pointings = pointings_of(survey_, "LandXML writer");
  for (std::size_t i = 0; i < survey_.set_ups.size(); ++i) write_set_up(i);
  int group = -1;
  for (const Pointing& pointing : pointings) {
    if (pointing.first->set_up != group) {
      if (group >= 0) out_ += "    </ObservationGroup>\n";
      group = pointing.first->set_up;
      out_ += "    <ObservationGroup";
      text("id", "group " + std::to_string(group + 1));
      text("setupID", survey_.set_ups[group].id);
      out_ += ">\n";
    }
    write_observation(pointing);
  }
  if (group >= 0) out_ += "    </ObservationGroup>\n";
  out_ += "  </Survey>\n</LandXML>\n";
  return std::move(out_);
}

}  // namespace

std::string write_landxml(const SurveyObservations& survey) { return LandXmlWriter(survey).write(); }

}  // namespace plumbline::survey
