#include "formats/gama.hpp"
#include "formats/gsi.hpp"
#include "formats/landxml.hpp"
#include "formats/survey_artifact.hpp"
#include "formats/survey_csv.hpp"
#include "nodes.hpp"

namespace plumbline::survey_files {

void WriterNode::deliver(const std::string& name, const char* media_type, const std::string& content) const {
  FileT result;
  result.name = name;
  result.media_type = media_type;
  result.content.assign(content.begin(), content.end());
  file.commit(result);
}

void WriteGsi::run(Context&) {
  survey::GsiWriteOptions options;
  if (*station_start == "station_coordinates") options.station_start = survey::GsiStationStart::station_coordinates;
  options.distance_unit = *resolution == "1 mm" ? 0 : *resolution == "0.1 mm" ? 6 : 8;
  deliver("survey.gsi", "text/plain", survey::write_gsi(survey::from_artifact(observations.unpack()), options));
}

void WriteGama::run(Context&) {
  deliver("survey.gkf", "application/xml", survey::write_gama_xml(survey::from_artifact(observations.unpack())));
}

void WriteLandXml::run(Context&) {
  deliver("survey.xml", "application/xml", survey::write_landxml(survey::from_artifact(observations.unpack())));
}

void WriteSurveyCsv::run(Context&) {
  deliver("survey.csv", "text/csv", survey::write_survey_csv(survey::from_artifact(observations.unpack())));
}

}  // namespace plumbline::survey_files
