#include "build/evaluate/epoch_json.hpp"

#include <cmath>
#include <nlohmann/json.hpp>
#include <stdexcept>

#include "base/text/whole_file.hpp"
#include "build/evaluate/long_lists.hpp"
#include "plumbline/failure.hpp"

namespace plumbline::judgement {
namespace {

using Json = nlohmann::ordered_json;
constexpr const char* kFormat = "plumbline-as-built/1";

Json list(const Eigen::Vector3d& v) { return {v.x(), v.y(), v.z()}; }

/// xx, xy, xz, yy, yz, zz; empty where unknown.
Json list(const Eigen::Matrix3d& c) {
  if (!c.allFinite()) return Json::array();
  return {c(0, 0), c(0, 1), c(0, 2), c(1, 1), c(1, 2), c(2, 2)};
}

Json to_json(const EpochItem& item) {
  Json out = {{"kind", item.kind},        {"id", item.id},         {"guid", item.guid},
              {"floor", item.floor},      {"facade", item.facade}, {"verdict", EnumNameToleranceVerdict(item.verdict)},
              {"was_open", item.was_open}};
  if (item.kind == "anchor")
    out["design"] = list(item.design), out["position"] = list(item.position), out["covariance"] = list(item.covariance);
  if (!item.topic.empty()) out["topic"] = item.topic, out["quantity"] = item.quantity, out["value"] = item.value;
  if (!item.open_joints.empty()) {
    Json joints = Json::object();
    for (const auto& [panel, verdict] : item.open_joints) joints[panel] = EnumNameToleranceVerdict(verdict);
    out["open_joints"] = joints;
  }
  Json limits = Json::object();
  for (const auto& [axis, limit] : item.limits) limits[axis] = Json::array({limit[0], limit[1]});
  out["limits"] = limits;
  return out;
}

Json to_json(const EpochFinding& finding) {
  return {{"topic", finding.topic},   {"title", finding.title},     {"kind", finding.kind}, {"floor", finding.floor},
          {"facade", finding.facade}, {"anchors", finding.anchors}, {"open", finding.open}};
}

Json to_json(const FindingChangeT& change) {
  return {{"topic", change.topic},
          {"title", change.title},
          {"kind", change.kind},
          {"change", EnumNameChangeKind(change.change)},
          {"note", change.note}};
}

Json to_json(const AsBuiltChangeT& change) {
  return {{"kind", change.kind},
          {"id", change.id},
          {"guid", change.guid},
          {"floor", change.floor},
          {"before", EnumNameToleranceVerdict(change.before)},
          {"after", EnumNameToleranceVerdict(change.after)},
          {"change", EnumNameChangeKind(change.change)},
          {"note", change.note},
          {"value_before", change.value_before},
          {"value", change.value},
          {"moved", change.moved},
          {"movement", list(change.movement)},
          {"u", change.u}};
}

template <class Items, class ToJson>
Json list_of(const Items& items, const ToJson& to_json_of) {
  Json all = Json::array();
  for (const auto& item : items) all.push_back(to_json_of(item));
  return all;
}

double number(const nlohmann::json& value) {
  return value.is_number() ? value.get<double>() : std::numeric_limits<double>::quiet_NaN();
}

Eigen::Vector3d vector(const nlohmann::json& value) {
  Eigen::Vector3d v = Eigen::Vector3d::Constant(std::numeric_limits<double>::quiet_NaN());
  if (value.is_array() && value.size() == 3)
    for (int k = 0; k < 3; ++k) v[k] = number(value[k]);
  return v;
}

Eigen::Matrix3d matrix(const nlohmann::json& value) {
  Eigen::Matrix3d c = Eigen::Matrix3d::Constant(std::numeric_limits<double>::quiet_NaN());
  if (!value.is_array() || value.size() != 6) return c;
  std::size_t k = 0;
  for (int row = 0; row < 3; ++row)
    for (int column = row; column < 3; ++column) c(row, column) = c(column, row) = number(value[k++]);
  return c;
}

ToleranceVerdict verdict_of(const nlohmann::json& from, const std::string& id) {
  const auto word = from.get<std::string>();
  for (const ToleranceVerdict verdict :
       {ToleranceVerdict::not_measured, ToleranceVerdict::pass, ToleranceVerdict::undecided, ToleranceVerdict::fail})
    if (word == EnumNameToleranceVerdict(verdict)) return verdict;
  throw std::runtime_error("the verdict of '" + id + "' is '" + word + "'");
}

EpochFinding finding_of(const nlohmann::json& from) {
  EpochFinding finding;
  finding.topic = from.at("topic").get<std::string>(), finding.title = from.value("title", finding.topic);
  finding.kind = from.value("kind", ""), finding.facade = from.value("facade", "");
  finding.floor = from.value("floor", 0), finding.open = from.value("open", true);
  finding.anchors = from.value("anchors", std::vector<std::string>());
  return finding;
}

EpochItem item_of(const nlohmann::json& from) {
  EpochItem item;
  item.kind = from.at("kind").get<std::string>(), item.id = from.at("id").get<std::string>();
  item.guid = from.value("guid", ""), item.facade = from.value("facade", ""), item.floor = from.value("floor", 0);
  item.verdict = verdict_of(from.at("verdict"), item.id);
  item.topic = from.value("topic", ""), item.quantity = from.value("quantity", "");
  item.value = number(from.value("value", nlohmann::json()));
  if (const auto joints = from.find("open_joints"); joints != from.end() && joints->is_object())
    for (const auto& joint : joints->items()) item.open_joints[joint.key()] = verdict_of(joint.value(), item.id);
  item.was_open = from.value("was_open", item.open());
  item.design = vector(from.value("design", nlohmann::json())),
  item.position = vector(from.value("position", nlohmann::json())),
  item.covariance = matrix(from.value("covariance", nlohmann::json()));
  if (const auto limits = from.find("limits"); limits != from.end() && limits->is_object())
    for (const auto& limit : limits->items())
      if (limit.value().is_array() && limit.value().size() == 2)
        item.limits[limit.key()] = {number(limit.value()[0]), number(limit.value()[1])};
  return item;
}

}  // namespace

std::string epoch_json(const EpochRecord& record, const AsBuiltChangesT& changes) {
  Json since = nullptr;
  if (changes.compared) {
    Json all = Json::array();
    for (const auto& change : changes.changes)
      if (change->change != ChangeKind::in_order || change->moved) all.push_back(to_json(*change));
    since = {{"before", changes.before},
             {"in_words", words_of_changes(changes)},
             {"moved_together", list(changes.together)},
             {"warnings", changes.warnings},
             {"changes", all},
             {"findings", list_of(changes.findings, [](const auto& change) { return to_json(*change); })}};
  }
  const Json document = {{"format", kFormat},
                         {"epoch", record.epoch},
                         {"design_file", record.design_file},
                         {"tolerance", record.tau},
                         {"risk", record.risk},
                         {"units", {{"length", "m"}, {"covariance", "m2"}}},
                         {"findings", list_of(record.findings, [](const auto& finding) { return to_json(finding); })},
                         {"items", place_of_list("items")},
                         {"since", since}};
  std::string text = document.dump(1, ' ', false, Json::error_handler_t::replace) + "\n";
  put_list(text, "items", record.items, [](const EpochItem& item) { return to_json(item); });
  return text;
}

EpochRecord read_epoch(const std::string& path) {
  const auto document = nlohmann::json::parse(text::read_whole(path), nullptr, false);
  const auto format = document.is_object() ? document.find("format") : document.end();
  if (!document.is_object() || format == document.end() || *format != kFormat)
    throw BadInput("parameter 'before': " + path + " is " +
                   (document.is_discarded() ? "no JSON"
                    : !document.is_object() || format == document.end() || !format->is_string()
                        ? "JSON of another kind"
                        : format->get<std::string>()) +
                   ", expected as_built.json of the campaign before (" + kFormat + ")");
  try {
    EpochRecord record{document.value("epoch", ""),
                       document.value("design_file", ""),
                       number(document.value("tolerance", nlohmann::json())),
                       number(document.value("risk", nlohmann::json())),
                       {},
                       {}};
    for (const auto& item : document.at("items")) record.items.push_back(item_of(item));
    for (const auto& finding : document.value("findings", nlohmann::json::array()))  // older records have none
      record.findings.push_back(finding_of(finding));
    return record;
  } catch (const std::exception& error) {
    throw BadInput("parameter 'before': " + path + " is damaged: " + error.what());
  }
}

}  // namespace plumbline::judgement
