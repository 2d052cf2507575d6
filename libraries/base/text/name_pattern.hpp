// Patterns of file names, as people write them into campaign.yaml and readers into what they read.
#pragma once

#include <string>
#include <vector>

namespace plumbline::text {

/// '*' stands for any characters but '/', '?' for one, '**' for any characters and folders. Letters with marks match
/// however they are encoded: macOS writes "ü" as "u" and a mark.
bool matches_pattern(const std::string& pattern, const std::string& name);

/// Whether one of the patterns ("*.trk") matches the path, or its last part if the pattern names no folder; capital
/// letters are as good as small ones, because instruments write JOB1.TRK.
bool is_named_by(const std::vector<std::string>& patterns, const std::string& path);

}  // namespace plumbline::text
