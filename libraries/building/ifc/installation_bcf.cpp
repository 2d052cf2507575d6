#include "building/ifc/installation_bcf.hpp"

#include <algorithm>
#include <cmath>
#include <map>
#include <nlohmann/json.hpp>
#include <regex>
#include <set>

#include "building/ifc/bcf_topic.hpp"

namespace plumbline::ifc {
namespace {

/// State that it went to, or NO_GO, and why.
using Words = std::vector<std::pair<std::string, BcfComment>>;

/// Whether XML Schema takes it as xs:dateTime: 2026-05-02T08:00:00, with a fraction, with Z or +02:00.
bool is_xml_date(const std::string& text) {
  static const std::regex date(R"(\d{4}-\d\d-\d\dT\d\d:\d\d:\d\d(\.\d+)?(Z|[+-]\d\d:\d\d)?)");
  return std::regex_match(text, date);
}

/// What the journal says of each item, by kind and name.
std::map<std::pair<std::string, std::string>, Words> history_of(const LoopStateT& state, const BcfOptions& options) {
  std::map<std::pair<std::string, std::string>, Words> history;
  for (const std::string& text : state.journal) {
    const auto line = nlohmann::json::parse(text, nullptr, false);
    if (!line.is_object()) continue;
    const auto word = [&](const char* key) { return line.value(key, std::string()); };
    BcfComment comment{is_xml_date(word("at")) ? word("at") : options.date,
                       word("by").empty() || word("by") == "plumbline" ? options.author : word("by"),
                       "round " + std::to_string(line.value("round", 0)) + ": " + word("from") + " to " + word("to") +
                           ": " + word("why")};
    const bool no_go = word("reason") == EnumNameItemReason(ItemReason::may_not_hang);
    history[{word("kind"), word("item")}].emplace_back(no_go ? "NO_GO" : word("to"), std::move(comment));
  }
  return history;
}

bool went_to(const Words& words, const std::string& state) {
  return std::any_of(words.begin(), words.end(), [&](const auto& word) { return word.first == state; });
}

bool was_wrong(const Words& words) { return went_to(words, "REJECTED") || went_to(words, "REWORK"); }

/// To be looked at, or to be taken down.
bool is_wrong(const LoopItemT& item) {
  return item.status == ItemStatus::rejected || (item.status == ItemStatus::rework && item.hangs);
}

ToleranceVerdict verdict_of(const LoopItemT& item) {
  return item.status == ItemStatus::verified ? ToleranceVerdict::pass
         : is_wrong(item)                    ? ToleranceVerdict::fail
                                             : ToleranceVerdict::undecided;
}

std::unique_ptr<FacadeFrameT> drawn_frame(const Eigen::Vector3d& right, const Eigen::Vector3d& up) {
  auto frame = std::make_unique<FacadeFrameT>();
  frame->right = right.normalized(), frame->up = up.normalized(), frame->out = frame->right.cross(frame->up);
  frame->confirmed = true;
  return frame;
}

/// Panels and brackets as the snapshot draws them.
DeviationT surroundings_of(const InstallationPlanT& plan, const LoopStateT& state) {
  std::map<std::pair<std::string, std::string>, const LoopItemT*> items;
  for (const auto& item : state.items) items[{item->kind, item->id}] = item.get();
  DeviationT drawn;
  static const char* kCorners[] = {"bottom_left", "bottom_right", "top_left", "top_right"};
  for (const auto& planned : plan.panels) {
    if (planned->corners.size() != 4) continue;
    auto panel = std::make_unique<PanelDeviationT>();
    panel->guid = planned->guid, panel->name = planned->id;
    panel->facade = drawn_frame(planned->corners[1] - planned->corners[0], planned->corners[2] - planned->corners[0]);
    for (std::size_t k = 0; k < 4; ++k) {
      auto corner = std::make_unique<PanelCornerT>();
      corner->name = kCorners[k], corner->design = planned->corners[k];
      panel->corners.push_back(std::move(corner));
    }
    const auto item = items.find({"panel", planned->id});
    panel->verdict = item == items.end() ? ToleranceVerdict::not_measured : verdict_of(*item->second);
    drawn.panels.push_back(std::move(panel));
  }
  for (const auto& bracket : plan.brackets) {
    auto anchor = std::make_unique<AnchorDeviationT>();
    anchor->id = bracket->id, anchor->guid = bracket->guid, anchor->design = bracket->design;
    if (bracket->axes.size() == 3) anchor->facade = drawn_frame(bracket->axes[0], bracket->axes[1]);
    const auto item = items.find({"bracket", bracket->id});
    anchor->verdict = item == items.end() ? ToleranceVerdict::not_measured : verdict_of(*item->second);
    drawn.anchors.push_back(std::move(anchor));
  }
  return drawn;
}

class Topics {
 public:
  Topics(const InstallationPlanT& plan, const LoopStateT& state, const BcfOptions& options)
      : state_(state), drawn_(surroundings_of(plan, state)), history_(history_of(state, options)) {
    for (const auto& panel : plan.panels) panels_[panel->id] = panel.get();
    for (const auto& anchor : drawn_.anchors) anchors_[anchor->id] = anchor.get();
    for (const auto& panel : drawn_.panels) drawn_panels_[panel->name] = panel.get();
  }

