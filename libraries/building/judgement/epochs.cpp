#include "building/judgement/epochs.hpp"

#include <fmt/core.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <set>

#include "base/text/text.hpp"
#include "building/ifc/former_guids.hpp"
#include "building/ifc/surface_words.hpp"
#include "building/judgement/epoch_findings.hpp"
#include "building/judgement/epoch_movements.hpp"
#include "building/judgement/figures.hpp"
#include "building/judgement/kept_open.hpp"
#include "plumbline/failure.hpp"

namespace plumbline::judgement {
namespace {

/// A design position that differs by more is another design [m].
constexpr double kSameDesign = 1e-4;
/// Judged by another tolerance where it differs by more [m].
constexpr double kSameTolerance = 1e-7;

bool is_open(ToleranceVerdict verdict) {
  return verdict == ToleranceVerdict::fail || verdict == ToleranceVerdict::undecided;
}

EpochItem item_of(const AnchorDeviationT& anchor) {
  EpochItem item{"anchor",     anchor.id,     anchor.guid, anchor.facade ? anchor.facade->facade : "",
                 anchor.floor, anchor.verdict};
  item.design = anchor.design, item.position = anchor.as_built;
  for (std::size_t k = 0; k < 9 && anchor.covariance.size() == 9; ++k)
    item.covariance(static_cast<Eigen::Index>(k / 3), static_cast<Eigen::Index>(k % 3)) = anchor.covariance[k];
  for (const auto& axis : anchor.axes)
    if (std::isfinite(axis->above)) item.limits[axis->axis] = {axis->above, axis->below};
  return item;
}

bool is_open(const PanelJointT& joint) { return joint.change && is_open(joint.change->verdict); }

EpochItem item_of(const PanelDeviationT& panel) {
  EpochItem item{"panel",     panel.name.empty() ? panel.guid : panel.name,
                 panel.guid,  panel.facade ? panel.facade->facade : "",
                 panel.floor, panel.verdict};
  for (const auto& limit : panel.limits) item.limits[limit->axis] = {limit->above, limit->below};
  for (const auto& joint : panel.joints)
    if (is_open(*joint)) {
      ToleranceVerdict& worst = item.open_joints[joint->panel];
      worst = std::max(worst, joint->change->verdict);
    }
  return item;
}

/// One quantity; `topic` tells joints apart whose neighbours share a name.
EpochItem item_of(const SurfaceVerdictT& verdict, const std::string& topic, const std::map<std::string, int>& floors) {
  EpochItem item;
  item.kind = verdict.second.empty() ? "surface" : "joint", item.guid = verdict.guid, item.topic = topic;
  item.quantity = ifc::quantity_of(verdict);
  item.id = verdict.panel + (verdict.second.empty() ? "" : " | " + verdict.second) + ", " + item.quantity;
  if (const auto floor = floors.find(verdict.guid); floor != floors.end()) item.floor = floor->second;
  item.verdict = verdict.verdict;
  if (verdict.verdict != ToleranceVerdict::not_measured) item.value = verdict.value;
  item.limits[item.quantity] = {verdict.upper, -verdict.lower};
  return item;
}

std::vector<EpochItem> items_of(const DeviationT& deviation) {
  std::vector<EpochItem> items;
  for (const auto& anchor : deviation.anchors) items.push_back(item_of(*anchor));
  for (const auto& panel : deviation.panels) items.push_back(item_of(*panel));
  if (!deviation.surfaces) return items;
  std::map<std::string, int> floors;  // by GlobalId
  for (const auto& panel : deviation.panels) floors[panel->guid] = panel->floor;
  const std::vector<std::string> topics = ifc::topics_of(*deviation.surfaces);
  for (std::size_t i = 0; i < topics.size(); ++i)
    items.push_back(item_of(*deviation.surfaces->verdicts[i], topics[i], floors));
  return items;
}

/// The items of a record by what names them.
class Known {
 public:
  explicit Known(const std::vector<EpochItem>& items) {
    for (const EpochItem& item : items) {
      if (!item.guid.empty()) by_guid_.try_emplace({item.kind, element_of(item)}, &item);
      by_id_.try_emplace({item.kind, item.id}, &item);
    }
  }
  const EpochItem* find(const EpochItem& item) const {
    if (!item.guid.empty())
      if (const auto found = by_guid_.find({item.kind, element_of(item)}); found != by_guid_.end())
        return found->second;
    const auto found = by_id_.find({item.kind, item.id});
    // One name on two elements is two things.
    if (found == by_id_.end() || (!item.guid.empty() && !found->second->guid.empty())) return nullptr;
    return found->second;
  }

