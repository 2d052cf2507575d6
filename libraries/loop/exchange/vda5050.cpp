#include "loop/exchange/vda5050.hpp"

#include <algorithm>
#include <cmath>
#include <map>
#include <nlohmann/json.hpp>
#include <optional>
#include <regex>
#include <set>
#include <sstream>
#include <stdexcept>
#include <tuple>

#include "loop/fit/facade.hpp"
#include "loop/job/unknown_keys.hpp"
#include "loop/state/date.hpp"

namespace plumbline::loop {

using nlohmann::ordered_json;

namespace {

/// Items whose places to stand are nearer than this to that of the first of a node, and which face as it does, are
/// done from there [m].
constexpr double kReachOfNode = 0.5;

ordered_json vda_numbers(const Eigen::Vector3d& v) { return {v.x(), v.y(), v.z()}; }
ordered_json vda_numbers(const Eigen::Quaterniond& q) { return {q.x(), q.y(), q.z(), q.w()}; }

void check_name(const char* what, const std::string& name) {
  if (name.empty() || name.find_first_of("/+#$ ") != std::string::npos)
    throw std::runtime_error(std::string(what) + " is '" + name +
                             "'; expected the robot's own, without /, +, #, $ and spaces: it is part of a topic");
}

void check_robot(const VdaRobot& robot) {
  check_name("manufacturer", robot.manufacturer), check_name("serial number", robot.serial);
  if (!seconds_of(robot.timestamp) || robot.timestamp.back() != 'Z')
    throw std::runtime_error("the timestamp is '" + robot.timestamp +
                             "'; expected ISO 8601 in UTC, such as 2026-05-02T08:00:00Z");
}

ordered_json action_of(const Job& job, const JobItem& item, VdaVersion version) {
  ordered_json action;
  action["actionId"] = vda_action_id(job, item), action["actionType"] = item.operation;
  action[version == VdaVersion::v2_0 ? "actionDescription" : "actionDescriptor"] =
      item.operation + " " + item.id + ": " + item.reason;
  action["blockingType"] = "HARD";  // neither driving nor anything else meanwhile
  action["actionParameters"] = ordered_json::array();
  const auto add = [&](const char* key, const ordered_json& value) {
    action["actionParameters"].push_back({{"key", key}, {"value", value}});
  };
  add("jobId", job.id), add("item", item.id), add("revision", item.revision), add("frame", job.frame);
  add("designPosition", vda_numbers(Eigen::Vector3d(item.design + job.origin)));
  add("designOrientation", vda_numbers(item.design_rotation));
  add("targetPosition", vda_numbers(Eigen::Vector3d(item.target + job.origin)));
  add("targetOrientation", vda_numbers(item.target_rotation));
  if (item.kind == "bracket") add("setting", vda_numbers(item.setting));
  add("tolerance", vda_numbers(item.tolerance)), add("dependsOn", item.depends_on), add("gate", "GO");
  return action;
}

/// From where an item is done: before it, and never in it.
struct Stand {
  Eigen::Vector2d place = Eigen::Vector2d::Zero();  ///< [m] in the root frame, less its origin
  std::optional<double> theta;                      ///< towards the item [rad]; none: it faces up or down
};

Stand stand_before(const JobItem& item, double stand_off) {
  const Eigen::Vector2d out = (item.design_rotation * Eigen::Vector3d::UnitZ()).head<2>();
  if (out.norm() < 0.5 || stand_off == 0) return {item.design.head<2>(), std::nullopt};
  const Eigen::Vector2d away = stand_off * out.normalized();
  return {item.design.head<2>() + away, std::atan2(-away.y(), -away.x())};
}

/// Whether a robot that stands at `node` does what it would do from `other`, as it faces: at an inner corner the stands
/// of both facades are one place.
bool is_done_from(const Stand& node, const Stand& other) {
  constexpr double kSameWay = 0.3;  // [rad]
  if ((other.place - node.place).norm() > kReachOfNode || other.theta.has_value() != node.theta.has_value())
    return false;
  return !node.theta || std::abs(std::remainder(*other.theta - *node.theta, 2 * M_PI)) <= kSameWay;
}

ordered_json node_of(const Job& job, const JobItem& item, double stand_off, std::size_t sequence) {
  ordered_json node;
  node["nodeId"] = "floor-" + std::to_string(item.floor) + "-" + item.id, node["sequenceId"] = sequence;
  node["released"] = true;
  const Stand stand = stand_before(item, stand_off);
  node["nodePosition"] = {{"x", stand.place.x() + job.origin.x()}, {"y", stand.place.y() + job.origin.y()}};
  if (stand.theta) node["nodePosition"]["theta"] = *stand.theta;
  node["nodePosition"]["mapId"] = "floor-" + std::to_string(item.floor);
  node["actions"] = ordered_json::array();
  return node;
}

ordered_json start_node(const VdaPlace& start) {
  ordered_json node;
  node["nodeId"] = start.node.empty() ? "start" : start.node, node["sequenceId"] = 0, node["released"] = true;
  node["nodePosition"] = {{"x", start.x}, {"y", start.y}, {"theta", start.theta}, {"mapId", start.map}};
  node["actions"] = ordered_json::array();
  return node;
}

ordered_json edge_between(const ordered_json& a, const ordered_json& b, std::size_t sequence, VdaVersion version) {
  ordered_json edge;
  edge["edgeId"] = "edge-" + std::to_string(sequence), edge["sequenceId"] = sequence, edge["released"] = true;
  if (version == VdaVersion::v2_0) edge["startNodeId"] = a["nodeId"], edge["endNodeId"] = b["nodeId"];
  edge["actions"] = ordered_json::array();
  return edge;
}

}  // namespace

std::string vda_action_id(const Job& job, const JobItem& item) {
  return job.id + ":" + item.id + ":" + std::to_string(item.revision);
}

std::string vda_order_id(const Job& job) { return job.id + job.part; }

std::string vda_topic(const VdaRobot& robot, const std::string& subtopic) {
  return std::string("uagv/") + (robot.version == VdaVersion::v2_0 ? "v2/" : "v3/") + robot.manufacturer + "/" +
         robot.serial + "/" + subtopic;
}

std::string vda_order(const Job& job, const VdaRobot& robot) {
  check_robot(robot);
  if (job.items.empty()) throw std::runtime_error("job " + job.id + " has no items: there is nothing to order");
  ordered_json out;
  out["headerId"] = robot.header_id, out["timestamp"] = robot.timestamp;
  out["version"] = robot.version == VdaVersion::v2_0 ? "2.0.0" : "3.0.0";
  out["manufacturer"] = robot.manufacturer, out["serialNumber"] = robot.serial;
  out["orderId"] = vda_order_id(job), out["orderUpdateId"] = 0;
  ordered_json nodes = ordered_json::array(), edges = ordered_json::array();
  const JobItem* first = nullptr;
  if (robot.start && node_of(job, job.items.front(), robot.stand_off, 0)["nodeId"] != robot.start->node)
    nodes.push_back(start_node(*robot.start));
  for (const JobItem& item : job.items) {
    const bool here = first && first->floor == item.floor &&
                      is_done_from(stand_before(*first, robot.stand_off), stand_before(item, robot.stand_off));
    if (!here) {
      nodes.push_back(node_of(job, item, robot.stand_off, 2 * nodes.size())), first = &item;
      if (const std::size_t n = nodes.size(); n > 1)
        edges.push_back(edge_between(nodes[n - 2], nodes[n - 1], 2 * n - 3, robot.version));
    }
    nodes.back()["actions"].push_back(action_of(job, item, robot.version));
  }
  out["nodes"] = std::move(nodes), out["edges"] = std::move(edges);
  return out.dump(1, ' ', false, ordered_json::error_handler_t::replace) + "\n";
}

namespace {

/// A final state of an action, with when it was said.
struct Said {
  double seconds = 0;
  long long header_id = 0;
  std::size_t line = 0;
  std::string action, status, result, at, by;
};

class StateReader {
 public:
  StateReader(const Job& job, const std::string& source, const SurveyLink& survey)
      : job_(job), source_(source), survey_(survey) {
    if (job.frame == "survey" && !survey)
      throw std::runtime_error(source + ": answers job " + job.id +
                               ", which is in the frame of the survey, and this round takes survey and design for one "
                               "frame; expected what the round of that job said (frames.with.use)");
    out_.sources.push_back(source);
    for (const JobItem& item : job.items) item_of_[vda_action_id(job, item)] = &item;
  }