  std::vector<BcfIssue> all(const InstallationPlanT& plan) const {
    std::vector<BcfIssue> issues;
    for (const std::string& control : state_.moved_control)
      issues.push_back(of_the_whole(control + " moved", "control " + control));
    std::map<std::string, int> known;  // a file has no topic twice
    const auto key = [&](const std::string& about) {
      const int count = ++known[about];
      return count > 1 ? about + ", " + std::to_string(count) : about;
    };
    for (const int r : by_hand_of_no_panel(plan))
      issues.push_back(of_the_whole("By hand: " + plan.relaxations[r],
                                    key("by hand " + topic_of(plan.relaxations, plan.relaxation_topics, r))));
    for (int i = 0; i < static_cast<int>(plan.doubts.size()); ++i)
      issues.push_back(of_the_whole("The measurement is in doubt: " + plan.doubts[i],
                                    key("doubt " + topic_of(plan.doubts, plan.doubt_topics, i))));
    std::vector<std::string> nowhere;
    for (const bool closed : {false, true})
      for (const auto& item : state_.items)
        if (const std::string what = what_is_wrong(*item);
            !what.empty() && is_mended(*item) == closed && !add(*item, what, issues) && !closed)
          nowhere.push_back(item->id);
    if (!nowhere.empty()) issues.push_back(of_items_nowhere(nowhere));
    return issues;
  }

  const DeviationT& drawn() const { return drawn_; }

 private:
  /// What it is about; of a plan that does not say it, its words without their figures.
  static std::string topic_of(const std::vector<std::string>& words, const std::vector<std::string>& topics, int i) {
    return topics.size() == words.size() ? topics[i] : without_figures(words[i]);
  }

  static BcfIssue of_the_whole(const std::string& title, const std::string& key) {
    BcfIssue issue;
    issue.guid = key, issue.title = title, issue.about = "installation";
    issue.description = title + ". Nothing there is verified or released before somebody has looked.";
    return issue;
  }

  /// What is open and has no place in a model is told all the same.
  static BcfIssue of_items_nowhere(const std::vector<std::string>& ids) {
    constexpr std::size_t kNamed = 20;
    BcfIssue issue = of_the_whole(
        std::to_string(ids.size()) + (ids.size() == 1 ? " item is" : " items are") + " open that no viewer can show",
        "nowhere");
    issue.description = issue.title + " (no GlobalId, or not in the plan):";
    for (std::size_t i = 0; i < std::min(ids.size(), kNamed); ++i) issue.description += (i ? ", " : " ") + ids[i];
    issue.description += ids.size() > kNamed ? " and more; next.txt has all." : ". next.txt says what is to be done.";
    return issue;
  }

  const Words& words_of(const LoopItemT& item) const {
    static const Words none;
    const auto found = history_.find({item.kind, item.id});
    return found == history_.end() ? none : found->second;
  }

  static bool is_mended(const LoopItemT& item) { return item.status == ItemStatus::verified && !item.gone; }

  /// The plan of a panel that waits; null: it does not wait, or is in none.
  const PlannedPanelT* waiting(const LoopItemT& item) const {
    const auto panel = panels_.find(item.id);
    const bool waits = item.kind == "panel" && item.status == ItemStatus::planned && !item.gone;
    return waits && panel != panels_.end() ? panel->second : nullptr;
  }

