// Control that is no measurement: known points that are anchors to be judged, with the coordinates of their design. A
// survey that hangs on them is fitted to the design, whatever the frames say.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "artifacts/deviation.hpp"
#include "artifacts/survey_network.hpp"
#include "building/judgement/deviation.hpp"
#include "geometry/frame_graph.hpp"

namespace plumbline::judgement {

struct DesignedControl {
  std::vector<std::string> ids;       ///< none: there is no such control
  bool plan = false, height = false;  ///< what of them, of any
  /// Of a shift or a turn of all anchors against the rest of the control, what these known points hide: 1 where nothing
  /// else holds the survey.
  double hidden = 0;
  bool holds_the_datum() const;
};

/// A known point counts if each of its coordinates is the design's but for how it is written (to half a millimetre
/// where they are whole ones, else to half a tenth): copied; under the name of the anchor, or under another one at the
/// designed place of any. Where its plan or its height alone is so near, that one counts if so it is of at least four
/// known points and of more than two thirds of them. How much they hide is how far they take the judged anchors along
/// when all of them are elsewhere: dx = Q P dl, with the anchors' covariance Q and the weights P of the known
/// coordinates. Other control that holds the datum leaves little of it. Without a joint covariance their share of the
/// known points counts. `model`: with the covariance that the survey gives it; what the link is uncertain by no known
/// coordinate moves.
DesignedControl designed_control(const SurveyNetwork& network, const FrameLink& building_from_survey,
                                 const std::vector<AnchorCase>& anchors, const PointSet& model);

/// A doubt where they hold the datum, until somebody says how well that is known by other means.
MeasurementDoubtT doubt_of(const DesignedControl& control);
/// What a reader must know where somebody said it, as a sentence.
std::string about_designed_control(double datum_sigma);

}  // namespace plumbline::judgement
