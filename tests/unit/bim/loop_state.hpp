// A loop's plan and state on the anchors and panels of a design, with every state of an item in it.
#pragma once

#include <utility>

#include "artifacts/installation_plan.hpp"
#include "artifacts/loop_state.hpp"
#include "building/ifc/design.hpp"

namespace plumbline::test {

inline std::unique_ptr<LoopItemT> loop_item(const std::string& kind, const std::string& id, const std::string& guid,
                                            ItemStatus status) {
  auto item = std::make_unique<LoopItemT>();
  item->kind = kind, item->id = id, item->guid = guid, item->status = status, item->floor = 1;
  item->setting = {0.001, 0.004, 0}, item->pending = {0, 0.002, 0}, item->expected.setZero();
  item->revision = 2, item->by = "robot-1", item->at = "2026-05-02T08:00:00Z", item->why = "because";
  return item;
}

/// A line of the journal without its chain.
inline std::string journal_words(const LoopItemT& item, const std::string& from, const std::string& to,
                                 const std::string& why, const std::string& reason = "other") {
  return "{\"round\": 1, \"kind\": \"" + item.kind + "\", \"item\": \"" + item.id + "\", \"from\": \"" + from +
         "\", \"to\": \"" + to + "\", \"by\": \"robot-1\", \"at\": \"2026-05-02T08:00:00Z\", \"why\": \"" + why +
         "\", \"reason\": \"" + reason + "\"}";
}

/// Each panel hangs on two anchors, and waits for the panel before it.
inline std::pair<InstallationPlanT, LoopStateT> loop_of(const ifc::Design& design) {
  InstallationPlanT plan;
  LoopStateT state;
  plan.basis = std::string(64, 'a'), plan.design_file = design.file_name, state.round = 3;
  int k = 0;
  for (const ifc::Element& element : design.elements) {
    if (!element.is_anchor) continue;
    auto bracket = std::make_unique<BracketSettingT>();
    bracket->difference_sigma.setZero();
    bracket->id = "anchor " + std::to_string(k), bracket->guid = element.guid, bracket->floor = 1;
    bracket->design = element.position, bracket->measured = element.position + Eigen::Vector3d(0.001, 0, -0.004);
    bracket->axes = {Eigen::Vector3d::UnitX(), Eigen::Vector3d::UnitZ(), -Eigen::Vector3d::UnitY()};
    for (Eigen::Vector3d* v : {&bracket->sigma, &bracket->asked, &bracket->setting, &bracket->low, &bracket->high})
      v->setZero();
    state.items.push_back(loop_item("bracket", bracket->id, element.guid, static_cast<ItemStatus>(k++ % 9)));
    plan.brackets.push_back(std::move(bracket));
  }
  k = 0;
  for (const ifc::Element& element : design.elements) {
    if (!element.is_panel || plan.brackets.empty()) continue;
    auto panel = std::make_unique<PlannedPanelT>();
    panel->id = "panel " + std::to_string(k), panel->guid = element.guid, panel->floor = 1;
    panel->brackets = {plan.brackets[static_cast<std::size_t>(k) % plan.brackets.size()]->id, plan.brackets.back()->id};
    panel->brackets.resize(panel->brackets[0] == panel->brackets[1] ? 1 : 2);
    if (k > 0) panel->depends_on = {plan.panels.back()->id};
    panel->centre = element.position, panel->shift = {0.001, 0, 0}, panel->rotation = {0, 0, 1e-4};
    for (const auto& [x, z] : {std::pair{-0.7, -1.5}, {0.7, -1.5}, {-0.7, 1.5}, {0.7, 1.5}})
      panel->corners.push_back(element.position + Eigen::Vector3d(x, 0, z));
    panel->gate = static_cast<GateDecision>(k % 3), panel->p_in = 0.9, panel->reason = "p 0.900";
    state.items.push_back(loop_item("panel", panel->id, element.guid,
                                    k % 4 == 0   ? ItemStatus::verified
                                    : k % 4 == 1 ? ItemStatus::rejected
                                    : k % 4 == 2 ? ItemStatus::relocalised
                                                 : ItemStatus::planned));
    state.items.back()->hangs = k % 4 == 0 || k % 4 == 2, state.items.back()->seen = k % 4 == 0;
    plan.panels.push_back(std::move(panel)), ++k;
  }
  return {std::move(plan), std::move(state)};
}

}  // namespace plumbline::test
