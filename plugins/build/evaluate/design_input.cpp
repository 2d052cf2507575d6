#include "build/evaluate/design_input.hpp"

#include <fmt/core.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <numbers>
#include <set>
#include <stdexcept>

#include "build/evaluate/plate_sides.hpp"
#include "build/evaluate/rule_account.hpp"
#include "building/ifc/facade_artifact.hpp"
#include "building/ifc/grid.hpp"
#include "building/judgement/figures.hpp"
#include "building/judgement/outer_side.hpp"
#include "building/judgement/own_anchors.hpp"

namespace plumbline::judgement {

namespace {

/// Panels whose middles and extents differ by less are at one place [m].
constexpr double kOnePlace = 0.01;

/// Facts of an element; `properties` outlives them.
ifc::ElementFacts facts_of(const DesignElementT& element, std::vector<ifc::Property>& properties) {
  properties.clear();
  for (const auto& p : element.properties)
    properties.push_back({p->set, p->name, p->text, p->number, p->measure, p->lower, p->upper, p->holder});
  return {element.class_,      element.guid,      element.name,   element.tag,
          element.object_type, element.type_name, element.storey, &properties};
}

/// A plate whose table does not say where it faces lies flat (plugins/read/campaign): right, up and out of it are those
/// of its facade, or what is said of "out" would count upwards. So are those of a plate that is in no table.
Eigen::Quaterniond axes_of(const PlateT* plate, const ifc::FacadeFrame& facade) {
  const Eigen::Quaterniond rotation = plate ? plate->nominal_rotation : Eigen::Quaterniond::Identity();
  const Eigen::Vector3d out = rotation * Eigen::Vector3d::UnitZ();
  if (out.head<2>().norm() > 1e-9 || !facade.known()) return rotation;
  Eigen::Matrix3d axes;
  axes << facade.right, facade.up, facade.out;
  return Eigen::Quaterniond(axes);
}

/// Sheets and statistics go by the floor of the plate table; where the design has the anchor's element in a storey
/// whose other anchors are of another floor, one of the two is a mistake.
void warn_of_storeys(DeviationInputs& inputs) {
  std::map<std::string, std::map<int, std::vector<std::string>>> storeys;  // by GlobalId, then floor
  std::map<std::string, std::string> names;
  for (const AnchorCase& anchor : inputs.anchors) {
    if (!anchor.listed || anchor.storey_guid.empty()) continue;
    storeys[anchor.storey_guid][anchor.floor].push_back(anchor.id);
    names[anchor.storey_guid] = anchor.element.storey;
  }
  std::map<int, std::vector<std::string>> alike;  // storeys of one floor: of two buildings, or two levels
  for (const auto& [guid, floors] : storeys) {
    const auto most = std::max_element(floors.begin(), floors.end(),
                                       [](const auto& a, const auto& b) { return a.second.size() < b.second.size(); });
    alike[most->first].push_back(names[guid].empty() ? guid : names[guid]);
    for (const auto& [floor, ids] : floors)
      if (floor != most->first)
        inputs.warnings.push_back(fmt::format(
            "The plate table has {} on floor {}, the design in the storey '{}', whose other anchors are on floor {} "
            "({} of them): sheets and statistics go by the table.",
            list_of(ids, 5), floor, names[guid].empty() ? guid : names[guid], most->first, most->second.size()));
  }
  for (const auto& [floor, of] : alike)
    if (of.size() > 1)
      inputs.warnings.push_back(fmt::format(
          "Floor {} of the plate table is {} storeys of the design ({}): they are counted and listed as one.", floor,
          of.size(), list_of(of, 5)));
}

class Builder {
 public:
  Builder(const DesignT& design, const ToleranceTable& tolerances, const Mounting& mounting,
          const HeldBelow& held_below)
      : design_(design),
        grid_(ifc::grid_of(design)),
        tolerances_(tolerances),
        mounting_(mounting),
        held_below_(held_below),
        account_(tolerances, mounting, held_below) {
    for (const auto& element : design.elements) elements_[element->guid] = element.get();
  }

  void add_listed(const ElementMatchesT& matches, const PlatesT& plates) {
    for (const auto* list : {&design_.not_applied, &matches.not_applied})
      for (const auto& request : *list)
        inputs_.requests.push_back({request->asked, request->by, 0, 0, request->not_judged});
    std::map<std::string, const PlateT*> plate_of;
    for (const auto& plate : plates.plates) plate_of.try_emplace(plate->anchor, plate.get());
    for (const auto& match : matches.matches) {
      AnchorCase anchor;
      anchor.id = match->anchor;
      const auto listed = plate_of.find(match->anchor);
      const PlateT* plate = listed != plate_of.end() ? listed->second : nullptr;
      if (plate)
        anchor.listed = true, anchor.floor = plate->floor, anchor.column = plate->column, anchor.use = plate->role;
      anchor.note = match->note;
      if (!match->guid.empty()) {
        const auto element = elements_.find(match->guid);
        if (element == elements_.end())
          throw std::runtime_error("input 'matches': anchor '" + match->anchor + "' is the element " + match->guid +
                                   ", which 'design' does not have; connect both to the same design");
        describe(*element->second, plate, anchor);
        anchor.found_by = match->found_by, anchor.reference_point_rule = match->reference_rule;
        anchor.design = match->position, anchor.target_offset = match->target_offset;
      }
      add(std::move(anchor));
    }
  }

