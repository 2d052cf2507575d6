#include "build/evaluate/design_input.hpp"

#include <fmt/core.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <numbers>
#include <set>
#include <stdexcept>

#include "building/ifc/facade_artifact.hpp"
#include "building/ifc/grid.hpp"
#include "building/ifc/rule_use.hpp"
#include "building/judgement/figures.hpp"
#include "building/judgement/own_anchors.hpp"

namespace plumbline::judgement {

namespace {

using judgement::AnchorCase;
using judgement::DeviationInputs;
using judgement::PanelCase;

/// Plates are true to a few degrees: within 30° they say the same as what is more exact.
const double kPlateAlike = std::cos(30 * std::numbers::pi / 180);

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

class Builder {
 public:
  Builder(const DesignT& design, const judgement::ToleranceTable& tolerances, const judgement::Mounting& mounting,
          const judgement::HeldBelow& held_below)
      : design_(design),
        grid_(ifc::grid_of(design)),
        tolerances_(tolerances),
        mounting_(mounting),
        held_below_(held_below),
        rules_(tolerances.rules.size()),
        mounting_rules_(mounting.rules.size()),
        held_rules_(held_below.rules.size()),
        sill_rules_(held_below.sills.size()) {
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
    std::vector<judgement::ToleranceFindings> rules;
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
      judgement::ToleranceFindings findings;
      panel.tolerances = judgement::tolerances_of(tolerances_, facts_of(*element, properties_), &findings);
      panel.refused = findings.refused;
      panel.held_below = held_below_.of(facts_of(*element, properties_), panel.refused);
      held_by_.push_back(ifc::selecting(held_below_.rules, facts_of(*element, properties_)));
      held_rules_.select(held_by_.back(), element->guid);
      said.emplace_back(element->anchor_guids.begin(), element->anchor_guids.end());
      panels.push_back(std::move(panel)), rules.push_back(std::move(findings));
    }
    const std::vector<char> others_alone = find_own_anchors(panels, said, inputs_.anchors, reach);
    for (std::size_t p = 0; p < panels.size(); ++p) {
      PanelCase& panel = panels[p];
      std::erase_if(panel.anchors, [&](const std::size_t a) { return inputs_.anchors[a].is_sill; });
      const judgement::ToleranceFindings& findings = rules[p];
      if (panel.anchors.empty()) {
        (others_alone[p] ? beside : loose).push_back(name_of(panel));
        inputs_.loose.push_back(std::move(panel));
        continue;
      }
      for (const std::size_t rule : findings.rules) ++rules_[rule].second;
      held_rules_.apply(held_by_[p], ifc::last_of(held_by_[p]));
      note(findings, panel.guid);
      inputs_.panels.push_back(std::move(panel));
    }
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
    group();
    add_rules();
    warn_of_storeys();
    warn_of_compass();
    for (const std::string& property : wider_)
      inputs_.warnings.push_back(property +
                                 " is wider than what holds without it, and is not the own one of what it is asked of: "
                                 "the narrower limit holds; a rule says where the wider one is meant.");
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
      if (anchor.facade.source == ifc::FacadeSource::plate && by_design.known())
        sides_[by_design.facade].push_back(!anchor.facade.confirmed ? 0 : anchor.facade.out.dot(by_design.out));
      from_table_ += plate->mounting_sigma.size() == 3;
    }
    // An anchor that the table does not list is not known any better.
    anchor.mounting = mounting_.covariance(anchor.element, plate ? plate->mounting_sigma : std::vector<double>(),
                                           axes_of(plate, anchor.facade));
    anchor.is_sill = held_below_.is_sill(anchor.element);
    for (std::size_t i = 0; i < sill_rules_.size(); ++i) sill_rules_[i] += held_below_.sills[i].matches(anchor.element);
    judgement::ToleranceFindings findings;
    anchor.tolerances = judgement::tolerances_of(tolerances_, anchor.element, &findings);
    anchor.refused = findings.refused;
    for (const std::size_t rule : findings.rules) ++rules_[rule].first;
    note(findings, element.guid);
    const std::vector<std::size_t> mounted_by = ifc::selecting(mounting_.rules, anchor.element);
    mounting_rules_.select(mounted_by, element.guid);
    mounting_rules_.apply(mounted_by, mounting_.that_hold(mounted_by));
    if (const auto* axis = ifc::axis_across(grid_, element.position, anchor.facade.out)) anchor.axis = axis->tag;
    anchor.element.properties = nullptr;
    anchor.instance = element.instance, anchor.storey_guid = element.storey_guid;
  }

