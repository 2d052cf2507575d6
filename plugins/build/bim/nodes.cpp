// bim.read_ifc and bim.write_ifc: the design in, the as-built state out; match.elements between them.
#include <algorithm>
#include <optional>
#include <stdexcept>

#include "artifacts.hpp"
#include "artifacts/accuracy.hpp"
#include "artifacts/as_built_changes.hpp"
#include "artifacts/block.hpp"
#include "artifacts/deviation.hpp"
#include "artifacts/file_artifact.hpp"
#include "artifacts/input_files.hpp"
#include "artifacts/plates.hpp"
#include "artifacts/surface_judgement.hpp"
#include "artifacts/surfaces.hpp"
#include "artifacts/survey_network.hpp"
#include "artifacts/survey_observations.hpp"
#include "building/ifc/as_built_ifc.hpp"
#include "building/ifc/bcf.hpp"
#include "building/ifc/ifc_guid.hpp"
#include "building/judgement/worst_first.hpp"
#include "check_node.hpp"
#include "design_file.hpp"
#include "ids_node.hpp"
#include "installation_nodes.hpp"
#include "instant.hpp"
#include "match_node.hpp"
#include "plumbline/node.hpp"

namespace plumbline::ifc {
namespace {

/// What to do where nobody says when it was measured: a survey's date stands in its campaign, a scan's is said to the
/// run.
std::string undated(bool by_survey, const std::string& so, const std::string& parameter) {
  return by_survey ? "the survey does not say when it was measured: " + so + "; 'date' in campaign.yaml or '" +
                         parameter + "' says it"
                   : "nobody says when it was measured: " + so + "; '" + parameter +
                         "' says it (of scan_surfaces measured=2026-05-12T10:30:00)";
}

struct ReadIfc : Node {
  static constexpr Info info{"bim.read_ifc", "", 6,
                             "Reads storeys, elements, anchors and panels from an IFC file (IFC2X3, IFC4, IFC4X3)"};
  In<plumbline::File> file{"file", "the IFC file: STEP text, ifcZIP or ifcXML"};
  Optional<Plates> plates{"plates", "anchor table: elements of these names (or tags) are anchors too"};
  Param<std::vector<std::string>> anchors{
      "anchors", {"IfcMechanicalFastener", "IfcDiscreteAccessory"}, "IFC classes whose elements are facade anchors"};
  Param<std::string> anchor_pattern{
      "anchor_pattern", "",
      "regular expression; elements whose name, object type, type name or tag it finds are anchors too"};
  Param<std::vector<std::string>> anchor_selection{
      "anchor_selection", std::vector<std::string>{},
      "elements that are anchors too, such as 'class=IfcPlate & name~^ANKER' or 'Pset_X.Kind=anchor'"};
  Param<std::vector<std::string>> anchor_guids{"anchor_guids", std::vector<std::string>{},
                                               "GlobalIds of elements that are anchors too"};
  Optional<plumbline::File> mapping{"mapping", "mapping table: the elements that it leads to are anchors too"};
  Param<std::vector<std::string>> panel_selection{
      "panel_selection", std::vector<std::string>{},
      "elements that are facade panels, such as 'class=IfcWall & name~^FT-'; empty: IfcPlate, IfcCurtainWall, "
      "IfcCovering "
      "that is CLADDING, and walls that hang before anchors which hold none of these; 'none': nothing "
      "is "
      "a panel"};
  Param<std::vector<std::string>> facades{
      "facades", std::vector<std::string>{},
      "which way anchors and panels face, where the design does not say it or says it wrongly: 'name~^N-: "
      "azimuth=0deg, name=North' (clockwise from the y axis of the design), 'storey=Roof: out=up', '*: confirmed' "
      "(what was guessed is right); later rules before earlier ones"};
  Param<bool> all_shapes{"all_shapes", false,
                         "read where every element's shape is, and not only those of anchors, panels and some of the "
                         "others; it is most of the work"};
  Out<plumbline::Design> design{"design", frame("frame=building"), "the design in the project frame"};
  Out<Points> anchor_points{"anchors", frame("frame=building"), "reference points of the anchors"};

  AnchorRule rule() const {
    AnchorRule rule{*anchors, *anchor_pattern, *anchor_guids, {}, *anchor_selection, *all_shapes, *panel_selection, {}};
    if (plates)
      for (const auto& plate : plates.unpack().plates) rule.names.push_back(plate->anchor);
    if (mapping)
      for (const MappingRow& row : mapping_rows(mapping.unpack())) rule.names.push_back(row.element);
    for (const std::string& text : *facades) rule.facades.push_back(parse_facade_rule(text));
    return rule;
  }

