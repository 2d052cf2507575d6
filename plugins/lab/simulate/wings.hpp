// Buildings of several facades. Each is planned as the flat one is, with its own cameras and set-ups, and then put
// where it stands.
#pragma once

#include "camera.hpp"
#include "survey_plan.hpp"

namespace plumbline::simulate {

/// Names of the shapes: "flat", "set_back" (three facades of one direction, the middle one `step` behind the others),
/// "curved" (four, each turned by 15° against the one before), "corner" (two that face each other across an inner
/// corner), "block" (four around a square, facing outward), "courtyard" (four that face the court).
const std::vector<std::string>& shape_names();

/// Where the facades of a shape stand; each has the plane y = 0 and begins at x = 0 in its own frame, as the flat one.
/// `clear` [m]: what a courtyard is to be wide, at least. Throws std::invalid_argument for an unknown name.
std::vector<RigidTransform> wings_of(const std::string& shape, double width, double step, double clear);

/// All that is planned on one facade.
struct WingPlan {
  Building building;
  std::vector<CameraStation> stations;
  StationPlan plan;
};

/// Puts the facades in their places and numbers what they have on: columns, anchors, tags, batches, images
/// ("B-F01-02.jpg" of the second), set-ups and control points. The set-ups of the lower two storeys take every control
/// point of other facades that they see, so that the survey is one network. Throws std::invalid_argument if there are
/// more tags than ids, or a photograph then sees fewer than `required_tags` whole tags.
WingPlan join_wings(std::vector<WingPlan> flat, const std::vector<RigidTransform>& places, const BrownCamera& camera,
                    int required_tags);

}  // namespace plumbline::simulate