  /// Sheets and statistics go by the floor of the plate table; where the design has the anchor's element in a storey
  /// whose other anchors are of another floor, one of the two is a mistake.
  void warn_of_storeys() {
    std::map<std::string, std::map<int, std::vector<std::string>>> storeys;  // by GlobalId, then floor
    std::map<std::string, std::string> names;
    for (const AnchorCase& anchor : inputs_.anchors) {
      if (!anchor.listed || anchor.storey_guid.empty()) continue;
      storeys[anchor.storey_guid][anchor.floor].push_back(anchor.id);
      names[anchor.storey_guid] = anchor.element.storey;
    }
    std::map<int, std::vector<std::string>> alike;  // storeys of one floor: of two buildings, or two levels
    for (const auto& [guid, floors] : storeys) {
      const auto most = std::max_element(
          floors.begin(), floors.end(), [](const auto& a, const auto& b) { return a.second.size() < b.second.size(); });
      alike[most->first].push_back(names[guid].empty() ? guid : names[guid]);
      for (const auto& [floor, ids] : floors)
        if (floor != most->first)
          inputs_.warnings.push_back(fmt::format(
              "The plate table has {} on floor {}, the design in the storey '{}', whose other anchors are on floor {} "
              "({} of them): sheets and statistics go by the table.",
              judgement::list_of(ids, 5), floor, names[guid].empty() ? guid : names[guid], most->first,
              most->second.size()));
    }
    for (const auto& [floor, of] : alike)
      if (of.size() > 1)
        inputs_.warnings.push_back(fmt::format(
            "Floor {} of the plate table is {} storeys of the design ({}): they are counted and listed as one.", floor,
            of.size(), judgement::list_of(of, 5)));
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
      inputs_.requests.push_back(
          {"panels " + judgement::list_of(names, 4), "design", 0, static_cast<int>(names.size()), reason});
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

  void note(const judgement::ToleranceFindings& findings, const std::string& guid) {
    in_force_.insert(findings.in_force.begin(), findings.in_force.end());
    wider_.insert(findings.wider.begin(), findings.wider.end());
    widened_.insert(findings.widened.begin(), findings.widened.end());
    for (const std::size_t rule : findings.rules) selected_[rule].insert(guid);
    for (const auto& [rule, later] : findings.replaced) replaced_[rule].insert(later);
  }

  /// Why a rule that selects something is not judged: a later, wider one stands in its place. Empty: it decides, or
  /// nothing that it asks for is lost.
  std::string why_idle(std::size_t rule) const {
    const auto later = widened_.find(rule);
    if (in_force_.contains(rule) || later == widened_.end()) return {};
    return "it holds nowhere: '" + tolerances_.rules[later->second].text +
           "' stands after it and is wider; put the narrower rule last, or take it out";
  }

  /// A rule that decides nothing because a later one, at least as narrow, is about what it is about and more.
  void warn_of_idle(std::size_t rule) {
    const auto replaced = replaced_.find(rule);
    if (in_force_.contains(rule) || replaced == replaced_.end()) return;
    const std::set<std::string>& own = selected_.at(rule);
    for (const std::size_t later : replaced->second) {
      const std::set<std::string>& others = selected_.at(later);
      if (std::includes(own.begin(), own.end(), others.begin(), others.end())) continue;
      inputs_.warnings.push_back("The rule '" + tolerances_.rules[rule].text + "' holds nowhere: '" +
                                 tolerances_.rules[later].text +
                                 "' stands after it, is no wider, and selects what it selects and more; put the rule "
                                 "for fewer last, or take it out.");
      return;
    }
  }

  /// Every rule with what it is about; one that selects nothing, or asks for an axis that what it selects does not
  /// have, is not judged; nor is one that a later, wider one replaces wherever it would hold.
  void add_rules() {
    for (std::size_t i = 0; i < tolerances_.rules.size(); ++i) {
      const judgement::ToleranceRule& rule = tolerances_.rules[i];
      judgement::Request request{rule.text, "rule", rules_[i].first, rules_[i].second, ""};
      if (request.anchors + request.panels == 0) request.not_judged = "it selects no anchor and no panel";
      for (const auto& [axis, tolerance] : rule.tolerances) {
        const bool judged = (request.anchors > 0 && judgement::judged_of_anchors(axis)) ||
                            (request.panels > 0 && judgement::judged_of_panels(axis));
        if (!judged && request.not_judged.empty())
          request.not_judged = std::string(judgement::name_of(axis)) + " is not judged of " +
                               (request.panels > 0 ? "panels" : "anchors") + ", and it selects nothing else";
      }
      if (request.not_judged.empty()) request.not_judged = why_idle(i);
      if (request.not_judged.empty()) warn_of_idle(i);
      inputs_.requests.push_back(std::move(request));
    }
    const std::vector<std::string> mounting = ifc::texts_of(mounting_.rules), held = ifc::texts_of(held_below_.rules);
    for (std::size_t i = 0; i < mounting.size(); ++i)
      inputs_.requests.push_back(
          {mounting[i], "mounting", mounting_rules_.holds(i), 0,
           mounting_rules_.not_applied(i, mounting, "anchors", "it selects no anchor of the plate table")});
    for (std::size_t i = 0; i < held.size(); ++i)
      inputs_.requests.push_back({held[i], "held_below", 0, held_rules_.holds(i),
                                  held_rules_.not_applied(i, held, "panels", "it selects no panel")});
    for (std::size_t i = 0; i < sill_rules_.size(); ++i)
      inputs_.requests.push_back(
          {held_below_.sills[i].text(), "sills", sill_rules_[i], 0, sill_rules_[i] > 0 ? "" : "it selects no anchor"});
  }

  /// The plates may have turned what the design left open: facades are grouped anew, and what no plate stands at
  /// follows those of its facade that have one.
  void group() {
    std::vector<ifc::Facing> all;
    for (AnchorCase& anchor : inputs_.anchors) {
      follow_facade(anchor.facade);
      if (anchor.design.allFinite()) all.push_back({anchor.design, &anchor.facade, false});
    }
    for (PanelCase& panel : inputs_.panels) {
      follow_anchors(panel);
      follow_facade(panel.facade);
      all.push_back({panel.frame_from_panel * Eigen::Vector3d(0.5 * (panel.low + panel.high)), &panel.facade, true});
    }
    inputs_.facades = ifc::group_facades(all);
  }

  /// Where all plates of a facade keep, or all turn, what the design had guessed, the rest of it does so too.
  void follow_facade(ifc::FacadeFrame& frame) const {
    const auto sides = sides_.find(frame.facade);
    if (frame.confirmed || !frame.known() || sides == sides_.end()) return;
    const auto [least, most] = std::minmax_element(sides->second.begin(), sides->second.end());
    if (*least > 0.8 || *most < -0.8) ifc::add_plate(frame, *least > 0.8 ? frame.out : Eigen::Vector3d(-frame.out));
  }

  /// What the plates at its anchors say holds for a panel too, and so does what they contradict: nobody is sent outward
  /// by a panel whose anchors are in dispute.
  void follow_anchors(PanelCase& panel) const {
    if (panel.facade.known() && panel.facade.source != ifc::FacadeSource::rule)
      for (const std::size_t i : panel.anchors)
        if (contradicts(inputs_.anchors[i].facade, panel.facade)) return dispute(panel, inputs_.anchors[i]);
    for (const std::size_t i : panel.anchors) {
      const ifc::FacadeFrame& anchor = inputs_.anchors[i].facade;
      if (anchor.source == ifc::FacadeSource::plate && anchor.confirmed &&
          (!panel.facade.known() || std::abs(anchor.out.dot(panel.facade.out)) > kPlateAlike))
        return ifc::add_plate(panel.facade, anchor.out);
    }
  }

  /// A plate that is in dispute itself, though it may stand as the panel does, or a rule that says the opposite.
  static bool contradicts(const ifc::FacadeFrame& anchor, const ifc::FacadeFrame& panel) {
    const double along = anchor.known() ? anchor.out.dot(panel.out) : 1;
    return (anchor.source == ifc::FacadeSource::plate && !anchor.confirmed) ||
           (anchor.source == ifc::FacadeSource::rule && along < -kPlateAlike);
  }

  /// The panel turns with its anchors where its plane allows it: they stay one facade, and one rule settles both.
  static void dispute(PanelCase& panel, const AnchorCase& anchor) {
    const ifc::FacadeFrame before = panel.facade;
    if (std::abs(anchor.facade.out.dot(before.out)) > kPlateAlike) {
      const bool by_rule = anchor.facade.source == ifc::FacadeSource::rule;
      panel.facade = ifc::frame_facing(anchor.facade.out, by_rule ? before.source : ifc::FacadeSource::plate, false);
      panel.facade.facade = before.facade, panel.facade.named = before.named;
    }
    panel.facade.confirmed = false;
    panel.facade.note = anchor.facade.source == ifc::FacadeSource::plate
                            ? anchor.facade.note
                            : "a rule has its anchor " + anchor.id + " face " + ifc::facing_words(anchor.facade.out) +
                                  ", and the design has it face " + ifc::facing_words(before.out);
  }

  void add(AnchorCase anchor) {
    if (!anchor.element.guid.empty()) index_[anchor.element.guid] = inputs_.anchors.size();
    inputs_.anchors.push_back(std::move(anchor));
  }

  const DesignT& design_;
  std::vector<ifc::GridAxis> grid_;
  const judgement::ToleranceTable& tolerances_;
  const judgement::Mounting& mounting_;
  const judgement::HeldBelow& held_below_;
  std::vector<std::pair<int, int>> rules_;                 // anchors and panels that each rule selects
  std::set<std::size_t> in_force_;                         // rules that hold somewhere
  std::set<std::string> wider_;                            // properties of the design that only tell (findings.wider)
  std::map<std::size_t, std::size_t> widened_;             // rules that a later, wider one replaces somewhere
  std::map<std::size_t, std::set<std::string>> selected_;  // by rule: GlobalIds of anchors and panels
  std::map<std::size_t, std::set<std::size_t>> replaced_;  // by rule: later ones that stand in its place somewhere
  ifc::RuleUse mounting_rules_, held_rules_;
  std::vector<int> sill_rules_;                    // anchors that each selects
  std::vector<std::vector<std::size_t>> held_by_;  // by panel, rules that select it
  std::size_t from_table_ = 0, by_plate_alone_ = 0;
  std::map<std::string, const DesignElementT*> elements_;
  std::map<std::string, std::size_t> index_;
  std::map<std::string, std::vector<double>> sides_;  // by facade of the design: cosines of the plates to it
  std::vector<ifc::Property> properties_;
  DeviationInputs inputs_;
};

}  // namespace

judgement::DeviationInputs deviation_inputs(const DesignT& design, const ElementMatchesT& matches,
                                            const PlatesT& plates, const judgement::ToleranceTable& tolerances,
                                            double panel_reach, const judgement::Mounting& mounting,
                                            const judgement::HeldBelow& held_below) {
  Builder builder(design, tolerances, mounting, held_below);
  builder.add_listed(matches, plates);
  builder.add_unlisted();
  builder.add_panels(panel_reach);
  return builder.take();
}

}  // namespace plumbline::judgement
