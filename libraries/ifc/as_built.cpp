#include "ifc/as_built.hpp"

#include <Eigen/Dense>
#include <algorithm>
#include <map>
#include <stdexcept>
#include <unordered_map>

#include "geometry/panel_fit.hpp"
#include "geometry/statistics.hpp"

namespace plumbline::bim {
namespace {

/// Beyond this the as-built points are in another frame, not badly built.
constexpr double kFarthestAnchor = 1.0;

class ElementIndex {
 public:
  explicit ElementIndex(const Design& design) : file_name_(design.file_name) {
    for (const Element& element : design.elements) {
      by_guid_.emplace(element.guid, &element);
      if (!element.name.empty()) by_name_[element.name].push_back(&element);
      if (!element.tag.empty()) by_tag_[element.tag].push_back(&element);
    }
  }

  /// By GUID, else by name, else by tag; nullptr if none fits. Of several with one name, the only anchor among them is
  /// meant.
  const Element* find(const std::string& id) const {
    if (const auto found = by_guid_.find(id); found != by_guid_.end()) return found->second;
    for (const auto* index : {&by_name_, &by_tag_}) {
      const auto found = index->find(id);
      if (found == index->end()) continue;
      std::vector<const Element*> candidates = found->second;
      if (candidates.size() > 1) std::erase_if(candidates, [](const Element* element) { return !element->is_anchor; });
      if (candidates.size() == 1) return candidates[0];
      throw std::runtime_error("anchor '" + id + "' fits " + std::to_string(found->second.size()) + " elements of " +
                               file_name_ + ", expected one; use its GlobalId as anchor id");
    }
    return nullptr;
  }

