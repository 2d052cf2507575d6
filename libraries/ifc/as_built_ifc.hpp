// The as-built IFC: the design file with property sets about what was measured.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "ifc/as_built.hpp"
#include "ifc/step.hpp"

namespace plumbline::bim {

struct AsBuiltIfcOptions {
  std::string epoch;           ///< part of every new GlobalId: campaigns of different epochs can stand in one file
  std::int64_t timestamp = 0;  ///< of the additions, s since 1970; 0 takes the latest date of the design file
  bool survey_points = true;   ///< an IfcAnnotation at every measured position, assigned to its anchor
};

struct AsBuiltIfc {
  std::string bytes;  ///< the design file's own bytes, with lines added before the end of its DATA section
  std::size_t instances_added = 0;
  int measured = 0, passed = 0, undecided = 0, failed = 0, not_measured = 0, panels = 0;
  std::vector<std::string> warnings;
};

/// Writes ASB_AnchorDeviation, ASB_ModelVsSurvey and ASB_Uncertainty on anchors, ASB_Provenance on all of them
/// together, ASB_FloorStatistics on storeys, ASB_InterFloor on a group of two storeys, ASB_PanelFit on panels. Lengths
/// are in the project's unit. The same input gives the same bytes. Throws std::runtime_error (see match_anchors,
/// Appender).
AsBuiltIfc write_as_built(const step::File& file, const Design& design, const AsBuilt& as_built,
                          const AsBuiltIfcOptions& options);

}  // namespace plumbline::bim
