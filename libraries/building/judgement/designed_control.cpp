#include "building/judgement/designed_control.hpp"

#include <fmt/core.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <map>

#include "building/judgement/figures.hpp"

namespace plumbline::judgement {
namespace {

/// Control that hides less than this leaves a shift of the whole to be seen: what it bends the datum by stays within
/// one standard deviation of the datum, as long as the test of known points finds nothing.
constexpr double kHidesLittle = 0.1;
/// Coordinates that were copied are off by how they were rounded: to whole millimetres at the most [m].
constexpr double kWritten = 0.0005;

struct KnownPlace {
  Eigen::Vector3d position = Eigen::Vector3d::Constant(AnchorCase::nan), sigma = Eigen::Vector3d::Zero();
};

std::string text_of(const flatbuffers::String* text) { return text ? text->str() : std::string(); }

/// What was known of the points that hold a survey, in its own frame.
std::map<std::string, KnownPlace> known_places(const SurveyNetwork& network) {
  std::map<std::string, KnownPlace> known;
  if (network.known_points())
    for (const auto* point : *network.known_points()) known[text_of(point->id())];
  const std::string datum = text_of(network.datum());
  if (datum == "fixed" && network.datum_points())
    for (const auto* id : *network.datum_points()) known[text_of(id)];
  if ((datum == "fixed" || datum == "file") && network.points())
    for (const auto* point : *network.points())
      if (const auto at = known.find(text_of(point->id())); at != known.end())
        at->second.position = {point->position()->x(), point->position()->y(), point->position()->z()};
  if (!network.observations()) return known;
  for (const auto* row : *network.observations()) {
    if (row->removed() || text_of(row->kind()) != "coordinate") continue;
    const auto at = known.find(text_of(row->to()));
    const auto axis = std::string("ENH").find(text_of(row->detail()));
    if (at == known.end() || axis > 2) continue;
    at->second.position[static_cast<Eigen::Index>(axis)] = row->value();
    at->second.sigma[static_cast<Eigen::Index>(axis)] = row->sigma();
  }
  return known;
}

/// Heights alone are no place, nor is a plan without them: what is not known is not compared. Its standard deviation
/// says nothing here: what was measured is not copied for being in place.
bool is_designed(const KnownPlace& known, const FrameLink& link, const Eigen::Vector3d& design) {
  if (!known.position.allFinite() || !design.allFinite()) return false;
  return ((link.apply(known.position) - design).cwiseAbs().array() <= kWritten).all();
}

struct Designed {
  Eigen::Index at;         ///< in the model
  Eigen::Matrix3d weight;  ///< of its known coordinates [1/m²]
};

/// Three shifts and a turn about the vertical through `middle`.
std::array<Eigen::Vector3d, 4> motions(const Eigen::Vector3d& p, const Eigen::Vector3d& middle) {
  return {Eigen::Vector3d::UnitX(), Eigen::Vector3d::UnitY(), Eigen::Vector3d::UnitZ(),
          Eigen::Vector3d(middle.y() - p.y(), p.x() - middle.x(), 0)};
}

/// Which share of a motion of them the anchors at `judged` follow; the largest of all motions.
double followed(const std::vector<Designed>& designed, const std::vector<Eigen::Index>& judged, const PointSet& model) {
  Eigen::Vector3d middle = Eigen::Vector3d::Zero();
  for (const Eigen::Index a : judged) middle += model.positions[a] / static_cast<double>(judged.size());
  std::array<double, 4> moved{}, all{};
  for (const Eigen::Index a : judged) {
    std::array<Eigen::Vector3d, 4> along;
    along.fill(Eigen::Vector3d::Zero());
    for (const Designed& d : designed) {
      const Eigen::Matrix3d follows = model.covariance.block(a, d.at) * d.weight;
      const auto motion = motions(model.positions[d.at], middle);
      for (std::size_t k = 0; k < 4; ++k) along[k] += follows * motion[k];
    }
    const auto motion = motions(model.positions[a], middle);
    for (std::size_t k = 0; k < 4; ++k) moved[k] += along[k].squaredNorm(), all[k] += motion[k].squaredNorm();
  }
  double most = 0;
  for (std::size_t k = 0; k < 4; ++k)
    if (all[k] > 0) most = std::max(most, std::sqrt(moved[k] / all[k]));
  return std::min(1.0, most);
}

}  // namespace

bool DesignedControl::holds_the_datum() const { return !ids.empty() && hidden > kHidesLittle; }

DesignedControl designed_control(const SurveyNetwork& network, const FrameLink& link,
                                 const std::vector<AnchorCase>& anchors, const PointSet& model) {
  constexpr std::size_t kLooked = 400;  // anchors that show how far the datum is taken along
  DesignedControl result;
  if (text_of(network.datum()) == "inner") return result;
  const auto known = known_places(network);
  std::map<std::string, Eigen::Index> places;
  for (std::size_t i = 0; i < model.ids.size(); ++i) places[model.ids[i]] = static_cast<Eigen::Index>(i);
  const double variance =
      network.scaled_with_sigma0() && network.statistics() ? std::pow(network.statistics()->sigma0(), 2) : 1;
  std::vector<Designed> designed;
  std::vector<Eigen::Index> judged;
  bool weighted = model.covariance.size() > 0 && variance > 0;
  for (std::size_t i = 0; i < anchors.size(); ++i) {
    const AnchorCase& anchor = anchors[i];
    const auto at = places.find(anchor.id);
    if (at == places.end() || !model.positions[at->second].allFinite() || !anchor.design.allFinite()) continue;
    judged.push_back(at->second);
    const auto found = known.find(anchor.id);
    if (found == known.end() || !is_designed(found->second, link, anchor.design)) continue;
    result.ids.push_back(anchor.id);
    const Eigen::Vector3d& sigma = found->second.sigma;
    weighted = weighted && sigma.minCoeff() > 0;
    if (weighted)
      designed.push_back({at->second, link.to_from_from.rotation.toRotationMatrix() *
                                          (variance * sigma.cwiseAbs2()).cwiseInverse().asDiagonal() *
                                          link.to_from_from.rotation.toRotationMatrix().transpose()});
  }
  if (result.ids.empty()) return result;
  std::vector<Eigen::Index> looked;
  const std::size_t step = 1 + judged.size() / kLooked;
  for (std::size_t i = 0; i < judged.size(); i += step) looked.push_back(judged[i]);
  result.hidden = weighted ? followed(designed, looked, model)
                           : static_cast<double>(result.ids.size()) / static_cast<double>(known.size());
  return result;
}

MeasurementDoubtT doubt_of(const DesignedControl& control) {
  constexpr std::size_t kNamed = 8;
  MeasurementDoubtT doubt;
  doubt.part = MeasurementPart::datum, doubt.grade = DoubtGrade::doubt;
  doubt.reason = fmt::format(
      "the survey hangs on anchors that are to be judged, at the coordinates of their design: {}; of a shift or turn "
      "of all anchors together {:.0f} % cannot be seen",
      list_of(control.ids, kNamed), 100 * control.hidden);
  doubt.mend = "frames.with.datum_sigma=SIGMA";
  doubt.mend_note =
      "SIGMA: m, how well other measurements show that the whole stands as designed; 0: by agreement about the best "
      "fit";
  return doubt;
}

std::string about_designed_control(double datum_sigma) {
  if (datum_sigma == 0)
    return "Judged about control with the coordinates of the design, as agreed (datum_sigma): where the whole stands "
           "is "
           "not judged.";
  return fmt::format(
      "Judged about control with the coordinates of the design: that the whole stands as designed is taken as known to "
      "{:.1f} mm (datum_sigma), nothing here measures it.",
      1e3 * datum_sigma);
}

}  // namespace plumbline::judgement