 private:
  std::string file_name_;
  std::unordered_map<std::string, const Element*> by_guid_;
  std::unordered_map<std::string, std::vector<const Element*>> by_name_, by_tag_;
};

/// Standard uncertainty of the length of `d` under `covariance`: along d; for d = 0 the largest there is.
double u_along(const Eigen::VectorXd& d, const Eigen::MatrixXd& covariance) {
  if (!covariance.allFinite()) return kUnknown;
  const double length = d.norm();
  if (length < 1e-9)
    return std::sqrt(
        std::max(0.0, Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd>(covariance).eigenvalues().maxCoeff()));
  return std::sqrt(std::max(0.0, d.dot(covariance * d))) / length;
}

void assess(AnchorDeviation& anchor, const AsBuilt& as_built, const std::optional<Eigen::Vector3d>& normal) {
  const Eigen::Vector3d& d = anchor.deviation;
  const Eigen::Matrix3d& covariance = anchor.measured->covariance;
  const double u_z = covariance.allFinite() ? std::sqrt(std::max(0.0, covariance(2, 2))) : kUnknown;
  const double xy = d.head<2>().norm(), u_xy = u_along(d.head<2>(), covariance.topLeftCorner<2, 2>());
  anchor.verdict = std::max(verdict_of(d.z(), u_z, as_built.tolerance_z, as_built.guard_factor),
                            verdict_of(xy, u_xy, as_built.tolerance_xy, as_built.guard_factor));
  anchor.pass_probability = conformance_probability(d.z(), u_z, as_built.tolerance_z) *
                            conformance_probability(xy, u_xy, as_built.tolerance_xy);
  if (!normal) return;
  anchor.out_of_plane = d.dot(*normal);
  anchor.in_plane = (d - anchor.out_of_plane * *normal).norm();
}

void fit_pose(PanelFit& fit, const Eigen::Vector3d& centre) {
  std::vector<Eigen::Vector3d> fixings;
  Eigen::VectorXd deviations(3 * static_cast<Eigen::Index>(fit.anchors.size()));
  for (const AnchorDeviation* anchor : fit.anchors) {
    deviations.segment<3>(3 * static_cast<Eigen::Index>(fixings.size())) = anchor->deviation;
    fixings.push_back(anchor->element->position);
    fit.max_deviation = std::max(fit.max_deviation, anchor->deviation.norm());
    fit.verdict = std::max(fit.verdict, anchor->verdict);
  }
  const Eigen::VectorXd motion = fit_panel(fixings, centre).pose * deviations;
  fit.translation = motion.head<3>();
  fit.rotation = motion.tail<3>();
}

void require_same_frame(const Design& design, const std::vector<AnchorDeviation>& anchors) {
  std::vector<double> lengths;
  for (const AnchorDeviation& anchor : anchors)
    if (anchor.deviation.allFinite()) lengths.push_back(anchor.deviation.norm());
  if (lengths.empty()) return;
  std::nth_element(lengths.begin(), lengths.begin() + static_cast<std::ptrdiff_t>(lengths.size() / 2), lengths.end());
  const double median = lengths[lengths.size() / 2];
  if (median < kFarthestAnchor) return;
  throw std::runtime_error(
      "the measured anchors lie " + std::to_string(median) + " m (median) from their design positions in " +
      design.file_name + ": they are not in the project frame of the design" +
      (design.map_conversion ? "; the design has a map conversion, so the survey may be in map coordinates" : ""));
}

}  // namespace

const char* label_of(Verdict verdict) {
  switch (verdict) {
    case Verdict::pass:
      return "PASS";
    case Verdict::undecided:
      return "UNDECIDED";
    case Verdict::fail:
      return "FAIL";
    case Verdict::not_measured:
      break;
  }
  return "NOTMEASURED";
}

Verdict verdict_of(double deviation, double u, double tolerance, double guard_factor) {
  const double length = std::abs(deviation);
  if (std::isnan(length)) return Verdict::not_measured;
  if (std::isnan(u)) return length > tolerance ? Verdict::fail : Verdict::undecided;
  if (length + guard_factor * u <= tolerance) return Verdict::pass;
  return length - guard_factor * u > tolerance ? Verdict::fail : Verdict::undecided;
}

double conformance_probability(double deviation, double u, double tolerance) {
  if (std::isnan(u) || std::isnan(deviation)) return kUnknown;
  if (u <= 0) return std::abs(deviation) <= tolerance ? 1 : 0;
  return normal_probability((tolerance - deviation) / u) - normal_probability((-tolerance - deviation) / u);
}

std::optional<Eigen::Vector3d> estimate_facade_normal(const Design& design) {
  Eigen::Vector2d centre = Eigen::Vector2d::Zero(), rest = Eigen::Vector2d::Zero();
  double anchors = 0, others = 0;
  for (const Element& element : design.elements) {
    if (element.is_anchor)
      centre += element.position.head<2>(), ++anchors;
    else
      rest += element.position.head<2>(), ++others;
  }
  if (anchors < 2) return {};
  centre /= anchors;
  Eigen::Matrix2d scatter = Eigen::Matrix2d::Zero();
  for (const Element& element : design.elements) {
    if (!element.is_anchor) continue;
    const Eigen::Vector2d d = element.position.head<2>() - centre;
    scatter += d * d.transpose() / anchors;
  }
  const Eigen::SelfAdjointEigenSolver<Eigen::Matrix2d> eigen(scatter);
  const double across = std::sqrt(std::max(0.0, eigen.eigenvalues()(0))), along = std::sqrt(eigen.eigenvalues()(1));
  // 0.1 m: anchors of one column scatter by their tolerance only, which is no facade line.
  if (along < 0.1 || across > 0.05 * along) return {};
  Eigen::Vector2d normal = eigen.eigenvectors().col(0);
  const double outward = others > 0 ? normal.dot(centre - rest / others) : 0;
  // Without a building behind the anchors: towards the negative y axis, or the positive x axis if it is square to that.
  const bool undecided = std::abs(outward) < 0.01;
  const double sense = !undecided ? outward : std::abs(normal.y()) > 1e-6 ? -normal.y() : normal.x();
  if (sense < 0) normal = -normal;
  return Eigen::Vector3d(normal.x(), normal.y(), 0);
}

std::vector<AnchorDeviation> match_anchors(const Design& design, const AsBuilt& as_built,
                                           std::vector<std::string>& unmatched) {
  const ElementIndex index(design);
  std::unordered_map<const Element*, const AsBuiltAnchor*> measured;
  for (const AsBuiltAnchor& anchor : as_built.anchors) {
    const Element* element = index.find(anchor.id);
    if (!element) {
      unmatched.push_back(anchor.id);
      continue;
    }
    const auto [entry, added] = measured.emplace(element, &anchor);
    if (!added)
      throw std::runtime_error("'" + entry->second->id + "' and '" + anchor.id + "' are the same element of " +
                               design.file_name + " (GlobalId " + element->guid +
                               "), expected one measurement of each anchor");
  }
  if (measured.empty() && !unmatched.empty())
    throw std::runtime_error("none of the " + std::to_string(unmatched.size()) + " anchors ('" + unmatched[0] +
                             "', …) fits an element of " + design.file_name +
                             " by GlobalId, name or tag; check the plate table against the design");
  const auto normal = as_built.facade_normal ? as_built.facade_normal : estimate_facade_normal(design);
  std::vector<AnchorDeviation> anchors;
  for (const Element& element : design.elements) {
    const auto found = measured.find(&element);
    if (!element.is_anchor && found == measured.end()) continue;
    AnchorDeviation anchor;
    anchor.element = &element;
    if (found != measured.end()) anchor.measured = found->second;
    if (anchor.measured && anchor.measured->position.allFinite()) {
      anchor.deviation = anchor.measured->position - element.position;
      assess(anchor, as_built, normal);
    }
    anchors.push_back(anchor);
  }
  require_same_frame(design, anchors);
  return anchors;
}

std::vector<PanelFit> fit_panels(const Design& design, const std::vector<AnchorDeviation>& anchors, double reach) {
  std::vector<PanelFit> fits;
  for (const Element& panel : design.elements) {
    if (!panel.is_panel || !panel.has_box) continue;
    PanelFit fit;
    fit.panel = &panel;
    const RigidTransform panel_from_project = panel.project_from_element.inverse();
    const Eigen::Vector3d centre = panel.project_from_element * Eigen::Vector3d((panel.box_low + panel.box_high) / 2);
    const auto fixes = [&](const Element& anchor) {
      if (!panel.anchor_guids.empty())
        return std::find(panel.anchor_guids.begin(), panel.anchor_guids.end(), anchor.guid) != panel.anchor_guids.end();
      return distance_from_box(panel.box_low, panel.box_high, panel_from_project * anchor.position) <= reach;
    };
    for (const AnchorDeviation& anchor : anchors)
      if (anchor.deviation.allFinite() && fixes(*anchor.element)) fit.anchors.push_back(&anchor);
    if (fit.anchors.empty()) continue;
    fit_pose(fit, centre);
    fits.push_back(std::move(fit));
  }
  return fits;
}

}  // namespace plumbline::bim
