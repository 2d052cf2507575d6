// Whether a design was copied to its end, so that a folder's check can say it beside all else that is wrong: the run
// reads the design last.
#pragma once

#include <filesystem>
#include <set>
#include <string>

namespace plumbline::campaign {

/// Throws CampaignError if the file at `path` lacks the end of its format: END-ISO-10303-21 (ISO 10303-21) of an IFC,
/// the closing tag of an ifcXML, the central directory of an ifcZIP. Reads only the end where that is sound; what
/// stands between is for the reader of designs. `shown` is the file's name in messages.
void require_whole_design(const std::filesystem::path& path, const std::filesystem::path& shown);

/// Those of `names` that an element of the design may have: all that stand in it as a text (ISO 10303-21), and where
/// that does not tell (another format, a large file, a name that STEP writes in other letters) all.
std::set<std::string> names_that_may_be_in(const std::filesystem::path& design, const std::set<std::string>& names);

}  // namespace plumbline::campaign