  void read(const std::string& text, std::size_t line) {
    try {
      read_state(ordered_json::parse(text), line);
    } catch (const nlohmann::json::exception& error) {
      refuse(line, std::string("is no state message: ") + error.what());
    }
  }

  ActualsT take() {
    // As they were said, whatever the order they came in.
    std::stable_sort(said_.begin(), said_.end(), [](const Said& a, const Said& b) {
      return std::tie(a.seconds, a.header_id) < std::tie(b.seconds, b.header_id);
    });
    std::map<std::string, const Said*> known;
    std::set<std::pair<std::string, std::string>> named;  // of others than the first: by action
    for (const Said& said : said_) {
      const auto [before, is_new] = known.try_emplace(said.action, &said);
      if (is_new)
        add(said);
      else if (before->second->status != said.status)
        refuse(said.line, "says that action " + said.action + " " + said.status + ", a message before said " +
                              before->second->status + ": a state that is final does not change; look at the item");
      else if (before->second->by != said.by && named.emplace(said.action, said.by).second)
        refuse(said.line, "says that action " + said.action + " " + said.status + " by " + said.by +
                              ", and it was by " + before->second->by +
                              ": two robots had one item; measure it, it may have been done twice");
    }
    if (const std::string words = words_of_ignored(ignored_); !words.empty())
      out_.ignored.push_back(source_ + ": in results of actions " + words);
    return std::move(out_);
  }

