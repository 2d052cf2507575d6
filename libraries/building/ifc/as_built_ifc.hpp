// The as-built IFC: the design file with property sets and small solids about what was measured. Nothing is judged
// here: every verdict comes from the artifact `Deviation`.
//
// Two quantities that must not be mixed: the deviation Δp = as-built − design (14) says how well the building was
// built; the residual Δz = model − survey (9) says how well the model was measured. They go into different property
// sets.
#pragma once

#include <cstdint>
#include <filesystem>
#include <string>
#include <utility>
#include <vector>

#include "artifacts/accuracy.hpp"
#include "artifacts/deviation.hpp"
#include "building/ifc/design.hpp"
#include "building/step/step.hpp"

namespace plumbline {
struct SurfacesT;
struct SurfaceJudgementT;
}  // namespace plumbline

namespace plumbline::ifc {

struct AsBuiltIfcOptions {
  std::string epoch;  ///< part of every new GlobalId and of the names of the sets: epochs can stand in one file
  std::int64_t timestamp = 0;  ///< of the additions, s since 1970; 0 takes the latest date of the design file
  bool survey_points = true;   ///< an IfcAnnotation at every measured position, assigned to its anchor
  bool solids = true;          ///< a small solid of the verdict's colour there, and a thin one for every panel
  std::vector<std::pair<std::string, std::string>> provenance;  ///< property name and text of ASB_Provenance
  std::vector<std::string> input_hashes;   ///< "path sha256" of every file that was read, photographs included
  std::vector<std::string> unused_hashes;  ///< the same of evidence that was set aside
  std::int64_t image_count = -1;           ///< images that took part; below 0: not known
  std::int64_t reading_count = -1;         ///< readings of the survey that took part; below 0: not known
  std::int64_t readings_left_out = 0;      ///< and those that were read beside them
  std::string document = "report.html";    ///< what the document reference leads to, beside the file; empty: none
  const SurfacesT* surfaces = nullptr;     ///< panels and joints as they were measured; null: they were not
  const SurfaceJudgementT* surface_judgement = nullptr;  ///< their verdicts; null: they were not judged
};

struct AsBuiltIfc {
  std::string additions;  ///< lines that belong at File::data_end() of the design, whose own bytes stay as they are
  std::size_t instances_added = 0;
  std::vector<std::string> warnings;
};

const char* label_of(ToleranceVerdict verdict);  ///< "PASS", "FAIL", "UNDECIDED", "NOTMEASURED"

/// Writes ASB_AnchorDeviation, ASB_ModelVsSurvey and ASB_Uncertainty on anchors, ASB_Provenance on all of them
/// together, ASB_FloorStatistics on storeys, ASB_InterFloor on a group of two storeys, ASB_PanelFit on panels,
/// ASB_PanelSurface and ASB_Joint on panels whose surfaces were measured. An IfcDocumentReference ties the project, all
/// elements that were measured and all products that were added to the report. Lengths are in the project's unit. The
/// same input gives the same bytes. Throws std::runtime_error if `deviation` names instances that the file does not
/// have, or the file holds this epoch already. See enriched() for the whole file.
AsBuiltIfc write_as_built(const step::File& file, const Design& design, const DeviationT& deviation,
                          const AccuracyT& accuracy, const AsBuiltIfcOptions& options);

/// Writes the design file with the additions to `path`. Throws std::runtime_error with the reason.
void write_enriched(const step::File& file, const AsBuiltIfc& as_built, const std::filesystem::path& path);
/// The same in memory.
std::string enriched(const step::File& file, const AsBuiltIfc& as_built);

}  // namespace plumbline::ifc
