// Tags in photographs as files: the observations.json of a detector, and the observations.csv of a campaign.
#pragma once

#include <string>

#include "artifacts/tag_observations.hpp"

namespace plumbline::markers {

/// Either of them, told apart by its first character. Throws std::runtime_error with `name`, the line or the place in
/// the JSON, what was found and what was expected; also for an image or a tag that is there twice and for covariances
/// that are none.
TagObservationsT parse_observations(const std::string& text, const std::string& name);

}  // namespace plumbline::markers
