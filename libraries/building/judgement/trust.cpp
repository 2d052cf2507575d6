#include "building/judgement/trust.hpp"

#include <fmt/core.h>

#include <algorithm>
#include <cmath>

namespace plumbline::judgement {
namespace {

std::string text_of(const flatbuffers::String* text) { return text ? text->str() : std::string(); }

MeasurementDoubtT finding(MeasurementPart part, DoubtGrade grade, std::string reason) {
  MeasurementDoubtT found;
  found.part = part, found.grade = grade, found.reason = std::move(reason);
  return found;
}

/// Of what the camera model leaves out: the command.
void say_what_mends(const BlockTest& test, MeasurementDoubtT& misfit) {
  if (test.kind() == BlockTestKind::principal_points) {
    misfit.mend = "block.with.image_principal_point_sigma=0.5";
    misfit.mend_note = "px; 0.1 to 1 for lenses that are focused or stabilised between images";
  } else if (test.kind() == BlockTestKind::distances) {
    misfit.mend = "block.with.free_interior=[fx, fy, cx, cy, k1, k2, k3, k4, p1, p2, d1, d2]";
  }
}

void take_misfit(MeasurementDoubtT misfit, double variance_factor, Trust& trust) {
  trust.factor = std::max(trust.factor, variance_factor);
  misfit.factor = std::sqrt(variance_factor);
  trust.misfits.push_back(std::move(misfit));
}

}  // namespace

Trust trust_of(const Block* block, const SurveyNetwork* network) {
  Trust trust;
  if (network && text_of(network->validity()) != "" && text_of(network->validity()) != "sound") {
    const auto* statistics = network->statistics();
    const bool tested =
        text_of(network->validity()) == "doubtful" && statistics && statistics->degrees_of_freedom() > 0;
    const std::string reason = text_of(network->verdict() ? network->verdict() : network->validity());
    const double factor =
        tested && !network->scaled_with_sigma0() ? std::max(std::pow(statistics->sigma0(), 2), 1.0) : 1;
    if (!tested || !std::isfinite(factor)) {
      trust.doubts.push_back(finding(MeasurementPart::survey, DoubtGrade::doubt, reason));
      if (network->without_readings() && !tested) {
        trust.doubts.back().mend = "network.with.coordinates=tested";
        trust.doubts.back().mend_note = "if another program adjusted and tested them";
      }
    } else
      take_misfit(finding(MeasurementPart::survey, DoubtGrade::misfit, reason), factor, trust);
  }
  if (!block || !block->tests()) return trust;
  for (const auto* test : *block->tests()) {
    if (test->passed()) continue;
    const std::string reason = text_of(test->words() ? test->words() : test->group());
    // A group of observations that contradicts the rest proves the block wrong. What the camera model leaves out does
    // so where nobody knows by how much: no factor makes up for it.
    if (test->kind() == BlockTestKind::observations || !std::isfinite(test->variance_factor())) {
      trust.doubts.push_back(finding(MeasurementPart::image_block, DoubtGrade::doubt, reason));
      continue;
    }
    MeasurementDoubtT misfit = finding(MeasurementPart::image_block, DoubtGrade::misfit, reason);
    say_what_mends(*test, misfit);
    take_misfit(std::move(misfit), std::max(1.0, test->variance_factor()), trust);
  }
  return trust;
}

std::optional<MeasurementDoubtT> doubt_of_datum(const Transform& design_from_survey) {
  if (!design_from_survey.fitted_to_design() || std::isfinite(design_from_survey.datum_sigma())) return std::nullopt;
  MeasurementDoubtT doubt = finding(MeasurementPart::datum, DoubtGrade::doubt,
                                    "the measurement was " + text_of(design_from_survey.origin()) +
                                        "; these are to be judged, and a shift or turn of all of them together cannot "
                                        "be seen");
  doubt.mend = "frames.with.datum_sigma=SIGMA";
  doubt.mend_note =
      "SIGMA: m, how well other measurements show that the whole stands as designed; 0: by agreement about the best "
      "fit";
  return doubt;
}

std::string about_best_fit(const Transform& design_from_survey) {
  if (!design_from_survey.fitted_to_design() || !std::isfinite(design_from_survey.datum_sigma())) return "";
  if (design_from_survey.datum_sigma() == 0)
    return "Judged about the best fit of the anchors, as agreed (datum_sigma): where the whole stands is not judged.";
  return fmt::format(
      "Judged about the best fit of the anchors: that the whole stands as designed is taken as known to {:.1f} mm "
      "(datum_sigma), nothing here measures it.",
      1e3 * design_from_survey.datum_sigma());
}

}  // namespace plumbline::judgement
