// report.html: the report as a node.
#include <algorithm>
#include <cmath>
#include <optional>
#include <sstream>

#include "artifacts/accuracy.hpp"
#include "artifacts/as_built_changes.hpp"
#include "artifacts/block.hpp"
#include "artifacts/camera.hpp"
#include "artifacts/design.hpp"
#include "artifacts/deviation.hpp"
#include "artifacts/file.hpp"
#include "artifacts/folder.hpp"
#include "artifacts/input_files_text.hpp"
#include "artifacts/poses.hpp"
#include "artifacts/site_frames.hpp"
#include "artifacts/surfaces.hpp"
#include "artifacts/survey_comparison.hpp"
#include "artifacts/survey_network.hpp"
#include "artifacts/survey_observations.hpp"
#include "plumbline/node.hpp"
#include "show/report/dxf_node.hpp"
#include "show/report/excel_node.hpp"
#include "show/report/folder_pictures.hpp"
#include "show/report/format.hpp"
#include "show/report/language.hpp"
#include "show/report/network_page.hpp"
#include "show/report/photographs_node.hpp"
#include "show/report/report.hpp"
#include "show/report/sections.hpp"
#include "show/report/sheets_node.hpp"
#include "show/report/spoken_texts.hpp"
#include "show/report/summary.hpp"
#include "show/report/words_node.hpp"

