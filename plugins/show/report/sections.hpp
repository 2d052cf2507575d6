// The parts of the report, each a <section>; render_report() puts them in order.
#pragma once

#include <functional>
#include <string>
#include <vector>

#include "artifacts/input_files.hpp"
#include "artifacts/input_files_text.hpp"
#include "artifacts/survey_plan.hpp"
#include "building/judgement/worst_first.hpp"
#include "show/report/markup.hpp"
#include "show/report/report.hpp"

namespace plumbline::report {

/// A whole page with style and script around `write_content`.
std::string render_page(const std::string& title, const std::function<void(Markup&)>& write_content);

/// "out of plane", from the name of an axis or of what decides.
std::string words_of(std::string name);
using judgement::deciding_axis;
using judgement::worst_first;
using judgement::worst_panels_first;

/// The comparison of the anchors of one use against one reference; null if there is none.
const AccuracyComparisonT* comparison(const AccuracyT& accuracy, AnchorUse use, AccuracyReference reference);
/// The one that the report argues with: check anchors against the survey, else control anchors; null without any.
const AccuracyComparisonT* headline(const AccuracyT& accuracy);
/// "check anchors" or "control anchors".
std::string anchors_of(const AccuracyComparisonT& comparison);

/// A cell of a table; numbers stand right, words left.
struct Cell {
  Cell(const char* content) : text(content) {}
  Cell(std::string content) : text(std::move(content)) {}
  std::string text;
  bool left = false, sentence = false;
};
inline Cell left(std::string text) {
  Cell cell(std::move(text));
  cell.left = true;
  return cell;
}
/// A cell whose words go on in the next line where there is no room.
inline Cell sentence(std::string text) {
  Cell cell(std::move(text));
  cell.sentence = true;
  return cell;
}
/// One row; the first cell is its heading.
void table_row(Markup& html, const std::vector<Cell>& cells);
/// Table head; scripts can sort by every column of a table of class "sortable".
void table_head(Markup& html, const std::vector<Cell>& labels);
/// A part that is folded on a screen with scripts, and open without them and on paper: nothing is lost in print.
void folded(Markup& html, const std::string& summary, const std::function<void()>& content,
            const std::string& paper = "");
/// Cell with a verdict; a dash where there is none.
void verdict_cell(Markup& html, ToleranceVerdict verdict);

/// Anchors and panels that are more than anybody reads one by one: drawings are of shapes without names, and lists give
/// what is to be mended first; every number stands in metrics.csv and stake_out.csv.
bool many(const DeviationT& deviation);
/// Opens the row of an anchor or panel, which the page's search goes by; ends with the scope.
class PlacedRow {
 public:
  PlacedRow(Markup& html, int floor, const std::string& facade, ToleranceVerdict verdict);

 private:
  Scope row_;
};
/// Name of its facade; empty if it is in none that is known.
std::string facade_of(const std::unique_ptr<FacadeFrameT>& frame);
/// Search and selection by facade, floor and verdict, for all rows of PlacedRow; hidden without scripts.
void write_filter(Markup& html, const DeviationT& deviation);

/// First screen: can we install, where not and what to do, how sure. Nothing without a design.
void write_installation(Markup& html, const ReportInput& input);
/// Its headline: "Not ready: 2 anchors and 1 panel are out of tolerance."
std::string installation_heading(const DeviationT& d, int panels_failed, int panels_open);
/// How floors, and facades where there are several, stand.
void write_overview(Markup& html, const DeviationT& deviation);
/// Anchors and panels in space, and the numbers that the slider and the view recompute from.
void write_view(Markup& html, const ReportInput& input);
/// Is the model right: the check anchors against the survey.
void write_verdict(Markup& html, const ReportInput& input);
/// All warnings, the cause before its consequences.
void write_warnings(Markup& html, const ReportInput& input);
/// Commands that run it again with what mends it, where something does.
void write_commands(Markup& html, const ReportInput& input);
/// The adjustment of the images: tests, groups, what was rejected.
void write_block(Markup& html, const ReportInput& input);
void write_key_numbers(Markup& html, const AccuracyT& accuracy);
void write_floors(Markup& html, const AccuracyT& accuracy);
void write_transfers(Markup& html, const AccuracyT& accuracy);
void write_pass_rates(Markup& html, const AccuracyT& accuracy);
void write_facade(Markup& html, const ReportInput& input);
/// The elevation of one floor of a facade, with names; `facade` null: of the anchors that belong to none.
void write_floor_elevation(Markup& html, const ReportInput& input, const FacadeT* facade, int floor);
/// What an anchor or panel that is not in order asks for, as the first screen says it.
std::string what_to_do(const AnchorDeviationT& anchor, const DeviationT& deviation);
std::string what_to_do(const PanelDeviationT& panel, const DeviationT& deviation);
/// Floors and grid axes of each facade, with mean and scatter of their anchors.
void write_places(Markup& html, const ReportInput& input);
/// "A/4": the axes of the grid nearest to a place; empty without a grid.
std::string place_in_grid(const ReportInput& input, const Eigen::Vector3d& design);
void write_panels(Markup& html, const DeviationT& deviation);
void write_coverage(Markup& html, const DeviationT& deviation);
/// What became of anchors and panels since the campaign before; nothing without one.
void write_changes(Markup& html, const AsBuiltChangesT& changes);
void write_photographs(Markup& html, const AnchorPhotographs& photographs);
/// "Since 2026-05".
std::string since(const AsBuiltChangesT& changes);
/// Verdicts of surfaces, the failing ones first.
void write_surfaces(Markup& html, const SurfaceJudgementT& judgement);
/// "12 pass, 1 undecided, 0 fail, 2 not judged".
std::string surface_counts(const SurfaceJudgementT& judgement);
/// "Panel 3", "Panel 3 | Panel 4".
std::string surface_name(const SurfaceVerdictT& verdict);
/// Those that fail, then those that are too close to call.
std::vector<const SurfaceVerdictT*> worst_surfaces_first(const SurfaceJudgementT& judgement);
/// Panels and joints of which a quantity has that verdict, each once.
int surfaces_with(const SurfaceJudgementT& judgement, ToleranceVerdict verdict);
/// "at most 3.0", "-4.0 to 3.0" [mm].
std::string surface_limit(const SurfaceVerdictT& verdict);
void write_anchors(Markup& html, const ReportInput& input);
void write_method(Markup& html, const AccuracyT& accuracy);
/// `control` is the test of the control points against the network; null: none.
void write_network(Markup& html, const NetworkPage& network, const SurveyComparisonT* control = nullptr);
/// A box at the head of the page if control points do not fit the observations; nothing if they do.
void write_control_warning(Markup& html, const SurveyComparisonT& control);
/// The test of the control points, with a table of all of them.
void write_control_check(Markup& html, const SurveyComparisonT& control);
void write_epochs(Markup& html, const SurveyComparisonT& comparison);
void write_plan(Markup& html, const SurveyPlanT& plan);
/// A line for each node of the pipeline (as ${pipeline} gives them): two solvers that give the same bits are still two.
void add_nodes(const std::string& pipeline, std::vector<Fact>& facts);
/// What was read, what was set aside and what else lay in the folder: files with their hashes, and a fact that counts.
void add_input_files(const InputFilesT& inputs, const InputFilesT& unread, const UsedInputs& used, ReportInput& input);
void write_provenance(Markup& html, const ReportInput& input);

}  // namespace plumbline::report
