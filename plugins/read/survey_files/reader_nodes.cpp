#include "artifacts/input_files_text.hpp"
#include "artifacts/survey_artifact.hpp"
#include "nodes.hpp"
#include "survey/files/dynaml.hpp"
#include "survey/files/field_books.hpp"
#include "survey/files/gama.hpp"
#include "survey/files/gsi.hpp"
#include "survey/files/jobxml.hpp"
#include "survey/files/krumm.hpp"
#include "survey/files/landxml.hpp"
#include "survey/files/rw5.hpp"
#include "survey/files/sdr33.hpp"
#include "survey/files/starnet.hpp"
#include "survey/files/survey_csv.hpp"
#include "survey/files/survey_format.hpp"
#include "survey/files/zeiss.hpp"

namespace plumbline::survey_files {
namespace {

constexpr size_t skipped_shown = 10;

}  // namespace

std::string_view ReaderNode::bytes() const {
  const auto* content = file->content();
  return {reinterpret_cast<const char*>(content->data()), content->size()};
}

void ReaderNode::deliver(Context& context, const survey::SurveyObservations& survey) const {
  if (*strict && !survey.skipped.empty()) {
    const survey::SkippedLine& first = survey.skipped.front();
    const size_t more = survey.skipped.size() - 1;
    throw std::runtime_error(
        survey::place(first.source) + ": found " + first.found + ", expected " + first.expected +
        (more > 0 ? "; and " + std::to_string(more) + " more that cannot be used" : "") +
        ". Mend the file, or read its good part with strict=false; what was skipped is then listed");
  }
  for (const std::string& warning : survey.warnings) context.warn(name() + ": " + warning);
  for (size_t i = 0; i < survey.skipped.size() && i < skipped_shown; ++i)
    context.warn(survey::place(survey.skipped[i].source) + ": skipped " + survey.skipped[i].found + ", expected " +
                 survey.skipped[i].expected);
  if (survey.skipped.size() > skipped_shown)
    context.warn(name() + ": " + std::to_string(survey.skipped.size() - skipped_shown) +
                 " more places skipped; all are listed in the output");
  const SurveyObservationsT read = survey::to_artifact(survey);
  context.info(name() + ": " + counted(readings_of(read), "reading", "readings") + ", " +
               counted(static_cast<long>(read.set_ups.size()), "set-up", "set-ups") + ", " +
               counted(static_cast<long>(read.points.size()), "point", "points"));
  observations.commit(read);
}

void ReadGsi::run(Context& context) {
  survey::GsiOptions options;
  options.station_codes = {
      {*station_code, static_cast<int>(*station_word), static_cast<int>(*height_word), *height_unit}};
  if (*vertical_reference == "horizon") options.vertical_reference = survey::GsiVerticalReference::horizon;
  if (*vertical_reference == "percent") options.vertical_reference = survey::GsiVerticalReference::percent;
  options.us_survey_foot = *foot == "us_survey";
  deliver(context, survey::read_gsi(bytes(), name(), options));
}

void ReadLandXml::run(Context& context) { deliver(context, survey::read_landxml(bytes(), name())); }
void ReadJobXml::run(Context& context) { deliver(context, survey::read_jobxml(bytes(), name())); }
void ReadSdr33::run(Context& context) { deliver(context, survey::read_sdr33(bytes(), name())); }
void ReadRw5::run(Context& context) { deliver(context, survey::read_rw5(bytes(), name())); }
void ReadZeiss::run(Context& context) { deliver(context, survey::read_zeiss(bytes(), name())); }
void ReadNikon::run(Context& context) { deliver(context, survey::read_nikon(bytes(), name())); }
void ReadTopconGts7::run(Context& context) { deliver(context, survey::read_topcon_gts7(bytes(), name())); }
void ReadTopconGts210::run(Context& context) { deliver(context, survey::read_topcon_gts210(bytes(), name())); }
void ReadGeodimeter::run(Context& context) { deliver(context, survey::read_geodimeter(bytes(), name())); }
void ReadTopconLevel::run(Context& context) { deliver(context, survey::read_topcon_level(bytes(), name())); }
void ReadIdx::run(Context& context) { deliver(context, survey::read_idx(bytes(), name())); }
void ReadStarNet::run(Context& context) { deliver(context, survey::read_starnet(bytes(), name())); }
void ReadDynaMl::run(Context& context) { deliver(context, survey::read_dynaml(bytes(), name())); }
void ReadGama::run(Context& context) { deliver(context, survey::read_gama_xml(bytes(), name())); }
void ReadKrumm::run(Context& context) { deliver(context, survey::read_krumm(bytes(), name())); }

static std::string unit_or_none(const std::string& unit) { return unit == "automatic" ? "" : unit; }

void ReadSurveyCsv::run(Context& context) {
  deliver(context,
          survey::read_survey_csv(bytes(), name(), {*columns, unit_or_none(*angle_unit), unit_or_none(*length_unit)}));
}

void ReadSetupCoordinates::run(Context& context) {
  deliver(context, survey::read_setup_coordinates(bytes(), name(), {*columns, "gon", unit_or_none(*length_unit)}));
}

void ReadSurvey::run(Context& context) {
  if (readings)
    for (const auto& part : readings.unpack().files)
      if (part->path == name()) {
        if (!part->observations)
          throw std::runtime_error(name() + " was offered to " + part->reader + ", and nobody has read it: connect " +
                                   "survey.collect, not survey.file_for, to 'readings'");
        context.info(name() + " is read by " + part->reader);
        return deliver(context, survey::from_artifact(*part->observations));
      }
  if (const auto format = survey::detect_survey_format(bytes(), name()))
    context.info(name() + " is " + survey::long_name(*format));
  deliver(context, survey::read_survey(bytes(), name(), unit_or_none(*angle_unit)));
}

}  // namespace plumbline::survey_files
