#include "building/ifc/installation_ifc.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <map>

#include "base/text/words.hpp"
#include "building/ifc/ifc_appender.hpp"
#include "building/ifc/ifc_units.hpp"
#include "building/step/step_writer.hpp"

namespace plumbline::ifc {

const char* label_of(ItemStatus status) {
  static constexpr std::array kNames = {"PLANNED",  "RELEASED", "EXECUTING", "EXECUTED", "RELOCALISED",
                                        "VERIFIED", "REWORK",   "REJECTED",  "STALE"};
  const auto at = static_cast<std::size_t>(status);
  return at < kNames.size() ? kNames[at] : "PLANNED";
}

namespace {

using step::reference;

/// Of a bracket that no panel hangs on.
constexpr const char* kNotNeeded = "NOT_NEEDED";

const char* gate_label(GateDecision gate) {
  return gate == GateDecision::go ? "GO" : gate == GateDecision::no_go ? "NO_GO" : "HOLD";
}

class InstallationWriter {
 public:
  InstallationWriter(const step::File& file, const Design& design, const InstallationPlanT& plan,
                     const LoopStateT& state, const InstallationIfcOptions& options)
      : model_(file),
        design_(design),
        plan_(plan),
        state_(state),
        options_(options),
        appender_(model_, design.project_guid, design.length_unit, options.timestamp) {
    for (const Element& element : design.elements) {
      const auto instance = file.find(element.instance);
      if (instance && file.contains(*instance, element.guid)) elements_[element.guid] = element.instance;
    }
    for (const auto& bracket : plan.brackets) brackets_[bracket->id] = bracket.get();
    for (const auto& panel : plan.panels) panels_[panel->id] = panel.get();
  }

  AsBuiltIfc write() {
    states_ =
        appender_.enumeration("ASB_InstallationStatus", {"PLANNED", "RELEASED", "EXECUTING", "EXECUTED", "RELOCALISED",
                                                         "VERIFIED", "REWORK", "REJECTED", "STALE", kNotNeeded});
    gates_ = appender_.enumeration("ASB_Gate", {"GO", "HOLD", "NO_GO"});
    std::vector<std::string> tasks;
    for (const auto& item : state_.items) {
      const auto element = elements_.find(guid_of(*item));
      if (element == elements_.end()) {
        missing_.push_back(item->id);
        continue;
      }
      write_state(*item, element->second);
      if (!is_idle(*item)) tasks.push_back(reference(write_task(*item, element->second)));
    }
    if (!tasks.empty()) write_summary(tasks);
    write_sequence();
    if (!missing_.empty())
      result_.warnings.push_back(std::to_string(missing_.size()) +
                                 " items are not in the file and have no state there: " + text::join(missing_, 4));
    result_.additions = appender_.take_lines(), result_.instances_added = appender_.count();
    return std::move(result_);
  }

 private:
  std::string key(const std::string& what) const {
    return "installation/" + (options_.epoch.empty() ? "" : options_.epoch + "/") + what;
  }

  std::string guid_of(const LoopItemT& item) const {
    if (!item.guid.empty()) return item.guid;
    if (item.kind == "bracket") return brackets_.count(item.id) ? brackets_.at(item.id)->guid : std::string();
    return panels_.count(item.id) ? panels_.at(item.id)->guid : std::string();
  }

  /// A bracket on which no panel hangs, or a place of a sill, and that nobody was asked to set: it has a place, and no
  /// work.
  bool is_idle(const LoopItemT& item) const {
    const auto bracket = brackets_.find(item.id);
    return item.kind == "bracket" && item.status == ItemStatus::planned && bracket != brackets_.end() &&
           (bracket->second->use == BracketUse::nothing || bracket->second->use == BracketUse::sill);
  }

  void write_state(const LoopItemT& item, InstanceId element) {
    PropertySet set(appender_);
    set.label("Epoch", options_.epoch);
    set.choice("Status", is_idle(item) ? kNotNeeded : label_of(item.status), states_,
               item.kind == "bracket" ? "VERIFIED: measured where it was to be set"
                                      : "VERIFIED: seen to hang, and measured within its limits");
    set.label("Why", item.why);
    set.label("By", item.by);
    set.date_time("At", item.at);
    set.integer("Round", state_.round, "Of the loop, when this was written");
    set.integer("Revision", item.revision, "Of the plan that released it; 0: none did");
    set.integer("Reworks", item.reworks);
    if (item.kind == "bracket")
      write_bracket(item, set);
    else
      write_panel(item, set);
    set.label("PlanBasis", plan_.basis, "SHA-256 of the measurement that the plan rests on");
    const std::string name =
        options_.epoch.empty() ? "ASB_InstallationState" : "ASB_InstallationState_" + options_.epoch;
    set.attach(key(guid_of(item)), name, "Where this stands in the execution loop", {element});
  }

  void write_bracket(const LoopItemT& item, PropertySet& set) {
    const char* names[] = {"Right", "Up", "Out"};
    for (int k = 0; k < 3; ++k)
      set.length(
          std::string("Set") + names[k], item.setting[k],
          k == 0 ? "What the bracket was set by in all, as measured; seen by one who stands before the facade" : "");
    if (item.status == ItemStatus::released || item.status == ItemStatus::executed)
      for (int k = 0; k < 3; ++k)
        set.length(std::string("Asked") + names[k], item.pending[k],
                   k == 0 ? "What it was last asked to be set by" : "");
    const auto found = brackets_.find(item.id);
    if (found == brackets_.end() || !found->second->measured.allFinite()) return;
    const Eigen::Vector3d off = found->second->measured - found->second->design;
    const char* axes[] = {"MeasuredX", "MeasuredY", "MeasuredZ"};
    for (int k = 0; k < 3; ++k)
      set.length(axes[k], off[k], k == 0 ? "Where its plate is measured, minus the design" : "");
  }

