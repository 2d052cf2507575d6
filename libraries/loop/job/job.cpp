#include "loop/job/job.hpp"

#include <algorithm>
#include <cmath>
#include <map>
#include <nlohmann/json.hpp>
#include <set>
#include <stdexcept>

#include "loop/fit/facade.hpp"
#include "loop/job/survey_link.hpp"
#include "loop/job/unknown_keys.hpp"
#include "loop/state/hash.hpp"

namespace plumbline::loop {

using nlohmann::ordered_json;

namespace {

ordered_json numbers(const Eigen::Vector3d& v) { return {v.x(), v.y(), v.z()}; }
ordered_json quaternion(const Eigen::Quaterniond& q) { return {q.x(), q.y(), q.z(), q.w()}; }

Eigen::Quaterniond rotation_of(const std::vector<Eigen::Vector3d>& axes) {
  Eigen::Matrix3d m;
  for (int k = 0; k < 3; ++k) m.col(k) = axes[k];
  return Eigen::Quaterniond(m).normalized();
}

/// Right, up and out of a panel as its own corners have them: facades face several ways.
Eigen::Quaterniond rotation_of_face(const PlannedPanelT& panel) {
  const auto& c = panel.corners;
  if (c.size() == 4) {
    const Eigen::Vector3d right = (c[1] - c[0] + c[3] - c[2]).normalized();
    const Eigen::Vector3d along = c[2] - c[0] + c[3] - c[1], out = right.cross(along).normalized();
    if (right.allFinite() && out.allFinite() && out.norm() > 0.5) return rotation_of({right, out.cross(right), out});
  }
  throw std::runtime_error("panel " + panel.id + " has " + std::to_string(c.size()) +
                           " corners that span no face, expected four: which way it faces is not known, so it is no "
                           "job for a robot");
}

JobItem bracket_item(const BracketSettingT& bracket, const LoopItemT& item, const Eigen::Vector3d& origin) {
  JobItem out;
  out.id = item.id, out.kind = "bracket", out.operation = "setBracket", out.guid = bracket.guid;
  out.floor = item.floor, out.revision = item.revision, out.reason = item.why;
  out.design = bracket.design - origin, out.target = item.expected - origin;
  for (int k = 0; k < 3; ++k) out.target += item.pending[k] * bracket.axes[k];
  out.design_rotation = out.target_rotation = rotation_of(bracket.axes);
  out.setting = item.pending, out.tolerance.setConstant(0.001);
  return out;
}

JobItem panel_item(const PlannedPanelT& panel, const LoopItemT& item, const Eigen::Vector3d& origin) {
  if (panel.gate != GateDecision::go)
    throw std::runtime_error("panel " + panel.id + " is released and not GO in this plan (" + panel.reason +
                             "): release with this plan first");
  const Eigen::Quaterniond axes = rotation_of_face(panel);
  JobItem out;
  out.id = item.id, out.kind = "panel", out.operation = "placePanel", out.guid = panel.guid;
  out.floor = item.floor, out.revision = item.revision, out.reason = item.why;
  out.depends_on = panel.depends_on;
  out.depends_on.insert(out.depends_on.end(), panel.brackets.begin(), panel.brackets.end());
  out.design = panel.centre - origin, out.target = panel.centre + panel.shift - origin;
  out.design_rotation = axes;
  const double angle = panel.rotation.norm();
  out.target_rotation = angle > 0 ? Eigen::Quaterniond(Eigen::AngleAxisd(angle, panel.rotation / angle)) * axes : axes;
  out.tolerance.setConstant(0.002), out.p_in = panel.p_in;
  return out;
}

/// A round place near the facade, so that items keep their digits.
Eigen::Vector3d origin_near(const Eigen::Vector3d& place) {
  return place.unaryExpr([](double x) { return std::abs(x) > 1000 ? 1000 * std::floor(x / 1000) : 0.0; });
}

}  // namespace

Job make_job(const InstallationPlanT& plan, const LoopStateT& state, int floor, const std::string& created_at,
             const std::string& valid_until) {
  if (plan.basis != state.basis)
    throw std::runtime_error("the state was made from the plan on " + state.basis.substr(0, 12) + ", this plan is on " +
                             plan.basis.substr(0, 12) + ": release with this plan first");
  Job job;
  job.revision = state.revision, job.basis = plan.basis, job.design_file = plan.design_file;
  job.created_at = created_at, job.valid_until = valid_until;
  if (!plan.brackets.empty()) job.origin = origin_near(plan.brackets.front()->design);
  job.setting_sigma = plan.setting_sigma, job.station_sigma = plan.station_sigma;
  std::map<std::string, const LoopItemT*> released;
  for (const auto& item : state.items)
    if (item->status == ItemStatus::released && (floor == 0 || item->floor == floor))
      released[item->kind + " " + item->id] = item.get();
  for (const auto& bracket : plan.brackets)
    if (const auto item = released.find("bracket " + bracket->id); item != released.end())
      job.items.push_back(bracket_item(*bracket, *item->second, job.origin));
  for (const auto& panel : plan.panels)
    if (const auto item = released.find("panel " + panel->id); item != released.end())
      job.items.push_back(panel_item(*panel, *item->second, job.origin));
  // A job with other contents has another name; when it was written is no content.
  Job content = job;
  content.created_at.clear(), content.valid_until.clear();
  job.id = "job-" + std::to_string(job.revision) + (floor > 0 ? "-F" + std::to_string(floor) : "") + "-" +
           sha256_hex(job_json(content)).substr(0, 12);
  return job;
}

Job in_survey(const Job& job, const FrameLink& building_from_survey) {
  Job out = job;
  const auto turned = [&](const Eigen::Vector3d& place) {
    return Eigen::Vector3d(building_from_survey.apply_inverse(place + job.origin));
  };
  out.frame = "survey";
  out.origin = origin_near(job.items.empty() ? turned(Eigen::Vector3d::Zero()) : turned(job.items.front().design));
  out.building_from_job = link_about(building_from_survey, out.origin);
  const Eigen::Quaterniond back = building_from_survey.to_from_from.rotation.conjugate();
  for (JobItem& item : out.items) {
    item.design = turned(item.design) - out.origin, item.target = turned(item.target) - out.origin;
    item.design_rotation = back * item.design_rotation, item.target_rotation = back * item.target_rotation;
  }
  return out;
}

void note_jobs(const InstallationPlanT& plan, LoopStateT& state) {
  std::set<int> floors = {0};
  for (const auto& item : state.items)
    if (item->status == ItemStatus::released) floors.insert(item->floor);
  for (const int floor : floors) {
    const std::string id = make_job(plan, state, floor, "", "").id;
    for (auto& item : state.items)
      if (item->status == ItemStatus::released && (floor == 0 || item->floor == floor) &&
          std::find(item->jobs.begin(), item->jobs.end(), id) == item->jobs.end())
        item->jobs.push_back(id);
  }
}

namespace {

ordered_json link_json(const FrameLink& link) {
  ordered_json covariance = ordered_json::array();
  for (int i = 0; i < 6; ++i)  // the job has places before rotations, the link rotations before places
    for (int j = 0; j < 6; ++j) covariance.push_back(link.covariance((i + 3) % 6, (j + 3) % 6));
  return {{"position", numbers(link.to_from_from.translation)},
          {"orientation", quaternion(link.to_from_from.rotation)},
          {"scale", link.scale},
          {"scalesPlanOnly", link.plan_only},
          {"covariance", covariance},
          {"source", link.origin}};
}

}  // namespace

std::string job_json(const Job& job) {
  ordered_json out;
  out["jobId"] = job.id, out["revision"] = job.revision;
  if (!job.created_at.empty()) out["createdAt"] = job.created_at;
  if (!job.valid_until.empty()) out["validUntil"] = job.valid_until;
  out["units"] = {{"length", "m"}, {"angle", "rad"}};
  out["sources"] = {{"basis", job.basis}, {"designFile", job.design_file}};
  ordered_json covariance = ordered_json::array();
  for (int i = 0; i < 36; ++i) covariance.push_back(i % 7 == 0 && i < 21 ? job.station_sigma * job.station_sigma : 0.0);
  out["frames"] = {{{"name", job.frame},
                    {"origin", numbers(job.origin)},
                    {"orientation", {0.0, 0.0, 0.0, 1.0}},
                    {"robotInFrameCovariance", covariance}}};
  if (job.building_from_job) out["frames"][0]["buildingFromFrame"] = link_json(*job.building_from_job);
  out["assumedRobot"] = {{"settingSigma", job.setting_sigma}, {"stationSigma", job.station_sigma}};
  out["items"] = ordered_json::array();
  for (const JobItem& item : job.items) {
    ordered_json entry;
    entry["id"] = item.id, entry["kind"] = item.kind, entry["operation"] = item.operation;
    if (!item.guid.empty()) entry["ifcGuid"] = item.guid;
    entry["storey"] = item.floor, entry["revision"] = item.revision, entry["dependsOn"] = item.depends_on;
    entry["frame"] = job.frame;
    entry["designPose"] = {{"position", numbers(item.design)}, {"orientation", quaternion(item.design_rotation)}};
    entry["targetPose"] = {{"position", numbers(item.target)}, {"orientation", quaternion(item.target_rotation)}};
    if (item.kind == "bracket")
      entry["setting"] = {{"right", item.setting.x()}, {"up", item.setting.y()}, {"out", item.setting.z()}};
    entry["toleranceZone"] = {{"right", item.tolerance.x()}, {"up", item.tolerance.y()}, {"out", item.tolerance.z()}};
    entry["forbiddenZones"] = ordered_json::array();
    entry["gate"] = {{"verdict", "GO"}, {"reason", item.reason}};
    if (item.kind == "panel" && std::isfinite(item.p_in)) entry["gate"]["probability"] = item.p_in;
    out["items"].push_back(std::move(entry));
  }
  return out.dump(1, ' ', false, ordered_json::error_handler_t::replace) + "\n";
}

namespace {

/// A place in the file, for messages.
class Reader {
 public:
  Reader(const ordered_json& value, std::string path) : value_(value), path_(std::move(path)) {}