  void add_unlisted() {
    std::map<std::string, int> names;
    for (const AnchorCase& anchor : inputs_.anchors) names[anchor.id] = 2;  // an id that is taken is not unique
    for (const auto& element : design_.elements)
      if (element->is_anchor) ++names[element->name];
    for (const auto& element : design_.elements) {
      if (!element->is_anchor || index_.contains(element->guid)) continue;
      AnchorCase anchor;
      describe(*element, nullptr, anchor);
      anchor.id = element->name.empty() || names[element->name] > 1 ? element->guid : element->name;
      anchor.reference_point_rule = element->reference_point_rule;
      anchor.design = element->position;
      anchor.note = "not in the plate table";
      add(std::move(anchor));
    }
  }

  void add_panels(double reach) {
    std::set<std::string> wholes;
    std::vector<std::string> shapeless, loose, beside;
    std::vector<PanelCase> panels;
    std::vector<ToleranceFindings> rules;
    std::vector<std::size_t> by_nearness;     // panels whose anchors the file does not say
    std::vector<std::set<std::string>> said;  // by panel: GlobalIds of its anchors, where the file has them
    for (const auto& element : design_.elements)
      if (element->is_panel) wholes.insert(element->parent_guid);
    for (const auto& element : design_.elements) {
      if (!element->is_panel || wholes.count(element->guid)) continue;
      if (!element->box_low.allFinite()) {
        shapeless.push_back(name_of(*element));
        continue;
      }
      PanelCase panel;
      panel.guid = element->guid, panel.name = element->name, panel.storey_guid = element->storey_guid;
      panel.instance = element->instance;
      panel.facade = ifc::frame_or_none(element->facade);
      panel.frame_from_panel = element->placement, panel.low = element->box_low, panel.high = element->box_high;
      if (element->rectangles.size() == 24 && panel.facade.known() && panel.facade.confirmed)
        panel.outer = outer_side(*element, panel.facade.out);
      ToleranceFindings findings;
      panel.tolerances = tolerances_of(tolerances_, facts_of(*element, properties_), &findings);
      panel.refused = findings.refused;
      panel.held_below = held_below_.of(facts_of(*element, properties_), panel.refused);
      account_.see_panel(facts_of(*element, properties_), element->guid);
      said.emplace_back(element->anchor_guids.begin(), element->anchor_guids.end());
      panels.push_back(std::move(panel)), rules.push_back(std::move(findings));
    }
    const std::vector<char> others_alone = find_own_anchors(panels, said, inputs_.anchors, reach);
    for (std::size_t p = 0; p < panels.size(); ++p) {
      PanelCase& panel = panels[p];
      std::erase_if(panel.anchors, [&](const std::size_t a) { return inputs_.anchors[a].is_sill; });
      const ToleranceFindings& findings = rules[p];
      if (panel.anchors.empty()) {
        (others_alone[p] ? beside : loose).push_back(name_of(panel));
        inputs_.loose.push_back(std::move(panel));
        continue;
      }
      account_.count_panel(p, findings, panel.guid);
      if (said[p].empty()) by_nearness.push_back(inputs_.panels.size());
      inputs_.panels.push_back(std::move(panel));
    }
    tell_of_nearness(by_nearness, reach, inputs_);
    const std::string reason =
        fmt::format("no anchor is within {:.3g} m of them (panel_reach), and the file ties none to them", reach);
    add_panels_not_judged(loose, reason);
    add_panels_not_judged(beside, fmt::format("all anchors within {:.3g} m of them (panel_reach) are nearer to other "
                                              "panels, and the file ties none to them",
                                              reach));
    add_panels_not_judged(shapeless, "they have no shape that can be read");
    add_panels_at_one_place();
  }

  DeviationInputs take() {
    sides_.group(inputs_);
    account_.add_requests(design_, inputs_);
    warn_of_storeys(inputs_);
    warn_of_compass();
    account_.warn_of_wider(inputs_);
    inputs_.design_file = design_.file_name;
    inputs_.mounting = mounting_.words(from_table_);
    return std::move(inputs_);
  }

