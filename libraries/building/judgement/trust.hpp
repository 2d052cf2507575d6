// Whether the measurement behind a judgement stands: one law for anchors, panels and surfaces.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "artifacts/block.hpp"
#include "artifacts/deviation.hpp"
#include "artifacts/points.hpp"
#include "artifacts/survey_network.hpp"
#include "artifacts/transform.hpp"

namespace plumbline::judgement {

/// What is judged. The covariance of points may have what a camera model that does not hold moves them by already
/// (BlockTest.points_factor); what else is measured in the same photographs is less certain by the factor of the test.
enum class Judged { points, surfaces };

/// What decides about a datum that nothing measures. No command: the figure is somebody's to know.
inline constexpr const char* kSayHowTheWholeStands =
    "say how well other measurements (main axes, a benchmark) show that the whole stands as designed: "
    "frames.with.datum_sigma=0.005 where they do to 5 mm, 0 by agreement about the best fit";

struct Trust {
  /// Why the measurement is not to be trusted: then nothing is decided.
  std::vector<MeasurementDoubtT> doubts;
  /// What of its model does not hold, with the command that mends it: uncertainties are larger for it.
  std::vector<MeasurementDoubtT> misfits;
  double factor = 1;  ///< by which all covariances are to be multiplied for the misfits
};

/// What fails a test that says so proves nothing (a doubt); what fits less well than it should is less certain, by what
/// its residuals say (a misfit). A known point that the survey contradicts is a doubt, whether another node checks
/// control or not: the network's own test of it counts. So are known points that were left out and contradict what came
/// of it, where they are as many as those that hold it, and readings of which
/// one is wrong and nothing tells which. Null: there is none to ask.
Trust trust_of(const Block* block, const SurveyNetwork* network, Judged what = Judged::points);

/// The datum of a measurement that was fitted to the anchors themselves: by its points, which carry it wherever they
/// go, or by the transform that brought it to the design (null: not known). Nothing of one that comes from elsewhere.
std::optional<FittedDatumT> fitted_datum(const Points& model, const Transform* design_from_survey);

/// Such a measurement shows where the anchors stand to each other, not where the whole stands. A doubt, unless somebody
/// said how well that is known by other means.
std::optional<MeasurementDoubtT> doubt_of_datum(const FittedDatumT& datum);

/// What a reader must know where somebody said it, as a sentence; else empty.
std::string about_best_fit(const FittedDatumT& datum);

}  // namespace plumbline::judgement