 private:
  void refuse(std::size_t line, const std::string& why) {
    out_.refused.push_back(source_ + ":" + std::to_string(line) + ": " + why);
  }

  void read_state(const ordered_json& state, std::size_t line) {
    const std::string version = state.at("version").get<std::string>(), at = state.at("timestamp").get<std::string>();
    if (version.rfind("2.", 0) != 0 && version.rfind("3.", 0) != 0)
      return refuse(line, "is of version " + version + ", expected 2.x or 3.x");
    const std::optional<double> seconds = seconds_of(at);
    if (!seconds) return refuse(line, "has the timestamp '" + at + "', expected ISO 8601 with a zone");
    const std::string order = state.at("orderId").get<std::string>();
    const ordered_json& actions = state.at("actionStates");
    if (order.empty() && actions.empty()) return;  // a robot that has nothing to do
    if (!is_of_job(order)) return refuse(line, "is on order '" + order + "', this job is " + job_.id);
    const std::string by =
        state.at("manufacturer").get<std::string>() + "/" + state.at("serialNumber").get<std::string>();
    for (const ordered_json& action : actions) {
      const std::string id = action.at("actionId").get<std::string>(),
                        status = action.at("actionStatus").get<std::string>();
      if (!item_of_.count(id)) {
        refuse(line, "tells of action '" + id + "', which this job does not have");
        continue;
      }
      if (status != "FINISHED" && status != "FAILED") continue;
      const char* key = action.contains("actionResult") ? "actionResult" : "resultDescription";
      said_.push_back({*seconds, state.at("headerId").get<long long>(), line, id, status,
                       action.contains(key) ? action.at(key).get<std::string>() : std::string(), at, by});
    }
  }

  /// The order of the whole job, or of some of its floors.
  bool is_of_job(const std::string& order) const {
    static const std::regex floors("(-F[0-9]+)*");
    return order.rfind(job_.id, 0) == 0 && std::regex_match(order.substr(job_.id.size()), floors);
  }

