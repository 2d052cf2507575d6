#include "loop/state/state_file.hpp"

#include <cmath>
#include <map>
#include <nlohmann/json.hpp>
#include <stdexcept>

#include "loop/fit/facade.hpp"
#include "loop/state/control_change.hpp"
#include "loop/state/hash.hpp"
#include "loop/state/journal.hpp"
#include "loop/state/machine.hpp"

namespace plumbline::loop {

using Json = nlohmann::ordered_json;

namespace {

/// Of version 2 control and readings are not known; of version 3 not on which control single items rest; of version 4
/// not where panels were measured themselves; of version 5 not which reports were refused; of version 6 not what sills
/// hold; of version 7 not what left the design.
constexpr int kVersion = 9, kOldest = 2;

Json json_of(const AnchorEstimateT& estimate) {
  return {{"ids", estimate.ids},
          {"floors", estimate.floors},
          {"places", estimate.places},
          {"own", estimate.own},
          {"campaigns", estimate.campaigns}};
}

std::unique_ptr<AnchorEstimateT> estimate_of(const Json& json) {
  auto out = std::make_unique<AnchorEstimateT>();
  json.at("ids").get_to(out->ids), json.at("floors").get_to(out->floors), json.at("places").get_to(out->places);
  json.at("own").get_to(out->own), json.at("campaigns").get_to(out->campaigns);
  return out;
}

Json numbers_or_null(const Eigen::Vector3d& v) {
  Json list = Json::array();
  for (const double value : {v.x(), v.y(), v.z()}) list.push_back(std::isfinite(value) ? Json(value) : Json());
  return list;
}

Eigen::Vector3d numbers_of(const Json& list) {
  if (!list.is_array() || list.size() != 3) throw std::runtime_error("a place or setting has not three numbers");
  Eigen::Vector3d v;
  for (std::size_t k = 0; k < 3; ++k)
    v[static_cast<Eigen::Index>(k)] = list[k].is_null() ? kUnknown : list[k].get<double>();
  return v;
}

Json json_of(const ControlMarks& marks) {
  Json list = Json::array();
  for (const auto& mark : marks)
    list.push_back({{"id", mark->id}, {"place", numbers_or_null(mark->place)}, {"missing", mark->missing}});
  return list;
}

ControlMarks marks_of(const Json& list) {
  ControlMarks marks;
  for (const Json& mark : list) {
    auto out = std::make_unique<ControlMarkT>();
    mark.at("id").get_to(out->id), out->place = numbers_of(mark.at("place")), mark.at("missing").get_to(out->missing);
    marks.push_back(std::move(out));
  }
  return marks;
}

Json json_of(const LoopItemT& item) {
  return {{"id", item.id},
          {"kind", item.kind},
          {"guid", item.guid},
          {"floor", item.floor},
          {"status", name_of(item.status)},
          {"revision", item.revision},
          {"reworks", item.reworks},
          {"setting", numbers_or_null(item.setting)},
          {"pending", numbers_or_null(item.pending)},
          {"expected", numbers_or_null(item.expected)},
          {"by", item.by},
          {"at", item.at},
          {"why", item.why},
          {"hangs", item.hangs},
          {"seen", item.seen},
          {"basis", item.basis},
          {"jobs", item.jobs},
          {"unset", item.unset},
          {"waited", item.waited},
          {"control", item.control},
          {"place", item.place},
          {"holds", item.holds},
          {"gone", item.gone},
          {"reason", EnumNameItemReason(item.reason)},
          {"told_from", std::isnan(item.told_from) ? Json() : Json(item.told_from)}};
}

ItemStatus status_of(const std::string& name) {
  for (int i = 0; i <= static_cast<int>(ItemStatus::stale); ++i)
    if (name == name_of(static_cast<ItemStatus>(i))) return static_cast<ItemStatus>(i);
  throw std::runtime_error("'" + name + "' is no state of an item");
}

ItemReason reason_of(const Json& item) {
  const std::string name = item.value("reason", "other");
  for (const ItemReason reason : EnumValuesItemReason())
    if (name == EnumNameItemReason(reason)) return reason;
  throw std::runtime_error("'" + name + "' is no reason of an item");
}

std::unique_ptr<LoopItemT> item_of(const Json& json) {
  auto item = std::make_unique<LoopItemT>();
  json.at("id").get_to(item->id), json.at("kind").get_to(item->kind), json.at("guid").get_to(item->guid);
  json.at("floor").get_to(item->floor), json.at("revision").get_to(item->revision);
  json.at("reworks").get_to(item->reworks), item->status = status_of(json.at("status").get<std::string>());
  item->setting = numbers_of(json.at("setting")), item->pending = numbers_of(json.at("pending"));
  item->expected = numbers_of(json.at("expected"));
  json.at("by").get_to(item->by), json.at("at").get_to(item->at), json.at("why").get_to(item->why);
  json.at("hangs").get_to(item->hangs), json.at("seen").get_to(item->seen);
  json.at("basis").get_to(item->basis), json.at("jobs").get_to(item->jobs);
  if (json.contains("unset")) json.at("unset").get_to(item->unset), json.at("waited").get_to(item->waited);
  item->control = json.value("control", 0);
  item->place = json.value("place", std::vector<double>());
  item->holds = json.value("holds", std::vector<std::string>());
  item->gone = json.value("gone", false);
  item->reason = reason_of(json);
  if (!json.contains("reason") && item->kind == "bracket" && item->status == ItemStatus::planned)
    item->why.clear();  // of a version without: the next round says it anew
  if (json.contains("told_from") && !json.at("told_from").is_null()) json.at("told_from").get_to(item->told_from);
  if (item->unset.size() != 0 && item->unset.size() != 3)
    throw std::runtime_error("where " + item->id + " stands unset has not three numbers");
  if (item->place.size() != 0 && item->place.size() != 6)
    throw std::runtime_error("where " + item->id + " was measured has not six numbers");
  return item;
}

std::string dumped(const Json& json) { return json.dump(1, ' ', false, Json::error_handler_t::replace); }

/// Each item stands where the journal's last line about it put it; PLANNED if there is none.
void check_items(const LoopStateT& state) {
  if (const JournalFault fault = check_journal(state.journal); fault.line > 0)
    throw std::runtime_error("line " + std::to_string(fault.line) + " of its journal " + fault.words);
  std::map<std::pair<std::string, std::string>, std::string> last;
  for (const std::string& text : state.journal) {
    const Json line = Json::parse(text);
    last[{line.at("kind").get<std::string>(), line.at("item").get<std::string>()}] = line.at("to").get<std::string>();
  }
  for (const auto& item : state.items) {
    const auto found = last.find({item->kind, item->id});
    const std::string by_journal = found == last.end() ? name_of(ItemStatus::planned) : found->second;
    if (by_journal != name_of(item->status))
      throw std::runtime_error(item->kind + " " + item->id + " is " + name_of(item->status) +
                               ", by the journal it is " + by_journal);
  }
}

}  // namespace

std::string state_json(const LoopStateT& state) {
  Json out{{"plumbline_loop_state", kVersion},
           {"revision", state.revision},
           {"round", state.round},
           {"basis", state.basis},
           {"moved_control", state.moved_control},
           {"verified", state.verified},
           {"given_up", state.given_up},
           {"done", state.done},
           {"to_plan", state.to_plan},
           {"to_measure", state.to_measure},
           {"doubts", state.doubts},
           {"next", state.next},
           {"items", Json::array()},
           {"journal", state.journal}};
  for (const auto& item : state.items) out["items"].push_back(json_of(*item));
  out["control"] = json_of(state.control), out["readings"] = state.readings;
  out["controls"] = Json::array();
  for (const auto& set : state.controls) out["controls"].push_back(json_of(set->marks));
  out["refused"] = Json::array();
  for (const auto& refused : state.refused)
    out["refused"].push_back({{"round", refused->round}, {"report", refused->report}, {"why", refused->why}});
  if (state.estimate) out["estimate"] = json_of(*state.estimate);
  // As it is read back: what is no UTF-8 was replaced on the way.
  out = Json::parse(dumped(out));
  const std::string seal = sha256_hex(dumped(out));
  out["seal"] = seal;
  return dumped(out) + "\n";
}

namespace {

/// Control and readings of the campaigns. Of a file that does not say which control an item rests on, it is the last.
void take_what_it_rests_on(const Json& json, LoopStateT& state) {
  json.at("readings").get_to(state.readings);
  state.control = marks_of(json.at("control"));
  if (!json.contains("controls")) {
    for (const auto& item : state.items) item->control = 0;
    return note_control(state);
  }
  for (const Json& marks : json.at("controls")) {
    state.controls.push_back(std::make_unique<ControlSetT>());
    state.controls.back()->marks = marks_of(marks);
  }
  for (const auto& item : state.items)
    if (item->control < 0 || static_cast<std::size_t>(item->control) > state.controls.size())
      throw std::runtime_error(item->kind + " " + item->id + " rests on control " + std::to_string(item->control) +
                               " of " + std::to_string(state.controls.size()));
}

}  // namespace

LoopStateT read_state_json(const std::string& text, const std::string& source) {
  try {
    Json json = Json::parse(text);
    if (!json.is_object() || !json.contains("plumbline_loop_state"))
      throw std::runtime_error("is no state of a loop: expected state.json as a round of site_loop wrote it");
    const Json& stated = json["plumbline_loop_state"];
    const int version = stated.is_number_integer() ? stated.get<int>() : 0;
    if (version < kOldest || version > kVersion)
      throw std::runtime_error("is a state of version " + stated.dump() + ", expected " + std::to_string(kVersion));
    const std::string seal = json.value("seal", "");
    json.erase("seal");
    if (seal != sha256_hex(dumped(json)))
      throw std::runtime_error(
          "was changed since it was written, or is only a part of it: take the file of that round again");
    LoopStateT state;
    json.at("revision").get_to(state.revision), json.at("round").get_to(state.round);
    json.at("basis").get_to(state.basis), json.at("moved_control").get_to(state.moved_control);
    json.at("verified").get_to(state.verified), json.at("given_up").get_to(state.given_up);
    json.at("done").get_to(state.done), json.at("to_plan").get_to(state.to_plan);
    json.at("next").get_to(state.next);
    json.at("to_measure").get_to(state.to_measure), json.at("doubts").get_to(state.doubts);
    if (json.contains("estimate")) state.estimate = estimate_of(json["estimate"]);
    json.at("journal").get_to(state.journal);
    for (const Json& item : json.at("items")) state.items.push_back(item_of(item));
    for (const Json& refused : json.value("refused", Json::array())) {
      auto out = std::make_unique<RefusedReportT>();
      refused.at("round").get_to(out->round), refused.at("report").get_to(out->report);
      refused.at("why").get_to(out->why);
      state.refused.push_back(std::move(out));
    }
    if (version != kOldest) take_what_it_rests_on(json, state);
    check_items(state);
    return state;
  } catch (const nlohmann::json::exception& error) {
    throw std::runtime_error(source + ": is no state of a loop, or a torn one: " +
                             std::string(error.what()).substr(std::string(error.what()).find("] ") + 1));
  } catch (const std::runtime_error& error) {
    throw std::runtime_error(source + ": " + error.what());
  }
}

}  // namespace plumbline::loop