namespace plumbline::report {

namespace {

/// "name=value" as the pipeline writes it.
Fact fact_of(const std::string& text) {
  const auto equals = text.find('=');
  if (equals == std::string::npos || equals == 0)
    throw std::runtime_error("parameter 'facts': '" + text + "' is not of the form name=value");
  return {text.substr(0, equals), text.substr(equals + 1)};
}

void add_design(const DesignT& design, std::vector<Fact>& facts) {
  std::string value = design.file_name + " (" + design.schema + ")";
  if (!design.project_name.empty()) value += ", project " + design.project_name;
  facts.emplace_back("Design", value);
}

void add_camera(const CameraT& camera, std::vector<Fact>& facts) {
  std::string text = camera.id + ", " + std::to_string(camera.width) + " × " + std::to_string(camera.height);
  if (camera.pixel_pitch > 0) text += " pixels of " + fixed(1e6 * camera.pixel_pitch, 2) + " µm";
  facts.emplace_back("Camera", text);
  for (const auto& other : camera.others) add_camera(*other, facts);
}

/// What the campaign was: anchors and floors, camera, total station.
void add_campaign(const AccuracyT& accuracy, const CameraT* camera, const SurveyInfoT* survey,
                  std::vector<Fact>& facts) {
  int highest = 0, control = 0;
  for (const auto& anchor : accuracy.anchors) {
    highest = std::max(highest, anchor->floor);
    control += anchor->use == AnchorUse::control;
  }
  const int check = static_cast<int>(accuracy.anchors.size()) - control;
  facts.emplace_back("Anchors", count(control, "control anchor", "control anchors") + " and " +
                                    count(check, "check anchor", "check anchors") + " on " +
                                    count(highest, "floor", "floors"));
  if (camera) add_camera(*camera, facts);
  if (survey && !survey->instrument.empty())
    facts.emplace_back(
        "Total station",
        survey->instrument + (survey->instrument_serial.empty() ? "" : ", serial number " + survey->instrument_serial));
}

/// What the photographs gave before the adjustment: two pose solvers do not give the same.
void add_images(const PosesT& poses, std::vector<Fact>& facts) {
  int inliers = 0, offered = 0;
  double squares = 0;
  for (const auto& pose : poses.poses) {
    inliers += pose->inliers, offered += pose->correspondences;
    squares += pose->rms * pose->rms;
  }
  const auto n = static_cast<double>(poses.poses.size());
  facts.emplace_back("Images with an approximate pose",
                     count(static_cast<long>(poses.poses.size()), "image", "images") + "; " + std::to_string(inliers) +
                         " of " + std::to_string(offered) + " tag corners agree, RMS " +
                         fixed(std::sqrt(squares / n), 3) + " px before the adjustment");
}

/// Every transform between the frames of the site.
void add_frames(const SiteFramesT& frames, std::vector<Fact>& facts) {
  for (const auto& link : frames.links) {
    const TransformT& transform = *link->transform;
    const RigidTransform& t = transform.to_from_from;
    const double turn = Eigen::AngleAxisd(t.rotation).angle();
    const bool same = std::abs(turn) < 1e-15 && t.translation.norm() < 1e-12 && transform.scale == 1;
    std::string text = transform.origin;
    if (!same)
      text += ": turned by " + fixed(turn * 180 / M_PI, 6) + "°" + (transform.plan_only ? " about the vertical" : "") +
              ", shifted by " + fixed(t.translation.x(), 4) + ", " + fixed(t.translation.y(), 4) + ", " +
              fixed(t.translation.z(), 4) + "\u00A0m, scale " + fixed(transform.scale, 8) +
              (transform.plan_only && transform.scale != 1 ? " in the plan" : "");
    if (transform.covariance.size() >= 21)
      text += "; standard deviations of the shift " + mm(std::sqrt(transform.covariance[9])) + ", " +
              mm(std::sqrt(transform.covariance[14])) + ", " + mm(std::sqrt(transform.covariance[20])) + "\u00A0mm";
    facts.emplace_back("Frames: " + link->from + " \u2192 " + link->to, text);
  }
}

}  // namespace

struct ReportHtml : Node {
  static constexpr Info info{"report.html", "", 8,
                             "One offline HTML file: verdict, charts, tables, survey network, provenance"};
  In<Accuracy> accuracy{"accuracy", frame("frame=?F"), "the evaluation"};
  Optional<Deviation> deviation{"deviation", frame("frame=?F"), "as-built minus design, judged: the first screen"};
  Optional<AsBuiltChanges> changes{"changes", frame("frame=?F"), "what became of anchors since the campaign before"};
  Optional<Block> block{"block", frame("frame=?B"), "the adjustment of the images, with what it rejected"};
  Optional<Poses> poses{"poses", frame("frame=?P"), "the poses before the adjustment"};
  Optional<SiteFrames> frames{"frames", "the frames of the site, for the provenance"};
  Optional<SurveyNetwork> network{"network", frame("frame=?S"), "the adjusted survey network, for its page"};
  Optional<SurveyComparison> control_check{"control_check", frame("frame=?S"),
                                           "the control points tested against the network, for a warning"};
  Optional<Design> design{"design", frame("frame=?F"), "the design, for the provenance"};
  Optional<Camera> camera{"camera", "the calibrated camera, for the provenance"};
  Optional<SurveyObservations> survey{"survey", frame("frame=?S"),
                                      "the survey as read: its title stands under the heading, its instrument in the "
                                      "provenance"};
  Optional<Surfaces> surfaces{"surfaces", frame("frame=?F"), "panels as they are: colours behind the anchors"};
  Optional<Folder> orthophoto{"orthophoto", "of surface.orthophoto: the facade's picture behind the anchors"};
  Optional<Folder> photographs{"photographs", "of report.photographs: parts of them around what is not in order"};
  Optional<InputFiles> inputs{"inputs",
                              "the files that were read, and evidence that was set aside, for the provenance"};
  Optional<InputFiles> unread{"unread", "what else lay in the folder, for the provenance"};
  Param<std::string> title{"title", "Accuracy of the facade anchors", "heading"};
  Param<std::string> subtitle{"subtitle", "", "site, scenario, date of the campaign; empty: the title of the survey"};
  Param<std::vector<std::string>> facts{"facts", std::vector<std::string>{}, "lines for the provenance: name=value"};
  Param<std::string> pipeline{"pipeline", "",
                              "what ran, for the provenance: a line 'node: kind parameter=value' for each node, as "
                              "${pipeline} gives it"};
  Param<std::string> command{"command", "",
                             "what was typed, as ${command} gives it: the page offers it with what mends"};
  Param<std::string> language{"language", "en", one_of("en", "de"), "of the page"};
  Param<std::string> units{"units", "mm", one_of("mm", "in"), "of lengths on the page; data files keep theirs"};
  Out<File> out{"file", "report.html"};

