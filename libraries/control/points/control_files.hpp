// The one entrance for files of known points, whatever program wrote them.
#pragma once

#include <string>

#include "control/points/control_table.hpp"

namespace plumbline::control {

/// OpenDroneMap's gcp_list.txt, openMVS's table of ground control, or a table of points (control_table.hpp). Throws
/// std::runtime_error that names file and line.
ControlTable parse_control(const std::string& text, const std::string& file, const ControlOptions& options = {});

/// Throws std::runtime_error if a point has no height or no place in the plan; `reader` names who cannot use it.
void require_whole(const ControlTable& table, const std::string& file, const std::string& reader);

}  // namespace plumbline::control