  [[noreturn]] void fail(const std::string& expected) const {
    std::string found = value_.dump();
    if (found.size() > 60) found = found.substr(0, 57) + "...";
    throw std::runtime_error("job: " + (path_.empty() ? "the file" : path_) + " is " + found + ", expected " +
                             expected);
  }
  Reader at(const std::string& key) const {
    if (!value_.is_object()) fail("an object");
    if (!value_.contains(key))
      throw std::runtime_error("job: " + (path_.empty() ? "the file" : path_) + " lacks '" + key + "'");
    return {value_.at(key), path_.empty() ? key : path_ + "." + key};
  }
  /// A robot does not carry out what it knows only a part of.
  const Reader& only(const std::vector<std::string>& known) const {
    if (!value_.is_object()) fail("an object");
    for (const auto& [key, value] : value_.items())
      if (std::find(known.begin(), known.end(), key) == known.end()) {
        const std::string meant = meant_by(key, known);
        throw std::runtime_error("job: " + (path_.empty() ? "the file" : path_) + " has '" + key + "', " +
                                 (meant.empty() ? "which is no key: what it asks for would not be done"
                                                : "which is no key; '" + meant + "' is"));
      }
    return *this;
  }
  bool has(const std::string& key) const { return value_.is_object() && value_.contains(key); }
  std::string text() const {
    if (!value_.is_string()) fail("text");
    return value_.get<std::string>();
  }
  std::string name() const {
    if (text().empty()) fail("a name");
    return text();
  }
  std::string one_of(const std::set<std::string>& allowed) const {
    const std::string found = text();
    std::string list;
    for (const std::string& word : allowed) list += (list.empty() ? "" : " or ") + word;
    if (!allowed.count(found)) fail(list);
    return found;
  }
  int whole(int least) const {
    if (!value_.is_number_integer() || value_.get<double>() < least || value_.get<double>() > 1e9)
      fail("a whole number from " + std::to_string(least));
    return value_.get<int>();
  }
  bool flag() const {
    if (!value_.is_boolean()) fail("true or false");
    return value_.get<bool>();
  }
  double number() const {
    if (!value_.is_number() || !std::isfinite(value_.get<double>())) fail("a finite number");
    return value_.get<double>();
  }
  double number_from(double least, double most) const {
    const double found = number();
    if (!(found >= least && found <= most))
      fail("a number from " + std::to_string(least) + " to " + std::to_string(most));
    return found;
  }
  std::vector<Reader> items() const {
    if (!value_.is_array()) fail("a list");
    std::vector<Reader> out;
    for (std::size_t i = 0; i < value_.size(); ++i) out.push_back({value_[i], path_ + "[" + std::to_string(i) + "]"});
    return out;
  }
  Eigen::Vector3d vector() const {
    const auto parts = items();
    if (parts.size() != 3) fail("three numbers");
    return {parts[0].number(), parts[1].number(), parts[2].number()};
  }
  Eigen::Quaterniond rotation() const {
    const auto parts = items();
    if (parts.size() != 4) fail("a quaternion x, y, z, w");
    const Eigen::Quaterniond q(parts[3].number(), parts[0].number(), parts[1].number(), parts[2].number());
    if (std::abs(q.norm() - 1) > 1e-6) fail("a quaternion of length 1");
    return q;
  }
  Eigen::Vector3d directions(double least, double most) const {
    return {at("right").number_from(least, most), at("up").number_from(least, most),
            at("out").number_from(least, most)};
  }

