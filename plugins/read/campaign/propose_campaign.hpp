// A campaign.yaml for a folder that has none: what lies there is recognised by its content, and every guess is a line
// that its owner can read and change.
#pragma once

#include "campaign_folder.hpp"

namespace plumbline::campaign {

struct Proposal {
  std::string yaml;                ///< a commented campaign.yaml; lines that lack a file are comments
  std::vector<std::string> found;  ///< what was recognised, a line each
  std::string pipeline;            ///< that the folder is whole for, where that is not the one of a site; else empty
  std::vector<std::string> wrong;  ///< what has to be mended or is missing, a line each with the mend
};

/// `files`: what lies in the folder at `root`, as relative paths with forward slashes. Never throws for what the files
/// hold. `readable`: survey files that readers of other plugins know as theirs.
Proposal propose_campaign(const std::filesystem::path& root, std::vector<std::string> files,
                          const std::vector<std::string>& readable = {});

}  // namespace plumbline::campaign