  /// What is to be done by hand and that no panel's own topic has: which of the plan's.
  std::vector<int> by_hand_of_no_panel(const InstallationPlanT& plan) const {
    std::set<int> told;
    for (const auto& item : state_.items)
      if (const PlannedPanelT* panel = waiting(*item); panel && panel->gate != GateDecision::go)
        told.insert(panel->by_hand.begin(), panel->by_hand.end());
    std::vector<int> rest;
    for (int r = 0; r < static_cast<int>(plan.relaxations.size()); ++r)
      if (!told.contains(r)) rest.push_back(r);
    return rest;
  }

  std::string what_is_wrong(const LoopItemT& item) const {
    if (item.gone) return item.hangs ? "look whether it is to be taken down: the design does not have it any more" : "";
    if (item.status == ItemStatus::rejected) return "look at it: " + item.why;
    if (item.status == ItemStatus::relocalised && item.hangs && !item.seen) return "nobody has seen it hang";
    if (item.status == ItemStatus::rework && item.hangs) return "take it down: " + item.why;
    if (const PlannedPanelT* panel = waiting(item)) {
      if (panel->gate == GateDecision::no_go) return "may not be hung so: " + panel->reason;
      if (panel->gate == GateDecision::hold && !panel->by_hand.empty()) return "by hand first: " + panel->reason;
    }
    if (was_wrong(words_of(item)))
      return item.status == ItemStatus::verified ? "mended: " + item.why : "is done again: " + item.why;
    if (went_to(words_of(item), "NO_GO"))
      return item.status == ItemStatus::verified ? "mended: " + item.why : "may be hung when its turn is: " + item.why;
    return {};
  }

  /// False if it has no place in a model.
  bool add(const LoopItemT& item, const std::string& what, std::vector<BcfIssue>& issues) const {
    BcfIssue issue;
    issue.about = "installation", issue.closed = is_mended(item);
    issue.title = (item.kind == "bracket" ? "Bracket " : "Panel ") + item.id + ": " + what;
    issue.description = "State " + std::string(EnumNameItemStatus(item.status)) + ", done again " +
                        std::to_string(item.reworks) + " times: " + what + ".";
    issue.storey = item.floor > 0 ? "Floor " + std::to_string(item.floor) : "";
    issue.verdict = is_wrong(item) ? ToleranceVerdict::fail : ToleranceVerdict::undecided;
    for (const auto& [to, comment] : words_of(item)) issue.comments.push_back(comment);
    if (!place(item, issue) || issue.guid.size() != 22) return false;
    issues.push_back(std::move(issue));
    return true;
  }

  /// Where it is and how it faces; false if the plan does not have it.
  bool place(const LoopItemT& item, BcfIssue& issue) const {
    if (item.kind == "bracket") {
      const auto found = anchors_.find(item.id);
      if (found == anchors_.end()) return false;
      issue.guid = found->second->guid, issue.centre = found->second->design, issue.reach = 0.3;
      issue.frame = view_of(found->second->facade);
      return true;
    }
    const auto found = drawn_panels_.find(item.id);
    if (found == drawn_panels_.end()) return false;
    issue.guid = found->second->guid, issue.frame = view_of(found->second->facade);
    for (const auto& corner : found->second->corners) issue.centre += corner->design / 4;
    for (const auto& corner : found->second->corners)
      issue.reach = std::max(issue.reach, (corner->design - issue.centre).norm());
    return true;
  }

  const LoopStateT& state_;
  DeviationT drawn_;
  std::map<std::pair<std::string, std::string>, Words> history_;
  std::map<std::string, const PlannedPanelT*> panels_;
  std::map<std::string, const AnchorDeviationT*> anchors_;
  std::map<std::string, const PanelDeviationT*> drawn_panels_;
};

}  // namespace

std::string write_installation_bcf(const InstallationPlanT& plan, const LoopStateT& state, const BcfOptions& options) {
  const Topics topics(plan, state, options);
  const BcfSurroundings surroundings(topics.drawn());
  const std::vector<BcfIssue> issues = topics.all(plan);
  BcfFile file(options, plan.design_file, issues.size());
  for (const BcfIssue& issue : issues) file.add(issue, surroundings);
  return file.finish();
}

}  // namespace plumbline::ifc
