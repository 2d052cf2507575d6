// The page of an image block: how well photographs, tags and cameras fit together, what was left out and why.
#pragma once

#include <map>
#include <nlohmann/json_fwd.hpp>
#include <string>

#include "show/report/markup.hpp"

namespace plumbline::report {

/// Where the photographs' files are, by the path that the block names them with; for crops of the worst corners.
using PhotographFiles = std::map<std::string, std::string>;

/// The body of the page from a block.json (docs/photographs.md has its fields). Photographs that cannot be read give no
/// crop.
void write_image_block(Markup& html, const nlohmann::ordered_json& block, const std::string& title,
                       const std::string& subtitle, const PhotographFiles& files);

}  // namespace plumbline::report
