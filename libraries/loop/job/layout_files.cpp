#include "loop/job/layout_files.hpp"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <map>
#include <nlohmann/json.hpp>
#include <set>
#include <stdexcept>

#include "base/text/text.hpp"
#include "loop/fit/facade.hpp"
#include "loop/job/unknown_keys.hpp"

namespace plumbline::loop {
namespace {

std::string metres(double value) { return text::format_fixed(value, 4); }

const char* gate_name(GateDecision gate) {
  return gate == GateDecision::go ? "GO" : gate == GateDecision::no_go ? "NO_GO" : "HOLD";
}

std::unique_ptr<ActualT> empty_actual() {
  auto actual = std::make_unique<ActualT>();
  actual->measured.setConstant(kUnknown), actual->sigma.setConstant(kUnknown), actual->setting.setConstant(kUnknown);
  return actual;
}

}  // namespace

std::string layout_csv(const std::vector<LayoutPoint>& points, LayoutFormat format) {
  const char separator = format == LayoutFormat::hilti ? ';' : ',';
  std::string text = format == LayoutFormat::hilti     ? "PtID;E;N;H\n"
                     : format == LayoutFormat::trimble ? "Name,Northing,Easting,Elevation,Code\n"
                                                       : "PtID,E,N,H,Code\n";
  for (const LayoutPoint& point : points) {
    if (point.name.find_first_of(";,\"\n") != std::string::npos)
      throw std::runtime_error("point '" + point.name +
                               "' cannot be written for a layout tool: its name has a separator");
    const std::string e = metres(point.position.x()), n = metres(point.position.y()), h = metres(point.position.z());
    text += point.name;
    for (const std::string& value : format == LayoutFormat::trimble ? std::vector{n, e, h} : std::vector{e, n, h})
      text += separator + value;
    if (format != LayoutFormat::hilti) text += separator + point.code;
    text += "\n";
  }
  return text;
}

std::vector<LayoutPoint> layout_points(const Job& job) {
  std::vector<LayoutPoint> points;
  for (const JobItem& item : job.items)
    if (item.kind == "bracket") points.push_back({item.id, item.target + job.origin, "GO"});
  return points;
}

namespace {

void dxf_place(std::string& text, const Eigen::Vector3d& p) {
  text += "10\n" + metres(p.x()) + "\n20\n" + metres(p.y()) + "\n30\n" + metres(p.z()) + "\n";
}

void dxf_point(std::string& text, const LayoutPoint& point, const std::string& layer) {
  text += "0\nPOINT\n8\n" + layer + "\n";
  dxf_place(text, point.position);
  text += "0\nTEXT\n8\n" + layer + "\n";
  dxf_place(text, point.position);
  text += "40\n0.05\n1\n" + point.name + "\n";
}

std::string layer_of(const PlannedPanelT& panel) {
  return std::string("PANEL_") + (panel.installed ? "HUNG" : gate_name(panel.gate));
}

void dxf_outline(std::string& text, const PlannedPanelT& panel, const SurveyLink& survey) {
  const std::string layer = layer_of(panel);
  text += "0\nPOLYLINE\n8\n" + layer + "\n66\n1\n10\n0.0\n20\n0.0\n30\n0.0\n70\n9\n";  // closed, in space
  for (const std::size_t corner : {0u, 1u, 3u, 2u}) {
    const Eigen::Vector3d arm = panel.corners[corner] - panel.centre;
    text += "0\nVERTEX\n8\n" + layer + "\n";
    const Eigen::Vector3d place = panel.corners[corner] + panel.shift + panel.rotation.cross(arm);
    dxf_place(text, survey ? survey->apply_inverse(place) : place);
    text += "70\n32\n";
  }
  text += "0\nSEQEND\n8\n" + layer + "\n";
}

}  // namespace

std::string layout_dxf(const InstallationPlanT& plan, const Job& job, const std::vector<LayoutPoint>& control,
                       const SurveyLink& survey) {
  std::string entities;
  std::set<std::string> layers, of_job;
  for (const JobItem& item : job.items) of_job.insert(item.id);
  for (const LayoutPoint& point : layout_points(job)) {
    layers.insert("BRACKET_" + point.code);
    dxf_point(entities, point, "BRACKET_" + point.code);
  }
  for (const LayoutPoint& point : control) layers.insert("CONTROL"), dxf_point(entities, point, "CONTROL");
  for (const auto& panel : plan.panels) {
    const bool concerned =
        of_job.contains(panel->id) || std::any_of(panel->brackets.begin(), panel->brackets.end(),
                                                  [&](const std::string& id) { return of_job.contains(id); });
    if (panel->corners.size() != 4 || !concerned) continue;
    layers.insert(layer_of(*panel));
    dxf_outline(entities, *panel, survey);
  }
  std::string text =
      "0\nSECTION\n2\nHEADER\n9\n$ACADVER\n1\nAC1009\n0\nENDSEC\n0\nSECTION\n2\nTABLES\n0\nTABLE\n2\nLAYER\n70\n" +
      std::to_string(layers.size()) + "\n";
  for (const std::string& layer : layers) {
    const bool go = layer.find("_GO") != std::string::npos && layer.find("NO_GO") == std::string::npos;
    const int colour = layer == "CONTROL" ? 5 : go ? 3 : layer.find("NO_GO") != std::string::npos ? 1 : 2;
    text += "0\nLAYER\n2\n" + layer + "\n70\n0\n62\n" + std::to_string(colour) + "\n6\nCONTINUOUS\n";
  }
  return text + "0\nENDTAB\n0\nENDSEC\n0\nSECTION\n2\nENTITIES\n" + entities + "0\nENDSEC\n0\nEOF\n";
}

namespace {

using Json = nlohmann::ordered_json;

const std::vector<std::string> kActualKeys = {"item",  "job",     "revision", "by",    "at",   "outcome", "measured",
                                              "sigma", "setting", "note",     "units", "unit", "frame"};

const std::vector<std::string> kFrames = {"building", "survey"};

Json parsed_actuals(const std::string& text, const std::string& source) {
  static const char* const kExpected = "expected {\"items\": [{\"item\": \"F01-C01-R1\", \"outcome\": \"done\"}]}";
  if (text.find_first_not_of(" \t\r\n") == std::string::npos)
    throw std::runtime_error(source + ": is empty; " + kExpected);
  Json parsed;
  try {
    parsed = parse_each_key_once(text);
    if (parsed.is_object()) refuse_other_units(parsed, kFrames);
  } catch (const std::runtime_error& error) {
    throw std::runtime_error(source + ": " + error.what());
  }
  if (parsed.is_object() && parsed.contains("jobId"))
    throw std::runtime_error(source + ": is a job, what is to be done; expected reports of what was done");
  if (!parsed.is_object() || !parsed.contains("items") || !parsed["items"].is_array())
    throw std::runtime_error(source + ": has no list 'items'; " + kExpected);
  return parsed;
}

/// Throws std::runtime_error that says which key is wrong, and how; keys that nobody reads are counted in `ignored`.
std::unique_ptr<ActualT> actual_of(const Json& entry, std::map<std::string, int>& ignored) {
  if (!entry.is_object()) throw std::runtime_error("is no object with 'item' and 'outcome'");
  refuse_other_units(entry, kFrames);
  note_unknown_keys(entry, kActualKeys, ignored);
  auto actual = empty_actual();
  const auto wrong = [&](const char* key, const char* expected) {
    throw std::runtime_error(std::string("'") + key + "' is " + entry.at(key).dump() + ", expected " + expected);
  };
  const auto take_text = [&](const char* key, std::string& text, bool needed) {
    if (!entry.contains(key) && needed) throw std::runtime_error(std::string("has no '") + key + "'");
    if (!entry.contains(key)) return;
    if (!entry[key].is_string()) wrong(key, "text");
    text = entry[key].get<std::string>();
  };
  take_text("item", actual->item, true), take_text("outcome", actual->outcome, true);
  take_text("job", actual->job, false), take_text("by", actual->by, false), take_text("at", actual->at, false);
  take_text("note", actual->note, false);
  if (entry.contains("revision")) {
    if (!entry["revision"].is_number_integer()) wrong("revision", "a whole number");
    if (!(entry["revision"].get<double>() >= 1 && entry["revision"].get<double>() <= 1e9))
      wrong("revision", "that of the job, 1 or more");
    actual->revision = entry["revision"].get<int>();
  }
  const auto take_three = [&](const char* key, Eigen::Vector3d& place, const char* expected, bool by_direction) {
    if (!entry.contains(key)) return;
    for (int k = 0; k < 3; ++k) {
      const Json::json_pointer at(by_direction ? std::string("/") + kDirections[k] : "/" + std::to_string(k));
      const bool has = entry[key].is_structured() && entry[key].is_object() == by_direction && entry[key].size() == 3 &&
                       entry[key].contains(at);
      if (!has || !entry[key][at].is_number()) wrong(key, expected);
      place[k] = entry[key][at].get<double>();
    }
  };
  take_three("measured", actual->measured, "[E, N, H] in metres", false);
  take_three("sigma", actual->sigma, "three standard deviations in metres", false);
  if ((actual->sigma.array() <= 0).any()) wrong("sigma", "three standard deviations in metres, each above 0");
  take_three("setting", actual->setting, "{\"right\": 0.002, \"up\": 0, \"out\": -0.001} in metres", true);
  return actual;
}

}  // namespace

namespace {

/// Where the two frames differ nobody can tell which of them a place is in that does not say it.
void bring_said_to_building(ActualT& actual, const Json& entry, const Json& file, const SurveyLink& survey) {
  if (!survey || !actual.measured.allFinite()) return bring_to_building(actual, SurveyLink());
  const Json frame = entry.contains("frame") ? entry["frame"] : file.contains("frame") ? file["frame"] : Json();
  if (frame.is_null())
    throw std::runtime_error(
        "'measured' is in a frame that is not said, and survey and design have two here (" + survey->origin +
        "); expected \"frame\": \"survey\", that of the control and of the job, or \"building\", that of the design");
  bring_to_building(actual, frame == "survey" ? survey : SurveyLink());
}

/// Beside 'items'.
void note_unknown_of_file(const Json& parsed, const std::string& source, std::map<std::string, int>& ignored) {
  try {
    note_unknown_keys(parsed, {"items", "units", "unit", "frame"}, ignored);
  } catch (const std::runtime_error& error) {
    throw std::runtime_error(source + ": " + error.what());
  }
}

}  // namespace

ActualsT read_actuals_json(const std::string& text, const std::string& source, const SurveyLink& survey) {
  const Json parsed = parsed_actuals(text, source);
  ActualsT out;
  out.sources.push_back(source);
  std::size_t index = 0;
  std::map<std::string, int> ignored;
  for (const Json& entry : parsed["items"]) {
    const std::string place = source + ": items[" + std::to_string(index++) + "]";
    try {
      auto actual = actual_of(entry, ignored);
      bring_said_to_building(*actual, entry, parsed, survey);
      out.items.push_back(std::move(actual));
      out.items.back()->source = source + " items[" + std::to_string(index - 1) + "]";
    } catch (const std::runtime_error& error) {
      out.refused.push_back(place + ": " + error.what());
    }
  }
  note_unknown_of_file(parsed, source, ignored);
  if (const std::string words = words_of_ignored(ignored); !words.empty()) out.ignored.push_back(source + ": " + words);
  return out;
}

}  // namespace plumbline::loop