 private:
  const ordered_json& value_;
  std::string path_;
};

std::vector<double> read_covariance(const Reader& reader) {
  std::vector<double> numbers;
  for (const Reader& one : reader.items()) numbers.push_back(one.number());
  if (numbers.size() != 36) reader.fail("36 numbers, row by row");
  return numbers;
}

FrameLink read_link(const Reader& reader, const std::string& frame) {
  reader.only({"position", "orientation", "scale", "scalesPlanOnly", "covariance", "source"});
  FrameLink link;
  link.to = "building", link.from = frame, link.origin = reader.at("source").text();
  link.to_from_from.translation = reader.at("position").vector();
  link.to_from_from.rotation = reader.at("orientation").rotation();
  link.scale = reader.at("scale").number_from(0.9, 1.1), link.plan_only = reader.at("scalesPlanOnly").flag();
  const std::vector<double> covariance = read_covariance(reader.at("covariance"));
  for (int i = 0; i < 6; ++i)
    for (int j = 0; j < 6; ++j) link.covariance((i + 3) % 6, (j + 3) % 6) = covariance[6 * i + j];
  return link;
}

/// Name, origin, and where it lies in the building.
void read_frame(const Reader& frame, Job& job) {
  frame.only({"name", "origin", "orientation", "robotInFrameCovariance", "buildingFromFrame"});
  job.frame = frame.at("name").one_of({"building", "survey"}), job.origin = frame.at("origin").vector();
  if (frame.at("orientation").rotation().vec().norm() > 1e-9)
    frame.at("orientation").fail("0, 0, 0, 1: the root frame is not turned, and items would be");
  read_covariance(frame.at("robotInFrameCovariance"));
  if (frame.has("buildingFromFrame") && job.frame == "building")
    frame.at("buildingFromFrame").fail("nothing: the frame is the building's own");
  if (job.frame == "survey") job.building_from_job = read_link(frame.at("buildingFromFrame"), job.frame);
}

JobItem read_item(const Reader& reader, const std::string& frame) {
  JobItem item;
  reader.only({"id", "kind", "operation", "ifcGuid", "storey", "revision", "dependsOn", "frame", "designPose",
               "targetPose", "setting", "toleranceZone", "forbiddenZones", "gate"});
  reader.at("designPose").only({"position", "orientation"}), reader.at("targetPose").only({"position", "orientation"});
  if (reader.has("setting")) reader.at("setting").only({"right", "up", "out"});
  reader.at("toleranceZone").only({"right", "up", "out"});
  reader.at("gate").only({"verdict", "reason", "probability"});
  if (reader.has("forbiddenZones") && !reader.at("forbiddenZones").items().empty())
    reader.at("forbiddenZones").fail("none: what reads jobs here does not keep a tool out of zones");
  item.id = reader.at("id").name(), item.kind = reader.at("kind").one_of({"bracket", "panel"});
  item.operation = reader.at("operation").one_of({"setBracket", "placePanel", "drill", "setAnchor", "mountBracket"});
  if (reader.has("ifcGuid")) item.guid = reader.at("ifcGuid").text();
  item.floor = reader.at("storey").whole(0), item.revision = reader.at("revision").whole(1);
  for (const Reader& before : reader.at("dependsOn").items()) item.depends_on.push_back(before.text());
  reader.at("frame").one_of({frame});
  item.design = reader.at("designPose").at("position").vector();
  item.design_rotation = reader.at("designPose").at("orientation").rotation();
  item.target = reader.at("targetPose").at("position").vector();
  item.target_rotation = reader.at("targetPose").at("orientation").rotation();
  if (item.kind == "bracket") item.setting = reader.at("setting").directions(-0.5, 0.5);
  item.tolerance = reader.at("toleranceZone").directions(1e-6, 1);
  reader.at("gate").at("verdict").one_of({"GO"});  // nothing else may be executed
  item.reason = reader.at("gate").at("reason").text();
  if (reader.at("gate").has("probability")) item.p_in = reader.at("gate").at("probability").number_from(0, 1);
  return item;
}

void check_items(const Job& job) {
  std::set<std::string> ids;
  std::vector<Panel> graph;
  for (const JobItem& item : job.items) {
    if (!ids.insert(item.id).second) throw std::runtime_error("job: item '" + item.id + "' occurs twice");
    if (item.revision > job.revision)
      throw std::runtime_error("job: item '" + item.id + "' is of revision " + std::to_string(item.revision) +
                               ", its job of " + std::to_string(job.revision) + ": it is of another job");
    if ((item.target - item.design).norm() > 0.5)
      throw std::runtime_error("job: the target of item '" + item.id + "' is " +
                               std::to_string((item.target - item.design).norm()) +
                               " m from its design; expected 0.5 m or less");
    graph.emplace_back();
    graph.back().id = item.id, graph.back().depends_on = item.depends_on;
  }
  installation_order(graph);
}

}  // namespace

Job read_job(const std::string& text) {
  ordered_json parsed;
  try {
    parsed = parse_each_key_once(text);
  } catch (const std::runtime_error& error) {
    throw std::runtime_error(std::string("job: the file ") + error.what());
  }
  const Reader root(parsed, "");
  root.only({"jobId", "revision", "createdAt", "validUntil", "units", "sources", "frames", "assumedRobot", "items"});
  root.at("units").only({"length", "angle"}), root.at("sources").only({"basis", "designFile"});
  root.at("assumedRobot").only({"settingSigma", "stationSigma"});
  Job job;
  job.id = root.at("jobId").name(), job.revision = root.at("revision").whole(0);
  if (root.has("createdAt")) job.created_at = root.at("createdAt").text();
  if (root.has("validUntil")) job.valid_until = root.at("validUntil").text();
  root.at("units").at("length").one_of({"m"}), root.at("units").at("angle").one_of({"rad"});
  job.basis = root.at("sources").at("basis").text();
  if (root.at("sources").has("designFile")) job.design_file = root.at("sources").at("designFile").text();
  const auto frames = root.at("frames").items();
  if (frames.size() != 1) root.at("frames").fail("one root frame");
  read_frame(frames[0], job);
  job.setting_sigma = root.at("assumedRobot").at("settingSigma").number_from(0, 1);
  job.station_sigma = root.at("assumedRobot").at("stationSigma").number_from(0, 1);
  for (const Reader& item : root.at("items").items()) job.items.push_back(read_item(item, job.frame));
  check_items(job);
  return job;
}

}  // namespace plumbline::loop
