// Between the frame of the survey, in which control, layouts and what is staked are, and that of the design, in which
// everything here is planned and judged.
#pragma once

#include <optional>

#include "artifacts/actuals.hpp"
#include "artifacts/transform.hpp"
#include "geometry/frame_graph.hpp"

namespace plumbline::loop {

/// building_from_survey; none: survey and design share one frame.
using SurveyLink = std::optional<FrameLink>;

/// Of what frames.to_building has applied. Throws std::runtime_error for one that leans: no instrument and no robot is
/// set up in a frame whose heights are not vertical.
SurveyLink survey_link(const TransformT& building_from_survey);

/// The same link for points less `place`, which is one of the survey: its translation is where that lies in the
/// building, and its covariance that of this place instead of one of an origin that may be thousands of kilometres
/// away.
FrameLink link_about(const FrameLink& building_from_survey, const Eigen::Vector3d& place);

/// The place of a report from the survey's frame into that of the building, and its standard deviations along the axes
/// there. What the link is uncertain by is not added: what was asked for went through the same one. Notes how it was
/// written, also of one frame.
void bring_to_building(ActualT& actual, const SurveyLink& survey);

}  // namespace plumbline::loop