  void add(const Said& said) {
    const JobItem& item = *item_of_.at(said.action);
    auto actual = std::make_unique<ActualT>();
    actual->item = item.id, actual->job = job_.id, actual->revision = item.revision;
    actual->by = said.by, actual->at = said.at, actual->outcome = said.status == "FINISHED" ? "done" : "failed";
    actual->source = source_ + ":" + std::to_string(said.line);
    actual->measured.setConstant(kUnknown), actual->sigma.setConstant(kUnknown), actual->setting.setConstant(kUnknown);
    const auto result = ordered_json::parse(said.result, nullptr, false);
    if (result.is_object()) {
      try {
        refuse_other_units(result, {job_.frame});
        note_unknown_keys(result, {"measured", "sigma", "setting", "note", "units", "unit", "frame"}, ignored_);
      } catch (const std::runtime_error& error) {
        return refuse(said.line, "the result of action " + said.action + ": " + error.what());
      }
      const bool read = read_vector(result, "measured", actual->measured) &&
                        read_vector(result, "sigma", actual->sigma) &&
                        read_vector(in_order(result), "setting", actual->setting);
      if (!read)
        return refuse(said.line, "the result of action " + said.action + " is " + said.result.substr(0, 80) +
                                     ", expected three numbers each for measured, sigma, setting");
      bring_to_building(*actual, job_.frame == "survey" ? survey_ : SurveyLink());
      actual->note = result.contains("note") && result["note"].is_string() ? result["note"].get<std::string>() : "";
    } else {
      actual->note = said.result;
      if (said.result.find_first_not_of(" \t\r\n") != std::string::npos &&
          said.result[said.result.find_first_not_of(" \t\r\n")] == '{')
        out_.ignored.push_back(source_ + ":" + std::to_string(said.line) + ": the result of action " + said.action +
                               " is no JSON, and what it measured is not read: " + said.result.substr(0, 80));
    }
    out_.items.push_back(std::move(actual));
  }

  /// A setting as actuals.json and orders have it, by the names of its directions, as the list that others write.
  static ordered_json in_order(ordered_json result) {
    const auto found = result.find("setting");
    if (found == result.end() || !found->is_object() || found->size() != 3) return result;
    ordered_json list = ordered_json::array();
    for (const char* direction : {"right", "up", "out"})
      list.push_back(found->contains(direction) ? (*found)[direction] : ordered_json());
    result["setting"] = list;
    return result;
  }

  /// True also if there is none.
  static bool read_vector(const ordered_json& object, const char* key, Eigen::Vector3d& into) {
    if (!object.contains(key)) return true;
    const ordered_json& list = object[key];
    if (!list.is_array() || list.size() != 3) return false;
    for (std::size_t k = 0; k < 3; ++k) {
      if (!list[k].is_number() || !std::isfinite(list[k].get<double>())) return false;
      into[static_cast<Eigen::Index>(k)] = list[k].get<double>();
    }
    return true;
  }

  const Job& job_;
  std::string source_;
  const SurveyLink& survey_;
  std::map<std::string, const JobItem*> item_of_;
  std::vector<Said> said_;
  std::map<std::string, int> ignored_;  ///< keys of results
  ActualsT out_;
};

}  // namespace

namespace {

/// Of a line as `mosquitto_sub -v` writes it, "TOPIC MESSAGE", the message of a state; empty of another topic of the
/// standard. Any other line as it is.
std::string state_of_log(const std::string& line) {
  const auto end = line.find_first_of(" \t"), begin = line.find_first_not_of(" \t", end);
  if (line.find('/') >= end || begin == std::string::npos || line[begin] != '{') return line;
  const std::string topic = line.substr(0, end), part = topic.substr(topic.rfind('/') + 1);
  if (part == "state") return line.substr(begin);
  static constexpr const char* kOthers[] = {"connection", "factsheet",     "instantActions", "order",
                                            "responses",  "visualization", "zoneSet"};
  return std::find(std::begin(kOthers), std::end(kOthers), part) != std::end(kOthers) ? "" : line;
}

}  // namespace

ActualsT vda_actuals(const std::string& lines, const Job& job, const std::string& source, const SurveyLink& survey) {
  StateReader reader(job, source, survey);
  // One message over several lines, or one in each line.
  if (ordered_json::parse(lines, nullptr, false).is_object()) {
    reader.read(lines, 1);
    return reader.take();
  }
  std::istringstream stream(lines);
  std::size_t number = 0;
  for (std::string line; std::getline(stream, line);) {
    ++number;
    line = state_of_log(line);
    if (line.find_first_not_of(" \t\r") != std::string::npos) reader.read(line, number);
  }
  return reader.take();
}

}  // namespace plumbline::loop