  void run(Context& context) override {
    const auto index = index_of(*file, context);
    if (index->was_xml())
      context.info(index->name() +
                   " is ifcXML: it is read as the STEP file that says the same, and the as-built model is "
                   "written as that STEP file with the additions");
    const Design result = read_design(*index, rule());
    for (const std::string& warning : result.warnings) context.warn(warning);
    const PointsT points = ifc::anchor_points(result);
    context.info("storeys: " + std::to_string(result.storeys.size()) + ", elements: " +
                 std::to_string(result.elements.size()) + ", of them anchors: " + std::to_string(points.points.size()));
    design.commit(to_artifact(result));
    anchor_points.commit(points);
  }
};

struct WriteIfc : Node {
  static constexpr Info info{"bim.write_ifc", "bim_writer", 6,
                             "Writes (14) and dz into a copy of the design IFC, as property sets and small solids"};
  In<plumbline::File> design_file{"design_file", "the design IFC; its own lines stay as they are"};
  In<plumbline::Design> design{"design", frame("frame=?F"), "what bim.read_ifc read from that file"};
  In<Deviation> deviation{"deviation", frame("frame=?F"), "as-built minus design, judged"};
  In<Accuracy> accuracy{"accuracy", frame("frame=?F"), "evaluation against the survey"};
  Optional<SurveyObservations> survey{"survey", frame("frame=?S"),
                                      "the survey as read: instrument and date of the provenance"};
  Optional<InputFiles> inputs{"inputs", "the files that were read, for their hashes, and what was set aside"};
  Optional<Block> block{"block", frame("frame=?B"), "the adjustment of the images: how many of them took part"};
  Optional<SurveyNetwork> network{"network", frame("frame=?N"),
                                  "the adjusted survey: how many of its readings took part"};
  Optional<Surfaces> surfaces{"surfaces", frame("frame=?F"), "panels and joints as they were measured"};
  Param<bool> survey_points{"survey_points", true, "an IfcAnnotation at every measured position"};
  Param<bool> solids{"solids", true, "a small solid of the verdict's colour there, and a thin one for every panel"};
  Param<std::string> epoch{"epoch", "",
                           "name of the campaign, such as 2026-05; campaigns of different names can stand in one file"};
  Param<int64_t> timestamp{"timestamp", 0, "s", at_least(0),
                           "date of the additions since 1970; 0: when it was measured"};
  Param<std::string> file_name{"file_name", "as_built.ifc", "name of the file"};
  Param<std::string> method{"method", "photogrammetry under survey control", "for ASB_Provenance"};
  Param<std::string> instrument{"instrument", "", "for ASB_Provenance; empty: that of the survey"};
  Param<std::string> observation_time{"observation_time", "",
                                      "for ASB_Provenance, ISO 8601; empty: that of the survey"};
  Param<std::string> run_id{"run_id", "", "for ASB_Provenance; empty: derived from the hashes of the inputs"};
  Param<std::string> document{
      "document", "report.html",
      "where the report lies, beside the file or as a URL, for the document reference; empty: none"};
  Out<plumbline::File> out{"file", "the as-built IFC, by reference"};

  std::optional<Instant> measured_at() const {
    if (!observation_time->empty()) {
      const auto given = instant_of(*observation_time);
      if (!given)
        throw std::runtime_error("parameter 'observation_time' is '" + *observation_time +
                                 "', expected a date such as 2026-05-12T10:30:00");
      return given;
    }
    if (survey && survey->info() && survey->info()->date())
      if (const auto of_survey = instant_of(survey->info()->date()->str())) return of_survey;
    return {};
  }

  void add_provenance(const Design& read, const std::optional<Instant>& when, AsBuiltIfcOptions& options) const {
    std::string instrument_name = *instrument;
    if (instrument_name.empty() && survey && survey->info()) {
      SurveyInfoT of_survey;
      survey->info()->UnPackTo(&of_survey);
      instrument_name = of_survey.instrument;
      if (!of_survey.instrument_serial.empty()) instrument_name += ", serial number " + of_survey.instrument_serial;
    }
    std::string run = *run_id;
    if (inputs) {
      std::string all;
      for (const auto* file : *inputs->files()) {
        const std::string hashed = file->path()->str() + " " + file->sha256()->str();
        (file->read() ? options.input_hashes : options.unused_hashes).push_back(hashed);
        if (file->read()) all += hashed;
      }
      if (run.empty()) run = derived_ifc_guid(read.project_guid, all);
      options.image_count = block && block->images() ? block->images()->size() : inputs->images();
      if (network) options.readings_left_out = network->readings_left_out();
      options.reading_count = std::max<std::int64_t>(0, inputs->readings() - options.readings_left_out);
    }
    options.provenance = {{"Method", *method},
                          {"Instrument", instrument_name},
                          {"ObservationTime", when ? when->text : ""},
                          {"AdjustmentRunId", run},
                          {"DesignFile", read.file_name},
                          {"SoftwareVersion", "Plumbline " PLUMBLINE_BUILD_ID}};
  }

