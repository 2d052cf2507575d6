#include "loop/exchange/order_exchange.hpp"

#include <fmt/core.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <nlohmann/json.hpp>
#include <set>

#include "loop/job/job.hpp"
#include "loop/state/date.hpp"

namespace plumbline::loop {

using nlohmann::ordered_json;

const char* name_of(ExchangeStatus status) {
  static constexpr const char* kNames[] = {"ASKING", "BUSY", "SENT", "ACCEPTED", "FINISHED", "REJECTED", "UNKNOWN"};
  return kNames[static_cast<size_t>(status)];
}

namespace {

bool is_final(const std::string& status) { return status == "FINISHED" || status == "FAILED"; }

/// What of a state message this exchange looks at.
struct RobotState {
  std::string order;
  std::map<std::string, std::string> refusals;  ///< why, by the order that its errors refuse
  double seconds = 0;
  long long header = 0;
  std::map<std::string, std::string> actions;  ///< status by actionId
  bool drives = false;                         ///< its order has nodes or edges before it
  std::string digest;                          ///< of what is worth a line on disk
  std::optional<VdaPlace> place;               ///< where the robot stands, if it says so
};

/// The order that an error refuses, by its references; empty: none.
std::string order_of_error(const ordered_json& error) {
  if (!error.contains("errorReferences") || !error["errorReferences"].is_array()) return {};
  for (const auto& reference : error["errorReferences"])
    if (reference.value("referenceKey", "") == "orderId") return reference.value("referenceValue", "");
  return {};
}

/// In 2.x agvPosition, in 3.0 mobileRobotPosition.
std::optional<VdaPlace> place_of_robot(const ordered_json& json) {
  for (const char* key : {"agvPosition", "mobileRobotPosition"})
    if (json.contains(key) && json[key].is_object() && json[key].contains("x") && json[key].contains("mapId"))
      return VdaPlace{json.value("lastNodeId", ""), json[key].value("mapId", ""), json[key].value("x", 0.0),
                      json[key].value("y", 0.0), json[key].value("theta", 0.0)};
  return std::nullopt;
}

/// Throws nlohmann::json::exception for what is no state message.
RobotState read_robot_state(const ordered_json& json) {
  RobotState state;
  json.at("orderId").get_to(state.order), json.at("headerId").get_to(state.header);
  state.seconds = seconds_of(json.at("timestamp").get<std::string>()).value_or(std::nan(""));
  for (const auto& action : json.at("actionStates"))
    state.actions[action.at("actionId").get<std::string>()] = action.at("actionStatus").get<std::string>();
  for (const char* key : {"nodeStates", "edgeStates"})
    state.drives = state.drives || (json.contains(key) && json[key].is_array() && !json[key].empty());
  const ordered_json errors = json.value("errors", ordered_json::array());
  for (const auto& error : errors)
    if (const std::string refused = order_of_error(error); !refused.empty() && refused != state.order)
      state.refusals[refused] += (state.refusals.count(refused) > 0 ? "; " : "") + error.value("errorType", "") + ": " +
                                 error.value("errorDescription", "");
  state.place = place_of_robot(json);
  state.digest = ordered_json{state.order, json["actionStates"], errors}.dump(-1, ' ', false,
                                                                              ordered_json::error_handler_t::replace);
  return state;
}

/// Whether an order is at its end: nothing before the robot, every action final.
bool is_at_its_end(const RobotState& state) {
  return !state.drives && std::all_of(state.actions.begin(), state.actions.end(),
                                      [](const auto& action) { return is_final(action.second); });
}

}  // namespace

OrderExchange::OrderExchange(const Job& job, const VdaRobot& robot, ExchangeLog& log, const ExchangeTimes& times)
    : job_(job), robot_(robot), log_(log), times_(times) {
  robot_.timestamp = "2000-01-01T00:00:00Z";
  vda_order(job_, robot_);  // what is wrong with the job is said before anything is sent
  restore_sent();
  for (const std::string& line : log_.states()) take(line, Heard::on_disk, 0);
  // What is on disk was heard by a program before this one; the robot is asked anew.
  answered_ = false;
  refuse_old_revision();
  if (status_ == ExchangeStatus::asking && sent_at_ < 0) refuse_items_of_others(false);
}

/// Nobody does what another robot was asked for. With `take` they are this robot's from now on.
void OrderExchange::refuse_items_of_others(bool take) {
  const std::string why = log_.held_by_others(job_, robot_.manufacturer + "/" + robot_.serial, take);
  if (why.empty()) return;
  status_ = sent_at_ < 0 ? ExchangeStatus::rejected : ExchangeStatus::unknown;
  reason_ = why;
}

/// A robot that did a later plan's work would do it backwards.
void OrderExchange::refuse_old_revision() {
  if (is_over() || status_ == ExchangeStatus::accepted || job_.revision >= newest_revision_) return;
  status_ = sent_at_ < 0 ? ExchangeStatus::rejected : ExchangeStatus::unknown;
  reason_ = job_objections(job_, newest_revision_, "", job_.basis).front() +
            (sent_at_ < 0 ? "; this folder has sent that one to the robot, and does not send this one (a loop that was "
                            "begun anew has a folder of its own)"
                          : "; it is not sent again: measure the items");
}

void OrderExchange::restore_sent() {
  for (const std::string& line : log_.sent()) {
    const auto sent = ordered_json::parse(line, nullptr, false);
    if (!sent.is_object()) continue;
    order_number_ = std::max(order_number_, sent.value("headerId", 0));
    const double at = sent.value("at", 0.0);
    if (sent.value("orderId", "") == vda_order_id(job_)) {
      // What the robot said before is late if it comes now.
      sent_at_ = at, header_at_sending_ = newest_header_ = sent.value("robotHeaderId", -1LL);
      newest_ = std::max(newest_, sent.value("robotSeconds", -1e300));
    }
    if (sent.value("orderId", "") == vda_order_id(job_)) continue;
    newest_revision_ = std::max(newest_revision_, sent.value("revision", 0));
    other_order_ = sent.value("orderId", ""), other_sent_at_ = std::max(other_sent_at_, at);
  }
}

void OrderExchange::on_state(const std::string& payload, double now, bool is_kept) {
  take(payload, is_kept ? Heard::kept : Heard::now, now);
}

bool OrderExchange::goes_on_by_number(double seconds, long long header, double now) {
  constexpr int kEnough = 3;  // a single late one tells of a start before
  if (newest_header_ < 0 || header <= std::max(newest_header_, behind_header_) || seconds <= behind_seconds_)
    return false;
  behind_seconds_ = seconds, behind_header_ = header, ++behind_;
  return behind_ >= kEnough && now - heard_at_ > times_.silence;
}

std::string OrderExchange::clock_doubt() const {
  if (behind_ < 2) return {};
  return fmt::format(
      "the robot's states are dated up to {:.0f} min before the last one that it sent, and their numbers go on: was "
      "its "
      "clock put back? They are taken by their numbers when nothing newer came for a while",
      std::ceil((newest_ - behind_seconds_) / 60));
}

void OrderExchange::take_progress(const std::map<std::string, std::string>& actions, bool is_at_its_end) {
  status_ = ExchangeStatus::accepted;
  std::map<std::string, int> counts;
  std::set<std::string> known;
  failed_.clear();
  for (const auto& [id, status] : actions) ++counts[status], known.insert(id);
  for (const JobItem& item : job_.items)
    if (const auto action = actions.find(vda_action_id(job_, item));
        action != actions.end() && action->second == "FAILED")
      failed_.push_back(item.id);
  progress_.clear();
  for (const auto& [status, n] : counts)
    progress_ += (progress_.empty() ? "" : ", ") + std::to_string(n) + " " + status;
  const bool all = std::all_of(job_.items.begin(), job_.items.end(),
                               [&](const JobItem& item) { return known.count(vda_action_id(job_, item)) > 0; });
  if (all && is_at_its_end) status_ = ExchangeStatus::finished;
}

void OrderExchange::lose_order() {
  reason_ =
      status_ == ExchangeStatus::accepted
          ? "the robot had the order and has it no more, without having told its end: measure the items, nothing "
            "is sent again"
          : "the robot was started again, or took another order, since the order was sent to it: it may have done "
            "it and forgotten; measure the items, nothing is sent again";
  status_ = ExchangeStatus::unknown;
}

void OrderExchange::take(const std::string& payload, Heard heard, double now) {
  const bool is_new = heard != Heard::on_disk;
  const auto json = ordered_json::parse(payload, nullptr, false);
  RobotState state;
  try {
    if (!json.is_object() || json.at("manufacturer") != robot_.manufacturer || json.at("serialNumber") != robot_.serial)
      return;
    state = read_robot_state(json);
  } catch (const nlohmann::json::exception&) {
    return;
  }
  if (!std::isfinite(state.seconds)) return;
  const bool is_newest = state.seconds > newest_ || (state.seconds == newest_ && state.header > newest_header_) ||
                         (heard == Heard::now && goes_on_by_number(state.seconds, state.header, now));
  // Late ones tell nothing about now, but may tell that an action came to its end.
  const bool ours = state.order == vda_order_id(job_);
  if (is_new && (ours || state.refusals.count(vda_order_id(job_)) > 0) && state.digest != last_actions_) {
    log_.append_state(json.dump(-1, ' ', false, ordered_json::error_handler_t::replace));
    last_actions_ = state.digest;
  }
  if (!is_new && ours) last_actions_ = state.digest;
  // Started again: a later message with a smaller number.
  const bool was_started_again = is_newest && newest_header_ >= 0 && state.header < newest_header_;
  if (is_newest) {
    newest_ = state.seconds, newest_header_ = state.header, robot_.start = state.place;
    behind_ = 0, behind_header_ = -1, behind_seconds_ = -1e300;
    if (heard != Heard::kept) heard_at_ = now;
  }
  if (is_over()) return;
  // What a broker has kept, or held back, was said before the question.
  if (is_newest) answered_ = heard == Heard::now && asked_;
  if (ours && is_new && !is_noted_) {
    log_.note_given(job_, robot_.manufacturer + "/" + robot_.serial);
    is_noted_ = true;
  }
  if (ours && (is_newest || is_at_its_end(state))) {
    take_progress(state.actions, is_at_its_end(state));
    return;
  }
  if (!is_newest) return;
  if (const auto refusal = state.refusals.find(vda_order_id(job_)); refusal != state.refusals.end()) {
    status_ = ExchangeStatus::rejected, reason_ = "the robot refuses the order: " + refusal->second;
    return;
  }
  const bool was_sent = sent_at_ >= 0;
  if (was_sent && (status_ == ExchangeStatus::accepted || was_started_again ||
                   (header_at_sending_ >= 0 && state.header < header_at_sending_))) {
    lose_order();
    return;
  }
  status_ = is_at_its_end(state) || state.order.empty() ? ExchangeStatus::asking : ExchangeStatus::busy;
}

MqttMessage OrderExchange::question(const std::string& utc) {
  ordered_json out;
  out["headerId"] = ++question_number_, out["timestamp"] = utc;
  out["version"] = robot_.version == VdaVersion::v2_0 ? "2.0.0" : "3.0.0";
  out["manufacturer"] = robot_.manufacturer, out["serialNumber"] = robot_.serial;
  ordered_json action{{"actionId", vda_order_id(job_) + ":state:" + utc + ":" + std::to_string(question_number_)},
                      {"actionType", "stateRequest"},
                      {"blockingType", "NONE"}};
  // The text of 2.0 says actionType, its schema for instant actions actionName.
  if (robot_.version == VdaVersion::v2_0) action["actionName"] = "stateRequest";
  out["actions"] = ordered_json::array({action});
  return {vda_topic(robot_, "instantActions"), out.dump(), times_.expiry};
}

MqttMessage OrderExchange::order(double now, const std::string& utc) {
  robot_.timestamp = utc, robot_.header_id = ++order_number_;
  const MqttMessage message{vda_topic(robot_, "order"), vda_order(job_, robot_), times_.expiry};
  // On disk first: if nothing comes after this line, the order may be out and may not.
  log_.append_sent(ordered_json{
      {"orderId", vda_order_id(job_)},
      {"revision", job_.revision},
      {"headerId", order_number_},
      {"at", now},
      {"utc", utc},
      {"robotHeaderId", newest_header_},
      {"robotSeconds",
       newest_}}.dump());
  sent_at_ = now, header_at_sending_ = newest_header_, answered_ = asked_ = false;
  status_ = ExchangeStatus::sent;
  return message;
}

std::vector<MqttMessage> OrderExchange::due(double now, const std::string& utc) {
  if (is_over()) return {};
  const auto ask = [&]() -> std::vector<MqttMessage> {
    if (asked_ && now - asked_at_ < times_.answer) return {};
    asked_ = true, asked_at_ = now;
    return {question(utc)};
  };
  if (status_ == ExchangeStatus::accepted)
    return now - heard_at_ > times_.silence || !answered_ ? ask() : std::vector<MqttMessage>{};
  if (!answered_ || status_ == ExchangeStatus::busy) return ask();
  // The robot has answered that it does not have the order.
  if (sent_at_ >= 0 && now - sent_at_ < times_.answer) return {};
  if (!other_order_.empty() && now - other_sent_at_ < times_.expiry) return {};
  // It was valid when this began: the robot may have been busy for hours.
  if (const auto objections = job_objections(job_, 0, utc, job_.basis);
      !job_.valid_until.empty() && !objections.empty()) {
    status_ = sent_at_ < 0 ? ExchangeStatus::rejected : ExchangeStatus::unknown;
    reason_ = objections[0] +
              (sent_at_ < 0 ? ": it was not sent; make a new one" : ": it is not sent again; measure the items");
    return {};
  }
  refuse_items_of_others(true);
  if (is_over()) return {};
  return {order(now, utc)};
}

}  // namespace plumbline::loop
