// Surfaces of panels and their joints as property sets.
#include <cmath>

#include "artifacts/surface_judgement.hpp"
#include "artifacts/surfaces.hpp"
#include "building/ifc/as_built_writer.hpp"
#include "building/ifc/surface_words.hpp"
#include "geometry/packed_symmetric.hpp"

namespace plumbline::ifc {
namespace {

using Verdicts = std::vector<const SurfaceVerdictT*>;

void add_verdicts(PropertySet& set, const Verdicts& verdicts, InstanceId enumeration) {
  if (verdicts.empty()) return;
  std::vector<std::string> quantities, words, rules;
  for (const SurfaceVerdictT* verdict : verdicts) {
    quantities.push_back(quantity_of(*verdict)), words.push_back(label_of(verdict->verdict)),
        rules.push_back(verdict->rule);
    const std::string name = "Probability_" + quantities.back();
    set.probability(name, verdict->probability, "That the limit is kept");
  }
  set.choice("Verdict", label_of(worst_of(verdicts)), enumeration, "The worst of its quantities");
  set.labels("Quantities", quantities);
  set.labels("Verdicts", words, "In the order of Quantities");
  set.labels("Rules", rules, "In the order of Quantities");
}

/// `widened`: by which the verdicts were given larger standard deviations; these are written, with the same.
void add_figures(PropertySet& set, const PanelSurfaceFiguresT& panel, double widened) {
  set.label("NotMeasured", panel.not_measured);
  set.integer("Points", panel.points);
  if (!panel.not_measured.empty()) return;
  const Eigen::VectorXd sigma = widened * unpack_symmetric(panel.covariance, 3, "a panel").diagonal().cwiseSqrt();
  set.real("Coverage", panel.coverage, "Share of the panel that has points");
  set.length("Offset", panel.offset, "Of the best plane at the panel's middle, out of the design's face");
  if (sigma.size() == 3) set.length("OffsetUncertainty", sigma(0), "Standard uncertainty");
  set.real("TiltRight", panel.tilt.x(), "Slope to the right: positive where it stands further out");
  set.real("TiltUp", panel.tilt.y(), "Slope upward");
  if (sigma.size() == 3) set.real("TiltRightUncertainty", sigma(1)), set.real("TiltUpUncertainty", sigma(2));
  const char* forms[] = {"BowAcross", "BowUp", "Twist"};
  for (Eigen::Index i = 0; i < 3; ++i) {
    set.length(forms[i], panel.form(i));
    set.length(std::string(forms[i]) + "Uncertainty", widened * panel.form_sigma(i));
  }
  std::vector<double> lengths, gaps, uncertainties;
  for (const auto& gap : panel.flatness)
    if (std::isfinite(gap->gap))
      lengths.push_back(gap->length), gaps.push_back(gap->gap), uncertainties.push_back(widened * gap->sigma);
  set.lengths("Straightedges", lengths, "That gaps were looked for under");
  set.lengths("Gaps", gaps, "The largest under each");
  set.lengths("GapUncertainties", uncertainties);
}

void add_figures(PropertySet& set, const JointFiguresT& joint, double widened) {
  set.label("First", joint.first, "The panel at the left or below");
  set.label("Second", joint.second);
  set.label("Runs", joint.upright ? "up" : "across");
  set.length("NominalWidth", joint.nominal_width);
  set.label("NotMeasured", joint.not_measured);
  set.integer("PlacesLookedAt", joint.looked_at);
  set.integer("PlacesMeasured", static_cast<std::int64_t>(joint.places.size()));
  const auto place = [&](int index) {
    return index >= 0 && static_cast<size_t>(index) < joint.places.size() ? joint.places[index].get() : nullptr;
  };
  if (const JointPlaceT* narrowest = place(joint.narrowest)) {
    set.length("Narrowest", narrowest->width), set.length("NarrowestUncertainty", widened * narrowest->width_sigma);
    set.length("NarrowestAlong", narrowest->along, "From the joint's middle");
  }
  if (const JointPlaceT* widest = place(joint.widest)) {
    set.length("Widest", widest->width), set.length("WidestUncertainty", widened * widest->width_sigma);
    set.length("WidestAlong", widest->along, "From the joint's middle");
  }
  if (const JointPlaceT* step = place(joint.largest_step)) {
    set.length("LargestStep", step->step, "Second over first, out of the facade"),
        set.length("LargestStepUncertainty", widened * step->step_sigma);
    set.length("LargestStepAlong", step->along, "From the joint's middle");
  }
  if (const JointPlaceT* shift = place(joint.largest_shift); shift && std::isfinite(shift->shift)) {
    set.length("LargestShift", shift->shift, "Of the joint from its place in the design, to the right or upward");
    set.length("LargestShiftUncertainty", widened * shift->shift_sigma);
    set.length("LargestShiftAlong", shift->along, "From the joint's middle");
  }
}

}  // namespace

void AsBuiltWriter::write_surfaces() {
  if (!options_.surfaces) return;
  const double widened = options_.surface_judgement ? std::sqrt(options_.surface_judgement->covariance_factor) : 1;
  std::map<std::string, Verdicts> of_panel;  // by GlobalId
  std::map<std::pair<std::string, std::string>, Verdicts> of_joint;
  std::map<int, Verdicts> of_numbered_joint;
  if (options_.surface_judgement)
    for (const auto& verdict : options_.surface_judgement->verdicts) {
      if (verdict->second.empty())
        of_panel[verdict->guid].push_back(verdict.get());
      else if (verdict->item >= 0)
        of_numbered_joint[verdict->item].push_back(verdict.get());
      else
        of_joint[{verdict->panel, verdict->second}].push_back(verdict.get());
    }
  std::map<std::string, InstanceId> elements;
  for (const Element& element : design_.elements) elements[element.guid] = element.instance;
  std::map<std::string, std::vector<std::string>> guids;  // of panels by name: joints know names
  size_t strange = 0;
  for (const auto& panel : options_.surfaces->panels) {
    const std::string& guid = panel->face->guid;
    const auto element = elements.find(guid);
    if (element == elements.end()) {
      ++strange;
      continue;
    }
    guids[panel->face->id].push_back(guid);
    PropertySet set(appender_);
    add_verdicts(set, of_panel[guid], verdicts_);
    add_figures(set, *panel, widened);
    attach(set, guid + "/surface", "ASB_PanelSurface", "The panel's outer face as it is, with standard uncertainties",
           {element->second});
  }
  if (strange > 0)
    result_.warnings.push_back(std::to_string(strange) + " panels with measured surfaces are not in this design");
  size_t unclear = 0;
  const auto& panels = options_.surfaces->panels;
  // The panel's GlobalId by its number; by the name where a joint has none.
  const auto guids_of = [&](int number, const std::string& name) {
    if (number < 0 || static_cast<size_t>(number) >= panels.size()) return guids[name];
    const std::string& guid = panels[number]->face->guid;
    return elements.count(guid) ? std::vector<std::string>{guid} : std::vector<std::string>{};
  };
  for (size_t j = 0; j < options_.surfaces->joints.size(); ++j) {
    const auto& joint = options_.surfaces->joints[j];
    const auto first = guids_of(joint->first_panel, joint->first),
               second = guids_of(joint->second_panel, joint->second);
    if (first.size() != 1 || second.size() != 1 || first == second) {
      ++unclear;
      continue;
    }
    PropertySet set(appender_);
    const auto numbered = of_numbered_joint.find(static_cast<int>(j));
    add_verdicts(set, numbered != of_numbered_joint.end() ? numbered->second : of_joint[{joint->first, joint->second}],
                 verdicts_);
    add_figures(set, *joint, widened);
    attach(set, first[0] + "/" + second[0] + "/joint", "ASB_Joint_" + joint->first + "_" + joint->second,
           "The joint between two panels as it is", {elements.at(first[0]), elements.at(second[0])});
  }
  if (unclear > 0)
    result_.warnings.push_back(
        std::to_string(unclear) +
        " joints are not written: their panels share a name with others, or are not in this design");
}

}  // namespace plumbline::ifc
