#include "evaluate/design_input.hpp"

#include <map>
#include <set>
#include <stdexcept>

#include "geometry/panel_fit.hpp"

namespace plumbline::evaluate {

namespace {

using judgement::AnchorCase;
using judgement::DeviationInputs;
using judgement::PanelCase;

/// Facts of an element; `properties` outlives them.
bim::ElementFacts facts_of(const DesignElementT& element, std::vector<bim::Property>& properties) {
  properties.clear();
  for (const auto& p : element.properties) properties.push_back({p->set, p->name, p->text, p->number});
  return {element.class_,      element.guid,      element.name,   element.tag,
          element.object_type, element.type_name, element.storey, &properties};
}

class Builder {
 public:
  Builder(const DesignT& design, const judgement::ToleranceTable& tolerances, const judgement::Mounting& mounting)
      : design_(design), tolerances_(tolerances), mounting_(mounting) {
    for (const auto& element : design.elements) elements_[element->guid] = element.get();
  }

  void add_listed(const ElementMatchesT& matches, const PlatesT& plates) {
    std::map<std::string, const PlateT*> plate_of;
    for (const auto& plate : plates.plates) plate_of.try_emplace(plate->anchor, plate.get());
    for (const auto& match : matches.matches) {
      AnchorCase anchor;
      anchor.id = match->anchor;
      const auto listed = plate_of.find(match->anchor);
      const PlateT* plate = listed != plate_of.end() ? listed->second : nullptr;
      if (plate) anchor.floor = plate->floor, anchor.column = plate->column, anchor.use = plate->role;
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
    if (!design_.facade_normal.allFinite()) return;
    std::set<std::string> wholes;
    for (const auto& element : design_.elements)
      if (element->is_panel) wholes.insert(element->parent_guid);
    for (const auto& element : design_.elements) {
      if (!element->is_panel || wholes.count(element->guid) || !element->box_low.allFinite()) continue;
      PanelCase panel;
      panel.guid = element->guid, panel.name = element->name, panel.storey_guid = element->storey_guid;
      panel.instance = element->instance;
      panel.frame_from_panel = element->placement, panel.low = element->box_low, panel.high = element->box_high;
      panel.tolerances = judgement::tolerances_of(tolerances_, facts_of(*element, properties_));
      const std::set<std::string> said(element->anchor_guids.begin(), element->anchor_guids.end());
      const RigidTransform panel_from_project = element->placement.inverse();
      for (std::size_t i = 0; i < inputs_.anchors.size(); ++i) {
        const AnchorCase& anchor = inputs_.anchors[i];
        if (!anchor.design.allFinite()) continue;
        const Eigen::Vector3d reference = anchor.design - anchor.target_offset;
        const bool holds = said.empty() ? distance_from_box(element->box_low, element->box_high,
                                                            panel_from_project * reference) <= reach
                                        : said.count(anchor.element.guid) > 0;
        if (holds) panel.anchors.push_back(i);
      }
      if (!panel.anchors.empty()) inputs_.panels.push_back(std::move(panel));
    }
  }

  DeviationInputs take() {
    inputs_.facade_normal = design_.facade_normal, inputs_.design_file = design_.file_name;
    inputs_.mounting = mounting_.words(from_table_);
    return std::move(inputs_);
  }

 private:
  void describe(const DesignElementT& element, const PlateT* plate, AnchorCase& anchor) {
    anchor.element = facts_of(element, properties_);
    if (plate) {
      anchor.element.batch = plate->batch;
      anchor.mounting = mounting_.covariance(anchor.element, plate->mounting_sigma, plate->nominal_rotation);
      from_table_ += plate->mounting_sigma.size() == 3;
    }
    anchor.tolerances = judgement::tolerances_of(tolerances_, anchor.element);
    anchor.element.properties = nullptr;
    anchor.instance = element.instance, anchor.storey_guid = element.storey_guid;
  }

  void add(AnchorCase anchor) {
    if (!anchor.element.guid.empty()) index_[anchor.element.guid] = inputs_.anchors.size();
    inputs_.anchors.push_back(std::move(anchor));
  }

  const DesignT& design_;
  const judgement::ToleranceTable& tolerances_;
  const judgement::Mounting& mounting_;
  std::size_t from_table_ = 0;
  std::map<std::string, const DesignElementT*> elements_;
  std::map<std::string, std::size_t> index_;
  std::vector<bim::Property> properties_;
  DeviationInputs inputs_;
};

}  // namespace

judgement::DeviationInputs deviation_inputs(const DesignT& design, const ElementMatchesT& matches,
                                            const PlatesT& plates, const judgement::ToleranceTable& tolerances,
                                            double panel_reach, const judgement::Mounting& mounting) {
  Builder builder(design, tolerances, mounting);
  builder.add_listed(matches, plates);
  builder.add_unlisted();
  builder.add_panels(panel_reach);
  return builder.take();
}

}  // namespace plumbline::evaluate