  void run(Context& context) override {
    const auto index = index_of(*design_file, context);
    const step::File& file = *index;
    const Design read = from_artifact(design.unpack());
    const auto when = measured_at();
    AsBuiltIfcOptions options{*epoch, *timestamp, *survey_points, *solids, {}, {}, {}, -1};
    if (options.timestamp == 0 && when) options.timestamp = when->seconds;
    if (options.timestamp == 0)
      context.warn(
          undated(static_cast<bool>(survey), "the additions carry the latest date of the design", "observation_time"));
    add_provenance(read, when, options);
    options.document = *document;
    SurfacesT measured;
    if (surfaces) measured = surfaces.unpack(), options.surfaces = &measured;
    const DeviationT judged = deviation.unpack();
    for (const auto& anchor : judged.anchors)
      if (!anchor->as_built.allFinite() && !anchor->as_built.array().isNaN().all())  // all unknown: not measured
        throw std::runtime_error("anchor '" + anchor->id +
                                 "' has no as-built position in all of x, y and z, so it cannot be written: measure it "
                                 "whole, or leave it out of plates.csv");
    options.surface_judgement = judged.surfaces.get();
    const AsBuiltIfc result = write_as_built(file, read, judged, accuracy.unpack(), options);
    for (const std::string& warning : result.warnings) context.warn(warning);
    const auto folder = out.make_folder();
    const std::string path = folder.path + "/as_built.ifc";
    write_enriched(file, result, path);
    out.commit(file_reference(*file_name, "application/x-step", folder.uri + "/as_built.ifc", context.digest(path)));
  }
};

struct WriteBcf : Node {
  static constexpr Info info{"bim.write_bcf", "", 8,
                             "Issues in BCF 2.1 or 3.0: a topic with viewpoint and snapshot for every failing or "
                             "undecided anchor, panel and surface"};
  In<Deviation> deviation{"deviation", frame("frame=?F"), "as-built minus design, judged"};
  In<plumbline::Design> design{"design", frame("frame=?F"), "the design, for the ids"};
  Optional<SurveyObservations> survey{"survey", frame("frame=?S"), "the survey as read: the date of the topics"};
  Optional<Surfaces> surfaces{"surfaces", frame("frame=?F"), "panels and joints as they were measured"};
  Optional<AsBuiltChanges> changes{
      "changes", frame("frame=?F"),
      "since the campaign before: what was mended is closed, what nobody measured again stays open"};
  Param<std::string> version{"version", "2.1", one_of("2.1", "3.0"), "of BCF: every BIM program reads 2.1"};
  Param<std::string> epoch{
      "epoch", "",
      "name of the campaign, as bim.write_ifc has it: a label of the topics, and where the solids of the as-built file "
      "have their ids from"};
  Param<std::string> date{"date", "", "of the topics, ISO 8601; empty: that of the survey"};
  Param<std::string> author{"author", "plumbline", "of the topics"};
  Param<std::string> assigned_to{"assigned_to", "", "of the topics; empty: nobody"};
  Param<std::string> due_date{"due_date", "", "of the topics, ISO 8601; empty: none"};
  Out<plumbline::File> out{"file", "issues.bcf"};

  static std::string date_of(const std::string& text, const char* parameter) {
    if (text.empty()) return "";
    const auto instant = instant_of(text);
    if (!instant)
      throw std::runtime_error(std::string("parameter '") + parameter + "' is '" + text +
                               "', expected a date such as 2026-05-12");
    return instant->text;
  }

  void run(Context& context) override {
    BcfOptions options;
    options.project_guid = design->project_guid()->str();
    options.version_3 = *version == "3.0";
    options.epoch = *epoch, options.author = *author, options.assigned_to = *assigned_to;
    options.due_date = date_of(*due_date, "due_date");
    std::string when = date_of(*date, "date");
    if (when.empty() && survey && survey->info() && survey->info()->date())
      if (const auto instant = instant_of(survey->info()->date()->str())) when = instant->text;
    if (when.empty())
      context.warn(undated(static_cast<bool>(survey), "the BCF topics are dated 1970", "date"));
    else
      options.date = when;
    FileT to;
    to.name = "issues.bcf";
    to.media_type = "application/zip";
    const DeviationT judged = deviation.unpack();
    SurfacesT measured;
    if (surfaces) measured = surfaces.unpack(), options.surfaces = &measured;
    options.surface_judgement = judged.surfaces.get();
    if (judged.surfaces && !surfaces)
      context.warn("the deviation has verdicts of surfaces; connect 'surfaces' too, or they have no topics");
    const Design designed = from_artifact(design.unpack());
    options.elements = &designed.elements;
    AsBuiltChangesT since;
    if (changes) since = changes.unpack();
    if (since.compared) options.changes = &since;
    const std::string bytes =
        write_bcf(judged, judgement::worst_first(judged), judgement::worst_panels_first(judged), options);
    to.content.assign(bytes.begin(), bytes.end());
    out.commit(to);
  }
};

}  // namespace
}  // namespace plumbline::ifc

PLUMBLINE_PLUGIN("bim", PLUMBLINE_BUILD_ID, "MIT", plumbline::ifc::ReadIfc, plumbline::ifc::MatchElements,
                 plumbline::ifc::WriteIfc, plumbline::ifc::WriteBcf, plumbline::ifc::CheckIfc, plumbline::ifc::WriteIds,
                 plumbline::ifc::WriteInstallation, plumbline::ifc::WriteInstallationBcf)