  void write_panel(const LoopItemT& item, PropertySet& set) {
    set.boolean("Hangs", item.hangs, "By the report of who hung it");
    set.boolean("Seen", item.seen, "It was itself measured there, or a person has seen it");
    const auto found = panels_.find(item.id);
    if (found == panels_.end()) return;
    const PlannedPanelT& panel = *found->second;
    set.choice("Gate", gate_label(panel.gate), gates_,
               "GO: hangs within all its limits with the probability asked for");
    set.probability("ProbabilityInside", panel.p_in, "That all its lengths are within their limits at once");
    set.label("GateReason", panel.reason);
    if (!item.hangs) return;
    std::vector<std::string> warnings;
    const double radian = read_units(model_, model_.all("IFCPROJECT").at(0), warnings).plane_angle;
    const char* axes[] = {"X", "Y", "Z"};
    for (int k = 0; k < 3; ++k)
      set.length(std::string("Shift") + axes[k], panel.shift[k],
                 k == 0 ? "Of the centre as it hangs by its brackets, minus the design" : "");
    for (int k = 0; k < 3; ++k) set.angle(std::string("Rotation") + axes[k], panel.rotation[k], radian);
  }

  InstanceId write_task(const LoopItemT& item, InstanceId element) {
    const std::string verb = item.kind == "bracket" ? "Set bracket " : "Hang panel ";
    const InstanceId task = add_task(guid_of(item), verb + item.id, item.id, label_of(item.status), item.why);
    appender_.add_root("IFCRELASSIGNSTOPROCESS", key(guid_of(item)), "", "",
                       {step::list({reference(element)}), step::null, reference(task), step::null});
    tasks_[{item.kind, item.id}] = task;
    return task;
  }

  /// Identification, then in IFC2X3 neither a long description nor a type of task.
  InstanceId add_task(const std::string& what, const std::string& name, const std::string& id,
                      const std::string& status, const std::string& words) {
    const bool old = model_.schema() == Schema::ifc2x3;
    std::vector<std::string> rest{step::null, step::text(id)};
    if (!old) rest.push_back(words.empty() ? step::null : step::text(words));
    rest.insert(rest.end(), {step::text(status), step::null, step::boolean(false), step::null});
    if (!old) rest.insert(rest.end(), {step::null, step::enumeration("INSTALLATION")});
    return appender_.add_root("IFCTASK", key(what), name, old ? words.substr(0, 255) : "", rest);
  }

  void write_summary(const std::vector<std::string>& tasks) {
    const auto panels = std::count_if(state_.items.begin(), state_.items.end(),
                                      [](const auto& item) { return item->kind == "panel" && !item->gone; });
    const auto verified = std::count_if(state_.items.begin(), state_.items.end(), [](const auto& item) {
      return item->kind == "panel" && item->status == ItemStatus::verified && !item->gone;
    });
    const InstanceId whole = add_task("whole", "Installation" + (options_.epoch.empty() ? "" : " " + options_.epoch),
                                      "installation", state_.done ? "WAITS FOR A PERSON OR DONE" : "UNDER WAY",
                                      std::to_string(verified) + " of " + std::to_string(panels) +
                                          " panels hang and are verified after round " + std::to_string(state_.round));
    appender_.add_root("IFCRELNESTS", key("whole"), "", "", {reference(whole), step::list(tasks)});
    if (model_.schema() != Schema::ifc2x3)
      appender_.add_root("IFCRELDECLARES", key("whole"), "", "",
                         {reference(model_.all("IFCPROJECT").at(0).id()), step::list({reference(whole)})});
  }

  void write_sequence() {
    for (const auto& panel : plan_.panels) {
      const auto after = tasks_.find({"panel", panel->id});
      if (after == tasks_.end()) continue;
      for (const std::string& id : panel->brackets) write_before({"bracket", id}, after->first, after->second);
      for (const std::string& id : panel->depends_on) write_before({"panel", id}, after->first, after->second);
    }
  }

  using ItemKey = std::pair<std::string, std::string>;
  void write_before(const ItemKey& first, const ItemKey& second, InstanceId second_task) {
    const auto task = tasks_.find(first);
    if (task == tasks_.end() || task->second == second_task) return;
    std::vector<std::string> rest{reference(task->second), reference(second_task)};
    const std::string order = step::enumeration("FINISH_START");
    if (model_.schema() == Schema::ifc2x3)
      rest.insert(rest.end(), {step::real(0), order});
    else
      rest.insert(rest.end(), {step::null, order, step::null});
    appender_.add_root("IFCRELSEQUENCE", key(first.first + "/" + first.second + "/" + second.second), "", "", rest);
  }

  Model model_;
  const Design& design_;
  const InstallationPlanT& plan_;
  const LoopStateT& state_;
  const InstallationIfcOptions& options_;
  Appender appender_;
  AsBuiltIfc result_;
  InstanceId states_ = 0, gates_ = 0;
  std::map<std::string, InstanceId> elements_;  ///< by GlobalId
  std::map<std::string, const BracketSettingT*> brackets_;
  std::map<std::string, const PlannedPanelT*> panels_;
  std::map<ItemKey, InstanceId> tasks_;
  std::vector<std::string> missing_;
};

}  // namespace

AsBuiltIfc write_installation(const step::File& file, const Design& design, const InstallationPlanT& plan,
                              const LoopStateT& state, const InstallationIfcOptions& options) {
  if (design.project_guid.empty())
    throw std::runtime_error(file.name() + ": found no IfcProject, expected one: the state needs its GlobalId");
  return InstallationWriter(file, design, plan, state, options).write();
}

}  // namespace plumbline::ifc