 private:
  void describe(const DesignElementT& element, const PlateT* plate, AnchorCase& anchor) {
    anchor.element = facts_of(element, properties_);
    anchor.facade = ifc::frame_or_none(element.facade);
    if (plate) {
      anchor.element.batch = plate->batch;
      const ifc::FacadeFrame by_design = anchor.facade;
      ifc::add_plate(anchor.facade, plate->nominal_rotation * Eigen::Vector3d::UnitZ(), design_.true_north);
      by_plate_alone_ += anchor.facade.known() && !by_design.known();
      sides_.add(by_design, anchor.facade);
      from_table_ += plate->mounting_sigma.size() == 3;
    }
    // An anchor that the table does not list is not known any better.
    anchor.mounting = mounting_.covariance(anchor.element, plate ? plate->mounting_sigma : std::vector<double>(),
                                           axes_of(plate, anchor.facade));
    anchor.is_sill = held_below_.is_sill(anchor.element);
    ToleranceFindings findings;
    anchor.tolerances = tolerances_of(tolerances_, anchor.element, &findings);
    anchor.refused = findings.refused;
    account_.count_anchor(anchor.element, findings, element.guid);
    if (const auto* axis = ifc::axis_across(grid_, element.position, anchor.facade.out)) anchor.axis = axis->tag;
    anchor.element.properties = nullptr;
    anchor.instance = element.instance, anchor.storey_guid = element.storey_guid;
  }

  /// Nothing of the design says otherwise, so nobody could tell the two apart.
  void warn_of_compass() {
    constexpr double kNorth = 3;  // degrees: what a plate table is good for
    const double north = design_.true_north * 180 / std::numbers::pi;
    if (by_plate_alone_ == 0 || !(std::abs(north) > kNorth)) return;
    inputs_.warnings.push_back(fmt::format(
        "Which way {} anchors face is said by the plate table alone, whose azimuths count from the y axis of "
        "the design; TrueNorth is {:.1f}° from it (clockwise): azimuths of a compass have to be larger by "
        "that.",
        by_plate_alone_, north));
  }

  static std::string name_of(const DesignElementT& element) {
    return element.name.empty() ? element.guid : element.name;
  }

  void add_panels_not_judged(const std::vector<std::string>& names, const std::string& reason) {
    if (!names.empty())
      inputs_.requests.push_back({"panels " + list_of(names, 4), "design", 0, static_cast<int>(names.size()), reason});
  }

  /// Of two panels at one place both would pass, by the same anchors.
  void add_panels_at_one_place() {
    std::vector<std::pair<Eigen::Vector3d, const PanelCase*>> by_place;
    for (const PanelCase& panel : inputs_.panels)
      by_place.emplace_back(panel.frame_from_panel * Eigen::Vector3d(0.5 * (panel.low + panel.high)), &panel);
    std::sort(by_place.begin(), by_place.end(), [](const auto& a, const auto& b) { return a.first.x() < b.first.x(); });
    std::vector<std::string> names;
    for (auto one = by_place.begin(); one != by_place.end(); ++one)
      for (auto other = one + 1; other != by_place.end() && other->first.x() - one->first.x() < kOnePlace; ++other)
        if ((other->first - one->first).norm() < kOnePlace && alike(*one->second, *other->second))
          names.push_back(name_of(*one->second) + " and " + name_of(*other->second));
    add_panels_not_judged(names,
                          "two panels of the design are at one place, and nobody knows which of them hangs there; "
                          "take one of them out of the design, or out of its panels");
  }

  static bool alike(const PanelCase& a, const PanelCase& b) {
    const auto extent = [](const PanelCase& panel) {
      const Eigen::Vector3d half = 0.5 * (panel.high - panel.low);
      return Eigen::Vector3d(panel.frame_from_panel.rotation.toRotationMatrix().cwiseAbs() * half);
    };
    return (extent(a) - extent(b)).norm() < kOnePlace;
  }

  static std::string name_of(const PanelCase& panel) { return panel.name.empty() ? panel.guid : panel.name; }

  void add(AnchorCase anchor) {
    if (!anchor.element.guid.empty()) index_[anchor.element.guid] = inputs_.anchors.size();
    inputs_.anchors.push_back(std::move(anchor));
  }

  const DesignT& design_;
  std::vector<ifc::GridAxis> grid_;
  const ToleranceTable& tolerances_;
  const Mounting& mounting_;
  const HeldBelow& held_below_;
  RuleAccount account_;
  std::size_t from_table_ = 0, by_plate_alone_ = 0;
  std::map<std::string, const DesignElementT*> elements_;
  std::map<std::string, std::size_t> index_;
  PlateSides sides_;
  std::vector<ifc::Property> properties_;
  DeviationInputs inputs_;
};

}  // namespace

DeviationInputs deviation_inputs(const DesignT& design, const ElementMatchesT& matches, const PlatesT& plates,
                                 const ToleranceTable& tolerances, double panel_reach, const Mounting& mounting,
                                 const HeldBelow& held_below) {
  Builder builder(design, tolerances, mounting, held_below);
  builder.add_listed(matches, plates);
  builder.add_unlisted();
  builder.add_panels(panel_reach);
  return builder.take();
}

}  // namespace plumbline::judgement
