#include "building/judgement/designed_control.hpp"

#include <fmt/core.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <set>

#include "building/judgement/figures.hpp"
#include "building/judgement/trust.hpp"

namespace plumbline::judgement {
namespace {

/// Control that hides less than this leaves a shift of the whole to be seen: what it bends the datum by stays within
/// one standard deviation of the datum, as long as the test of known points finds nothing.
constexpr double kHidesLittle = 0.1;
/// Fewer coordinates of one kind may be those of the design by themselves.
constexpr int kFewestParts = 4;

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

/// What of a known point is that of the design. Its standard deviation says nothing here: what was measured is not
/// copied for being in place.
struct Part {
  bool plan_known = false, height_known = false;
  bool plan = false, height = false;
};

/// Half the step that its known coordinates are multiples of, a millimetre or a tenth of one, as copied ones are off by
/// how they were rounded; half a tenth where they are finer [m].
double half_step(const Eigen::Vector3d& place) {
  constexpr double kCoarse = 1e-3, kFine = 1e-4, kRepresented = 1e-7;
  const Eigen::Vector3d given = place.array().isNaN().select(0, place);
  const Eigen::Vector3d rounded = kCoarse * (given / kCoarse).array().round();
  return 0.5 * ((given - rounded).cwiseAbs().maxCoeff() < kRepresented ? kCoarse : kFine);
}

/// Compared where it was written: in the survey's own frame.
Part part_of_design(const KnownPlace& known, const FrameLink& link, const Eigen::Vector3d& design) {
  constexpr double kDrawn = 1e-5;  // what a design's own numbers are rounded to [m]
  Part part;
  if (!design.allFinite()) return part;
  const Eigen::Vector3d off = (known.position - link.apply_inverse(design)).cwiseAbs();
  const double most = half_step(known.position) + kDrawn;
  part.plan_known = known.position.head<2>().allFinite(), part.height_known = std::isfinite(known.position.z());
  part.plan = part.plan_known && off.head<2>().maxCoeff() <= most;
  part.height = part.height_known && off.z() <= most;
  return part;
}

/// Of many anchors one is in place in plan or in height by itself. So where not all of a point is the design's, its
/// plan or its height counts as copied if that of at least four points, and of more than two thirds of all, is.
class Copied {
 public:
  void count(const Part& part) {
    plans_ += part.plan, known_plans_ += part.plan_known;
    heights_ += part.height, known_heights_ += part.height_known;
  }
  bool plan(const Part& part) const { return part.plan && (part.height || most(plans_, known_plans_)); }
  bool height(const Part& part) const { return part.height && (part.plan || most(heights_, known_heights_)); }

 private:
  static bool most(int of_design, int known) { return of_design >= kFewestParts && 3 * of_design > 2 * known; }
  int plans_ = 0, known_plans_ = 0, heights_ = 0, known_heights_ = 0;
};

struct Designed {
  Eigen::Index at;         ///< in the model
  Eigen::Matrix3d weight;  ///< of those of its known coordinates that were copied [1/m²]
};

/// Three shifts and a turn about the vertical through `middle`.
std::array<Eigen::Vector3d, 4> motions(const Eigen::Vector3d& p, const Eigen::Vector3d& middle) {
  return {Eigen::Vector3d::UnitX(), Eigen::Vector3d::UnitY(), Eigen::Vector3d::UnitZ(),
          Eigen::Vector3d(middle.y() - p.y(), p.x() - middle.x(), 0)};
}

/// Covariance of two points as the survey gives it. What the link is uncertain by is in the model too, all points have
/// it in common, and no known coordinate moves it.
class OfSurvey {
 public:
  OfSurvey(const PointSet& model, const FrameLink& link) : model_(model), certain_(link.covariance.isZero(0)) {
    graph_.add(link), link_ = &graph_.links().front();
  }
  Eigen::Matrix3d operator()(Eigen::Index a, Eigen::Index b) const {
    const Eigen::Matrix3d whole = model_.covariance.block(a, b);
    if (certain_) return whole;
    const FramePoints exact{{link_->apply_inverse(model_.positions[a]), link_->apply_inverse(model_.positions[b])},
                            Eigen::MatrixXd::Zero(6, 6)};
    return whole - graph_.express(exact, link_->to, link_->from).covariance.topRightCorner<3, 3>();
  }