 private:
  static std::string element_of(const EpochItem& item) { return item.guid + "/" + item.topic + "/" + item.quantity; }

  std::map<std::pair<std::string, std::string>, const EpochItem*> by_guid_, by_id_;
};

/// Whether the two were held against other limits, as far as both are known.
bool is_judged_otherwise(const EpochItem& before, const EpochItem& after) {
  if (before.limits.empty() || after.limits.empty()) return false;
  const auto same = [](double a, double b) {
    return std::abs(a - b) <= kSameTolerance || (!std::isfinite(a) && !std::isfinite(b));
  };
  for (const auto& [axis, limit] : after.limits) {
    const auto found = before.limits.find(axis);
    if (found == before.limits.end() || !same(found->second[0], limit[0]) || !same(found->second[1], limit[1]))
      return true;
  }
  return before.limits.size() != after.limits.size();
}

ChangeKind change_of(const EpochItem& before, ToleranceVerdict after) {
  if (after == ToleranceVerdict::not_measured) return ChangeKind::unseen;
  if (is_open(after))
    return before.open()                                      ? ChangeKind::still_open
           : before.verdict == ToleranceVerdict::not_measured ? ChangeKind::opened
           : before.was_open                                  ? ChangeKind::opened_again
                                                              : ChangeKind::opened;
  return before.verdict == ToleranceVerdict::fail   ? ChangeKind::mended
         : before.verdict == ToleranceVerdict::pass ? ChangeKind::in_order
                                                    : ChangeKind::settled;
}

/// Whether the design has an element no more; false where that is not known.
bool has_left(const std::string& guid, const DesignElements* design) {
  return design && !guid.empty() && !design->guids.contains(guid);
}

/// Whether it has an item no more: the element, or of a joint ("joint/P2", "joint/P2/1" where names are shared) the
/// neighbour.
bool has_left(const EpochItem& item, const DesignElements* design) {
  if (has_left(item.guid, design)) return true;
  constexpr std::string_view joint = "joint/";
  if (!design || !item.topic.starts_with(joint)) return false;
  const auto has = [&](const std::string& name) {
    return design->names.contains(name) || design->guids.contains(name);
  };
  const std::string neighbour = item.topic.substr(joint.size());
  return !has(neighbour) && !has(neighbour.substr(0, neighbour.rfind('/')));
}

/// Joints of a panel that were open and that this campaign did not judge: the neighbour was not measured again.
std::map<std::string, ToleranceVerdict> joints_left_open(const EpochItem& before, const DeviationT& after,
                                                         const DesignElements* design) {
  if (before.open_joints.empty()) return {};
  std::map<std::string, ToleranceVerdict> left = before.open_joints;
  std::erase_if(left, [&](const auto& joint) { return has_left(joint.first, design); });
  for (const auto& panel : after.panels)
    if (panel->guid == before.guid)
      for (const auto& joint : panel->joints)
        if (joint->change && joint->change->verdict != ToleranceVerdict::not_measured) left.erase(joint->panel);
  return left;
}

ToleranceVerdict worst_of(const std::map<std::string, ToleranceVerdict>& joints) {
  ToleranceVerdict worst = ToleranceVerdict::not_measured;
  for (const auto& [panel, verdict] : joints) worst = std::max(worst, verdict);
  return worst;
}

std::string name_of_panel(const std::string& guid, const Known& known) {
  EpochItem panel{"panel", guid, guid, ""};
  const EpochItem* found = known.find(panel);
  return found ? found->id : guid;
}

/// A joint that was open is settled for good when its neighbour leaves the design.
void tell_gone(const EpochItem& before, const Known& known, const DesignElements* design, AsBuiltChangeT& change) {
  std::vector<std::string> names;
  for (const auto& [guid, verdict] : before.open_joints)
    if (has_left(guid, design)) names.push_back(name_of_panel(guid, known));
  if (!names.empty() && change.after == ToleranceVerdict::pass)
    change.note = "its joint to " + list_of(names, 3) + (names.size() > 1 ? " were" : " was") +
                  " open and is none any more: the design does not have the neighbour";
}

/// What passes with a joint that is still open closes nothing.
void keep_open(const std::map<std::string, ToleranceVerdict>& joints, const Known& known, AsBuiltChangeT& change) {
  if (joints.empty() || change.after != ToleranceVerdict::pass) return;
  std::vector<std::string> names;
  for (const auto& [guid, verdict] : joints) names.push_back(name_of_panel(guid, known));
  change.change = ChangeKind::unseen;
  change.note = "its joint to " + list_of(names, 3) + (names.size() > 1 ? " were" : " was") +
                " open and not measured again, because the neighbour was not";
}

std::unique_ptr<AsBuiltChangeT> change_between(const EpochItem* before, const EpochItem& after, ChangeKind change) {
  auto out = std::make_unique<AsBuiltChangeT>();
  out->kind = after.kind, out->id = after.id, out->guid = after.guid, out->topic = after.topic;
  out->value = after.value;
  if (before) out->value_before = before->value;
  out->floor = after.floor, out->facade = after.facade;
  out->before = before ? before->verdict : ToleranceVerdict::not_measured;
  out->after = after.verdict, out->change = change;
  out->movement = Eigen::Vector3d::Constant(std::numeric_limits<double>::quiet_NaN());
  return out;
}

/// What failed and is held against more than then may pass for that alone.
void tell_wider_limits(const EpochItem& before, const EpochItem& now, AsBuiltChangeT& change) {
  if (!is_open(change.before) || change.after != ToleranceVerdict::pass) return;
  const bool wider = std::any_of(before.limits.begin(), before.limits.end(), [&](const auto& limit) {
    const auto later = now.limits.find(limit.first);
    return !now.limits.empty() && (later == now.limits.end() || later->second[0] > limit.second[0] + kSameTolerance ||
                                   later->second[1] > limit.second[1] + kSameTolerance);
  });
  const auto old = before.limits.find(now.quantity);
  const bool would_do = std::isfinite(now.value) && old != before.limits.end() && now.value <= old->second[0] &&
                        -now.value <= old->second[1];
  if (!wider || would_do) return;
  change.change = ChangeKind::settled;
  // Of anchors and panels each axis has its own value, which no record keeps: the limit may not be what it passes by.
  change.note += std::string(change.note.empty() ? "" : "; ") +
                 (now.quantity.empty() ? "a limit is wider than in the campaign before"
                                       : "it passes by a wider limit than in the campaign before");
}

/// The topic of BCF that stood under another GlobalId is at an end, the element is not.
void tell_former(const EpochItem& before, const EpochItem& now, AsBuiltChangesT& out) {
  if (!before.open() || before.guid_before.empty()) return;
  EpochItem former = before;
  former.guid = before.guid_before, former.verdict = ToleranceVerdict::not_measured;
  former.value = std::numeric_limits<double>::quiet_NaN();
  out.changes.push_back(change_between(&before, former, ChangeKind::left_out));
  out.changes.back()->note = "it has another GlobalId in this design, under which it goes on: " + now.guid;
}

void tell_found_again(const std::set<const EpochItem*>& met, AsBuiltChangesT& out) {
  std::vector<std::string> names;
  for (const EpochItem* item : met)
    if (!item->guid_before.empty() && (item->kind == "anchor" || item->kind == "panel"))
      names.push_back(item->kind + " " + item->id);
  std::sort(names.begin(), names.end());
  if (!names.empty())
    out.warnings.push_back(
        "found again by name and place, because the design has other GlobalIds for them than in the "
        "campaign before: " +
        list_of(names, 8));
}

/// "3 anchors", "1 panel"; of surfaces and joints the limits are counted.
std::string counted(const std::string& kind, std::size_t n) {
  static const std::map<std::string, std::string> one = {{"surface", "limit of surfaces"},
                                                         {"joint", "limit of joints"}};
  static const std::map<std::string, std::string> many = {{"surface", "limits of surfaces"},
                                                          {"joint", "limits of joints"}};
  const auto& words = n == 1 ? one : many;
  const auto word = words.find(kind);
  return std::to_string(n) + " " + (word != words.end() ? word->second : kind + (n == 1 ? "" : "s"));
}

void compare_judgements(const EpochRecord& before, const DeviationT& after, std::size_t other_design,
                        std::map<std::string, std::size_t> other_limits, AsBuiltChangesT& out) {
  if (!after.doubts.empty())
    out.warnings.push_back(
        "this campaign's measurement is not to be trusted: what was in order is open for that alone, and nothing "
        "counts "
        "as mended");
  if (std::abs(before.tau - after.tau) > kSameTolerance || std::abs(before.risk - after.risk) > 1e-9) {
    out.warnings.push_back(fmt::format(
        "the campaign before was judged by {:.4g} mm and a risk of {:.3g}, this one by {:.4g} mm and {:.3g}: a verdict "
        "may have changed for that alone",
        1e3 * before.tau, before.risk, 1e3 * after.tau, after.risk));
    other_limits.erase("anchor"), other_limits.erase("panel");  // it says so of all of them
  }
  std::vector<std::string> held;
  std::size_t n = 0;
  for (const auto& [kind, count] : other_limits) held.push_back(counted(kind, count)), n += count;
  if (n > 0)
    out.warnings.push_back(text::join(held) + (n == 1 ? " is" : " are") +
                           " held against other tolerances than in the campaign before: verdicts may have changed for "
                           "that alone");
  if (other_design > 0)
    out.warnings.push_back(std::to_string(other_design) +
                           " anchors have another place in the design than in the campaign before: their verdicts may "
                           "have changed for that alone");
}

}  // namespace

EpochRecord record_of(const DeviationT& deviation, const std::string& epoch, const EpochRecord* before,
                      const DesignElements* design, const AsBuiltChangesT* changes) {
  EpochRecord record{epoch, deviation.design_file, deviation.tau, deviation.risk, items_of(deviation)};
  static const std::vector<EpochItem> none;
  static const EpochItem nowhere{};
  const Known known(before ? before->items : none);
  std::set<const EpochItem*> met;
  const auto kept_open = items_kept_open(changes);
  for (EpochItem& item : record.items) {
    const EpochItem* earlier = known.find(item);
    if (earlier) met.insert(earlier);
    if (earlier && item.kind == "panel") {
      const auto left = joints_left_open(*earlier, deviation, design);
      item.open_joints.insert(left.begin(), left.end());
      if (item.verdict == ToleranceVerdict::pass) item.verdict = std::max(item.verdict, worst_of(left));
    }
    item.was_open = item.open() || (earlier && earlier->was_open);
    if (earlier && earlier->open() && kept_open.contains({item.kind, item.id, item.guid, item.topic}))
      item.verdict = earlier->verdict;  // compare_epochs says why
    const bool is_measured = item.verdict != ToleranceVerdict::not_measured;
    if (is_measured && deviation.doubts.empty()) continue;
    item.position = earlier ? earlier->position : nowhere.position;
    item.covariance = earlier ? earlier->covariance : nowhere.covariance;
    if (!is_measured && earlier) item.verdict = earlier->verdict, item.limits = earlier->limits;
    if (!is_measured && earlier) item.value = earlier->value;
  }
  // A panel without a measured anchor is not judged, and not forgotten either; nor is what was open and is not in the
  // design: it may be a part of the building's, and the topic of BCF stays open too.
  if (before)
    for (const EpochItem& item : before->items)
      if (!met.contains(&item) && (item.open() || !has_left(item, design))) record.items.push_back(item);
  record.findings = findings_kept(deviation, before, changes);
  return record;
}

AsBuiltChangesT compare_epochs(const EpochRecord& before, const DeviationT& after, const std::string& epoch,
                               const DesignElements* design) {
  AsBuiltChangesT out;
  out.before = before.epoch, out.after = epoch, out.compared = true;
  const Known known(before.items);
  std::set<const EpochItem*> met;
  std::vector<MeasuredTwice> pairs;
  std::map<std::string, int> columns;  // by anchor
  for (const auto& anchor : after.anchors) columns[anchor->id] = anchor->column;
  if (!after.datum.empty())
    out.warnings.push_back(
        "this campaign was fitted to its own anchors: what all of them moved by together is not seen, and a single one "
        "has moved only beyond what the place of the whole is uncertain by");
  std::size_t other_design = 0;
  std::map<std::string, std::size_t> other_limits;            // by kind
  std::vector<std::pair<EpochItem, const EpochItem*>> items;  // now, and before
  for (EpochItem& now : items_of(after)) {
    const EpochItem* earlier = known.find(now);
    items.emplace_back(std::move(now), earlier);
  }
  for (const auto& [now, earlier] : items) {
    if (earlier) met.insert(earlier);
    const ChangeKind change = earlier ? change_of(*earlier, now.verdict) : ChangeKind::added;
    out.changes.push_back(change_between(earlier, now, change));
    if (!earlier) continue;
    if (now.verdict != ToleranceVerdict::not_measured && is_judged_otherwise(*earlier, now)) ++other_limits[now.kind];
    tell_wider_limits(*earlier, now, *out.changes.back());
    if (now.kind == "panel") {
      tell_gone(*earlier, known, design, *out.changes.back());
      keep_open(joints_left_open(*earlier, after, design), known, *out.changes.back());
    }
    if (now.kind != "anchor") continue;
    if ((earlier->design - now.design).norm() > kSameDesign) ++other_design;
    if (earlier->position.allFinite() && now.position.allFinite())
      pairs.push_back({out.changes.back().get(), now.position - earlier->position,
                       Eigen::Matrix3d(earlier->covariance + now.covariance), now.design, columns[now.id]});
  }
  if (met.empty())
    throw BadInput("no anchor or panel of the campaign before (" + std::to_string(before.items.size()) + " of " +
                   before.design_file + ") is in this one; 'before' is as_built.json of another building");
  for (std::size_t i = 0, n = out.changes.size(); i < n; ++i)
    if (items[i].second) tell_former(*items[i].second, items[i].first, out);
  tell_found_again(met, out);
  std::vector<std::string> open_elsewhere;
  for (const EpochItem& item : before.items) {
    if (met.contains(&item)) continue;
    EpochItem gone = item;
    gone.verdict = ToleranceVerdict::not_measured;
    // Panels are judged only where an anchor was measured, surfaces where somebody looked at them.
    gone.value = std::numeric_limits<double>::quiet_NaN();
    const bool left_out = item.kind == "anchor" || has_left(item, design);
    if (left_out && item.open()) open_elsewhere.push_back(item.kind + " " + item.id);
    out.changes.push_back(change_between(&item, gone, left_out ? ChangeKind::left_out : ChangeKind::unseen));
  }
  if (!open_elsewhere.empty())
    out.warnings.push_back("open in the campaign before and not in the design or the plate table of this one: " +
                           list_of(open_elsewhere, 20) +
                           "; they stay open in as_built.json and in BCF until a design that has them is judged");
  test_movements(pairs, out);
  keep_open_for_the_frame(pairs, after, out);
  compare_judgements(before, after, other_design, other_limits, out);
  return out;
}

const char* words_of(ChangeKind change) {
  static constexpr std::array<const char*, 9> words = {
      "in order", "mended", "settled", "still open", "opened", "opened again", "not measured again", "new", "left out"};
  return words[static_cast<size_t>(change)];
}

std::string words_of_changes(const AsBuiltChangesT& changes) {
  std::map<ChangeKind, int> counts;
  int moved = 0;
  const auto former = ifc::former_guids(changes);
  for (const auto& change : changes.changes)
    if (!former.contains(change.get())) ++counts[change->change], moved += change->moved;
  std::string text;
  const auto add = [&](int n, const std::string& what) {
    if (n > 0) text += (text.empty() ? "" : ", ") + std::to_string(n) + " " + what;
  };
  for (const ChangeKind kind : {ChangeKind::mended, ChangeKind::settled, ChangeKind::opened_again, ChangeKind::opened,
                                ChangeKind::still_open, ChangeKind::unseen, ChangeKind::added, ChangeKind::left_out})
    add(counts[kind], words_of(kind));
  add(moved, moved == 1 ? "anchor has moved" : "anchors have moved");
  return text.empty() ? "nothing has changed" : text;
}

}  // namespace plumbline::judgement