  void run(Context& context) override {
    const Speaking speaking(speech_of(*language, *units));
    ReportInput input;
    if (surfaces) input.surfaces = surfaces.unpack();
    if (orthophoto) input.pictures = read_pictures(context, orthophoto.unpack());
    input.title = *title, input.subtitle = *subtitle, input.command = *command;
    input.accuracy = accuracy.unpack();
    if (changes) input.changes = changes.unpack();
    if (deviation) input.deviation = deviation.unpack();
    if (block) input.block = block.unpack();
    if (poses) add_images(poses.unpack(), input.images);
    if (network) input.network = network_page(network.unpack());
    if (control_check) input.control_check = control_check.unpack();
    CameraT read_camera;
    SurveyInfoT survey_info;
    if (camera) read_camera = camera.unpack();
    if (survey && survey->info()) survey->info()->UnPackTo(&survey_info);
    if (input.subtitle.empty()) input.subtitle = survey_info.title;
    if (!survey_info.date.empty() && input.subtitle.find(survey_info.date) == std::string::npos)
      input.subtitle += (input.subtitle.empty() ? "" : ", ") + spoken("measured " + survey_info.date);
    for (const std::string& text : *facts) input.provenance.push_back(fact_of(text));
    add_campaign(input.accuracy, camera ? &read_camera : nullptr, survey ? &survey_info : nullptr, input.provenance);
    if (!survey_info.date.empty()) input.provenance.emplace_back("Measured", survey_info.date);
    if (design) {
      const DesignT read = design.unpack();
      add_design(read, input.provenance);
      input.grid = ifc::grid_of(read), input.building = building_lines(read);
    }
    if (frames) add_frames(frames.unpack(), input.provenance);
    input.provenance.emplace_back("Program", std::string("Plumbline ") + PLUMBLINE_BUILD_ID);
    if (photographs) input.photographs = read_photographs(context, photographs.unpack());
    add_nodes(*pipeline, input.provenance);
    add_input_files(inputs ? inputs.unpack() : InputFilesT(), unread ? unread.unpack() : InputFilesT(),
                    used_of(network, used_images(block)), input);
    FileT file;
    file.name = "report.html", file.media_type = "text/html";
    const std::string html = render_report(input);
    file.content.assign(html.begin(), html.end());
    out.commit(file);
  }
};

struct ReportSummary : Node {
  static constexpr Info info{"report.summary", "", 5, "Writes the result of an evaluation as a few lines of text"};
  In<Accuracy> accuracy{"accuracy", frame("frame=?F"), "the evaluation"};
  Optional<Deviation> deviation{"deviation", frame("frame=?F"), "as-built minus design, judged"};
  Optional<AsBuiltChanges> changes{"changes", frame("frame=?F"), "what became of anchors since the campaign before"};
  Optional<Block> block{"block", frame("frame=?B"), "the adjustment of the images: how many of them took part"};
  Optional<SurveyNetwork> network{"network", frame("frame=?S"), "the adjusted survey: which readings were left out"};
  Optional<InputFiles> inputs{"inputs", "the files that were read, and evidence that was set aside"};
  Optional<InputFiles> unread{"unread", "what else lay in the folder"};
  Param<std::string> language{"language", "en", one_of("en", "de"), "of the text"};
  Param<std::string> units{"units", "mm", one_of("mm", "in"), "of lengths in it; data files keep theirs"};
  Out<File> out{"file", "summary.txt"};

  void run(Context&) override {
    const Speaking speaking(speech_of(*language, *units));
    FileT file;
    file.name = "summary.txt", file.media_type = "text/plain";
    std::optional<DeviationT> built;
    if (deviation) built = deviation.unpack();
    std::optional<AsBuiltChangesT> changed;
    if (changes) changed = changes.unpack();
    std::optional<InputFilesT> read, left;
    if (inputs) read = inputs.unpack();
    if (unread) left = unread.unpack();
    const std::string text = summary_text(accuracy.unpack(), built ? &*built : nullptr, changed ? &*changed : nullptr) +
                             spoken_lines(words_of_inputs(read ? &*read : nullptr, left ? &*left : nullptr,
                                                          used_of(network, used_images(block))));
    file.content.assign(text.begin(), text.end());
    out.commit(file);
  }
};

}  // namespace plumbline::report

PLUMBLINE_PLUGIN("report", PLUMBLINE_BUILD_ID, "MIT", plumbline::report::ReportHtml, plumbline::report::ReportSummary,
                 plumbline::report::ReportExcel, plumbline::report::ReportDxf, plumbline::report::ReportSheets,
                 plumbline::report::ReportPhotographs, plumbline::report::ReportWords)
