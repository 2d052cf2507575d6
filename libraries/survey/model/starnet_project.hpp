// A project of STAR*NET (.snproj): the instruments and settings that its data files are adjusted with, and which files
// these are. Sections in brackets, a key and its value on each line.
#pragma once

#include <map>
#include <string>
#include <vector>

#include "survey/model/instrument_profile.hpp"

namespace plumbline::survey {

struct StarNetProject {
  InstrumentProfile instrument;                      ///< of readings without .INST
  std::map<std::string, InstrumentProfile> library;  ///< by the names of .INST
  std::vector<std::string> files;                    ///< that are switched on, in their order
  /// What else decides how the data files are read and adjusted, each with the parameter or option that says the same
  /// here; nothing of it is applied.
  std::vector<std::string> settings;
};

/// Whether a text is such a project: its first line is "*STAR*NET".
bool is_starnet_project(const std::string& text);

/// `origin` names the text in errors. Lengths must be metres. Throws std::runtime_error with the line: what is missing,
/// not a number or in another unit.
StarNetProject parse_starnet_project(const std::string& text, const std::string& origin);

}  // namespace plumbline::survey