 private:
  const PointSet& model_;
  bool certain_;
  FrameGraph graph_;
  const FrameLink* link_;
};

/// Which share of a motion of them the anchors at `judged` follow; the largest of all motions.
double followed(const std::vector<Designed>& designed, const std::vector<Eigen::Index>& judged, const PointSet& model,
                const FrameLink& link) {
  const OfSurvey covariance(model, link);
  Eigen::Vector3d middle = Eigen::Vector3d::Zero();
  for (const Eigen::Index a : judged) middle += model.positions[a] / static_cast<double>(judged.size());
  std::array<double, 4> moved{}, all{};
  for (const Eigen::Index a : judged) {
    std::array<Eigen::Vector3d, 4> along;
    along.fill(Eigen::Vector3d::Zero());
    for (const Designed& d : designed) {
      const Eigen::Matrix3d follows = covariance(a, d.at) * d.weight;
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

/// A known point whose coordinates may be the design's: its name, its place in the model, what was known of it.
struct Candidate {
  std::string name;
  Eigen::Index at;
  Part part;
  Eigen::Vector3d sigma;
};

/// A target on the bolt is the anchor under another name, and known where that was designed it is copied as well.
void add_other_names(const std::map<std::string, KnownPlace>& known, const FrameLink& link,
                     const std::vector<AnchorCase>& anchors, const std::map<std::string, Eigen::Index>& places,
                     std::vector<Candidate>& candidates) {
  std::set<std::string> names;
  for (const AnchorCase& anchor : anchors) names.insert(anchor.id);
  for (const auto& [id, place] : known) {
    const auto at = places.find(id);
    if (at == places.end() || names.contains(id)) continue;
    for (const AnchorCase& anchor : anchors) {
      const Part part = part_of_design(place, link, anchor.design);
      if (!part.plan || part.height != part.height_known) continue;
      candidates.push_back({id + " (" + anchor.id + ")", at->second, part, place.sigma});
      break;
    }
  }
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
  std::vector<Eigen::Index> judged;
  std::vector<Candidate> candidates;
  for (const AnchorCase& anchor : anchors) {
    const auto at = places.find(anchor.id);
    if (at == places.end() || !model.positions[at->second].allFinite() || !anchor.design.allFinite()) continue;
    judged.push_back(at->second);
    const auto found = known.find(anchor.id);
    if (found == known.end()) continue;
    candidates.push_back(
        {anchor.id, at->second, part_of_design(found->second, link, anchor.design), found->second.sigma});
  }
  add_other_names(known, link, anchors, places, candidates);
  Copied copied;
  for (const Candidate& candidate : candidates) copied.count(candidate.part);
  std::vector<Designed> designed;
  bool weighted = model.covariance.size() > 0 && variance > 0;
  const Eigen::Matrix3d turn = link.to_from_from.rotation.toRotationMatrix();
  for (const auto& [id, at, part, sigma] : candidates) {
    const Eigen::Vector3d of_design(copied.plan(part), copied.plan(part), copied.height(part));
    if (of_design.isZero(0)) continue;
    result.ids.push_back(id);
    result.plan = result.plan || of_design.x() > 0, result.height = result.height || of_design.z() > 0;
    weighted = weighted && (of_design.array() == 0 || sigma.array() > 0).all();
    if (!weighted) continue;
    const Eigen::Vector3d weights =
        (of_design.array() > 0).select(1 / (variance * sigma.array().square()), 0.0).matrix();
    designed.push_back({at, turn * weights.asDiagonal() * turn.transpose()});
  }
  if (result.ids.empty()) return result;
  std::vector<Eigen::Index> looked;
  const std::size_t step = 1 + judged.size() / kLooked;
  for (std::size_t i = 0; i < judged.size(); i += step) looked.push_back(judged[i]);
  result.hidden = weighted ? followed(designed, looked, model, link)
                           : static_cast<double>(result.ids.size()) / static_cast<double>(known.size());
  return result;
}

MeasurementDoubtT doubt_of(const DesignedControl& control) {
  constexpr std::size_t kNamed = 8;
  MeasurementDoubtT doubt;
  doubt.part = MeasurementPart::datum, doubt.grade = DoubtGrade::doubt, doubt.about = "designed_control";
  const char* coordinates = control.plan && control.height ? "coordinates"
                            : control.plan                 ? "plan coordinates"
                                                           : "heights";
  doubt.reason = fmt::format(
      "the survey hangs on anchors that are to be judged, at the {} of their design: {}; of a shift or turn "
      "of all anchors together {:.0f} % cannot be seen",
      coordinates, list_of(control.ids, kNamed), 100 * control.hidden);
  doubt.mend_note = kSayHowTheWholeStands;
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
