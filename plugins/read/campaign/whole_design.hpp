// Whether a design was copied to its end, so that a folder's check can say it beside all else that is wrong: the run
// reads the design last.
#pragma once

#include <filesystem>

namespace plumbline::campaign {

/// Throws CampaignError if the file at `path` lacks the end of its format: END-ISO-10303-21 (ISO 10303-21) of an IFC,
/// the closing tag of an ifcXML, the central directory of an ifcZIP. Reads only the end where that is sound; what
/// stands between is for the reader of designs. `shown` is the file's name in messages.
void require_whole_design(const std::filesystem::path& path, const std::filesystem::path& shown);

}  // namespace plumbline::campaign
