// Orders and states of VDA 5050 against the official schemas.
#include <gtest/gtest.h>

#include <algorithm>
#include <nlohmann/json.hpp>
#include <random>
#include <regex>
#include <set>
#include <valijson/adapters/nlohmann_json_adapter.hpp>
#include <valijson/schema.hpp>
#include <valijson/schema_parser.hpp>
#include <valijson/validator.hpp>

#include "loop/exchange/order_exchange.hpp"
#include "loop/exchange/vda5050.hpp"
#include "test_support.hpp"

namespace plumbline::loop {
namespace test_vda5050 {

using nlohmann::json;

constexpr double kPi = 3.14159265358979323846;

JobItem item_at(const std::string& id, const std::string& kind, const Eigen::Vector3d& place) {
  JobItem item;
  item.id = id, item.kind = kind, item.operation = kind == "bracket" ? "setBracket" : "placePanel";
  item.floor = 2, item.revision = 3, item.reason = "p 0.990";
  item.design = place, item.target = place + Eigen::Vector3d(0, 0, 0.004);
  item.setting = {0, 0.004, 0}, item.tolerance.setConstant(0.001);
  return item;
}

Job make_job() {
  Job job;
  job.id = "job-3-F2-0123456789ab", job.revision = 3, job.origin = {432000, 5812000, 0};
  job.items = {item_at("F02-C01-R1", "bracket", {100, 300, 8}), item_at("F02-C01-R2", "bracket", {100, 300, 10}),
               item_at("F02-C02-R1", "bracket", {102, 300, 8}), item_at("F02-P01", "panel", {101, 300, 9})};
  job.items.back().depends_on = {"F02-C01-R1", "F02-C01-R2"};
  return job;
}

VdaRobot make_robot(VdaVersion version) { return {version, "Acme", "R2D2", 7, "2026-05-02T08:00:00Z", std::nullopt}; }

/// The schemas of 3.0.0 have commas before closing brackets, which JSON does not.
json schema_of(const std::string& version, const std::string& name) {
  const std::string text = test::read_file(test::data_file("robot/vda5050/" + version + "/" + name + ".schema"));
  return json::parse(std::regex_replace(text, std::regex(",(\\s*[}\\]])"), "$1"));
}

std::string faults(const json& schema_text, const json& document) {
  valijson::Schema schema;
  valijson::SchemaParser parser;
  parser.populateSchema(valijson::adapters::NlohmannJsonAdapter(schema_text), schema);
  valijson::Validator validator;
  valijson::ValidationResults results;
  std::string words;
  if (!validator.validate(schema, valijson::adapters::NlohmannJsonAdapter(document), &results))
    for (const auto& error : results) {
      for (const std::string& part : error.context) words += part;
      words += ": " + error.description + "\n";
    }
  return words;
}

TEST(Vda5050, OrdersKeepTheOfficialSchemas) {
  PLUMBLINE_REQUIRE_DATA("robot/vda5050/3.0.0/order.schema");
  for (const auto& [version, name] : {std::pair(VdaVersion::v2_0, "2.0.0"), std::pair(VdaVersion::v3_0, "3.0.0")}) {
    const json order = json::parse(vda_order(make_job(), make_robot(version)));
    EXPECT_EQ(faults(schema_of(name, "order"), order), "") << name;
    EXPECT_EQ(order["version"], name);
    json wrong = order;
    wrong["nodes"][0].erase("released");
    EXPECT_NE(faults(schema_of(name, "order"), wrong), "") << name;
    wrong = order;
    wrong["nodes"][0]["actions"][0]["blockingType"] = "SOMETIMES";
    EXPECT_NE(faults(schema_of(name, "order"), wrong), "") << name;
  }
  EXPECT_EQ(faults(schema_of("2.1.0", "order"), json::parse(vda_order(make_job(), make_robot(VdaVersion::v2_0)))), "");
}

TEST(Vda5050, AnOrderIsTheJobPlaceByPlace) {
  const Job job = make_job();
  const json order = json::parse(vda_order(job, make_robot(VdaVersion::v2_0)));
  EXPECT_EQ(order["orderId"], job.id);
  ASSERT_EQ(order["nodes"].size(), 3u);  // both brackets of a column from one place
  ASSERT_EQ(order["edges"].size(), 2u);
  for (std::size_t i = 0; i < 3; ++i) EXPECT_EQ(order["nodes"][i]["sequenceId"], 2 * i);
  for (std::size_t i = 0; i < 2; ++i) {
    EXPECT_EQ(order["edges"][i]["sequenceId"], 2 * i + 1);
    EXPECT_EQ(order["edges"][i]["startNodeId"], order["nodes"][i]["nodeId"]);
    EXPECT_EQ(order["edges"][i]["endNodeId"], order["nodes"][i + 1]["nodeId"]);
  }
  EXPECT_EQ(order["nodes"][0]["nodePosition"]["mapId"], "floor-2");
  EXPECT_EQ(order["nodes"][0]["nodePosition"]["x"], 432100.0);
  std::vector<std::string> done;
  for (const json& node : order["nodes"])
    for (const json& action : node["actions"]) {
      std::map<std::string, json> parameter;
      for (const json& p : action["actionParameters"]) parameter[p["key"]] = p["value"];
      done.push_back(parameter.at("item"));
      EXPECT_EQ(parameter.at("revision"), 3);
      EXPECT_EQ(action["blockingType"], "HARD");
    }
  EXPECT_EQ(done, (std::vector<std::string>{"F02-C01-R1", "F02-C01-R2", "F02-C02-R1", "F02-P01"}));
  EXPECT_EQ(vda_topic(make_robot(VdaVersion::v3_0), "order"), "uagv/v3/Acme/R2D2/order");
}

/// The base stands before the facade and looks at it, in front of it or in the building, and never in the bracket.
TEST(Vda5050, ANodeIsBeforeTheFacade) {
  Job job = make_job();
  Eigen::Matrix3d axes;  // right, up, out of a facade whose outside is -y
  axes << 1, 0, 0, 0, 0, -1, 0, 1, 0;
  for (JobItem& item : job.items) item.design_rotation = item.target_rotation = Eigen::Quaterniond(axes);
  VdaRobot robot = make_robot(VdaVersion::v3_0);
  const auto first = [&] { return json::parse(vda_order(job, robot))["nodes"][0]["nodePosition"]; };
  EXPECT_NEAR(first()["x"].get<double>(), 432100, 1e-6);
  EXPECT_NEAR(first()["y"].get<double>(), 5812300 - 1.5, 1e-6);
  EXPECT_NEAR(first()["theta"].get<double>(), kPi / 2, 1e-9);
  robot.stand_off = -2;
  EXPECT_NEAR(first()["y"].get<double>(), 5812302, 1e-6);
  EXPECT_NEAR(first()["theta"].get<double>(), -kPi / 2, 1e-9);
  // Round a corner is another place, however near the brackets are.
  job.items[1].design_rotation = Eigen::AngleAxisd(kPi / 2, Eigen::Vector3d::UnitZ()) * job.items[1].design_rotation;
  EXPECT_EQ(json::parse(vda_order(job, robot))["nodes"].size(), 4u);
  // At an inner corner both facades are done from one place, each with its own side before the robot.
  robot.stand_off = 1.5;
  job.items[1].design = job.items[0].design + Eigen::Vector3d(-1.5, -1.5, 0);
  const json nodes = json::parse(vda_order(job, robot))["nodes"];
  ASSERT_EQ(nodes.size(), 4u);
  EXPECT_NEAR(nodes[1]["nodePosition"]["x"].get<double>(), nodes[0]["nodePosition"]["x"].get<double>(), 1e-6);
  EXPECT_NEAR(nodes[1]["nodePosition"]["y"].get<double>(), nodes[0]["nodePosition"]["y"].get<double>(), 1e-6);
  EXPECT_NEAR(nodes[0]["nodePosition"]["theta"].get<double>(), kPi / 2, 1e-9);
  EXPECT_NEAR(std::abs(nodes[1]["nodePosition"]["theta"].get<double>()), kPi, 1e-9);
  PLUMBLINE_REQUIRE_DATA("robot/vda5050/3.0.0/order.schema");
  EXPECT_EQ(faults(schema_of("3.0.0", "order"), json::parse(vda_order(job, robot))), "");
}

TEST(Vda5050, WhatCannotBeOrderedIsSaid) {
  const auto fault = [](const Job& job, const VdaRobot& robot) {
    try {
      vda_order(job, robot);
    } catch (const std::runtime_error& error) {
      return std::string(error.what());
    }
    return std::string();
  };
  VdaRobot robot = make_robot(VdaVersion::v2_0);
  EXPECT_NE(fault(Job{}, robot).find("nothing to order"), std::string::npos);
  robot.serial = "R2/+";
  EXPECT_NE(fault(make_job(), robot).find("serial number is 'R2/+'"), std::string::npos);
  robot = make_robot(VdaVersion::v2_0), robot.timestamp = "yesterday";
  EXPECT_NE(fault(make_job(), robot).find("expected ISO 8601 in UTC"), std::string::npos);
}

/// A state of a robot whose actions stand as given, one letter each: w(aiting), r(unning), f(inished), x (failed).
json make_state(const Job& job, const std::string& stands, int header, const std::string& at, VdaVersion version) {
  const bool old = version == VdaVersion::v2_0;
  json state = {{"headerId", header},
                {"timestamp", at},
                {"version", old ? "2.0.0" : "3.0.0"},
                {"manufacturer", "Acme"},
                {"serialNumber", "R2D2"},
                {"orderId", job.id},
                {"orderUpdateId", 0},
                {"lastNodeId", ""},
                {"lastNodeSequenceId", 0},
                {"nodeStates", json::array()},
                {"edgeStates", json::array()},
                {"driving", false},
                {"actionStates", json::array()},
                {"operatingMode", "AUTOMATIC"},
                {"errors", json::array()}};
  state[old ? "batteryState" : "powerSupply"] = {{old ? "batteryCharge" : "stateOfCharge", 80}, {"charging", false}};
  state["safetyState"] = {{old ? "eStop" : "activeEmergencyStop", "NONE"}, {"fieldViolation", false}};
  if (!old) state["instantActionStates"] = json::array();
  for (std::size_t i = 0; i < stands.size(); ++i) {
    const char* status = stands[i] == 'w'   ? "WAITING"
                         : stands[i] == 'r' ? "RUNNING"
                         : stands[i] == 'f' ? "FINISHED"
                                            : "FAILED";
    state["actionStates"].push_back({{"actionId", vda_action_id(job, job.items[i])}, {"actionStatus", status}});
  }
  return state;
}

std::string at_second(int second) {
  char text[32];
  std::snprintf(text, sizeof text, "2026-05-02T08:00:%02dZ", second);
  return text;
}

/// Orders of single floors answer the job that they are of.
TEST(Vda5050, APartOfAJobHasItsActions) {
  Job job = make_job();
  job.items[0].floor = 1;
  const Job part = part_of(job, {2});
  EXPECT_EQ(vda_order_id(part), job.id + "-F2");
  EXPECT_EQ(json::parse(vda_order(part, make_robot(VdaVersion::v2_0)))["orderId"], job.id + "-F2");
  EXPECT_EQ(part.items.size(), 3u);
  EXPECT_EQ(vda_action_id(part, part.items[0]), vda_action_id(job, job.items[1]));
  json state = make_state(part, "fff", 3, "2026-05-02T08:00:09Z", VdaVersion::v2_0);
  state["orderId"] = vda_order_id(part);
  const ActualsT read = vda_actuals(state.dump(), job, "states.jsonl");
  EXPECT_TRUE(read.refused.empty());
  ASSERT_EQ(read.items.size(), 3u);
  EXPECT_EQ(read.items[0]->job, job.id) << "as the state knows it";
  state["orderId"] = job.id + "-other";
  EXPECT_EQ(vda_actuals(state.dump(), job, "states.jsonl").refused.size(), 1u);
  try {
    part_of(job, {7});
    FAIL() << "a floor without items";
  } catch (const std::runtime_error& error) {
    EXPECT_NE(std::string(error.what()).find("floor 7 has no item"), std::string::npos);
    EXPECT_NE(std::string(error.what()).find("1, 2"), std::string::npos);
  }
}

TEST(Vda5050, StatesBecomeReports) {
  PLUMBLINE_REQUIRE_DATA("robot/vda5050/3.0.0/state.schema");
  const Job job = make_job();
  for (const auto& [version, name] : {std::pair(VdaVersion::v2_0, "2.0.0"), std::pair(VdaVersion::v3_0, "3.0.0")}) {
    json state = make_state(job, "fxrw", 3, at_second(9), version);
    state["actionStates"][0][version == VdaVersion::v2_0 ? "resultDescription" : "actionResult"] =
        R"({"measured": [432100.001, 5812300, 8.004], "setting": [0, 0.0041, 0], "note": "ok"})";
    state["actionStates"][1][version == VdaVersion::v2_0 ? "resultDescription" : "actionResult"] = "bolt is stuck";
    EXPECT_EQ(faults(schema_of(name, "state"), state), "") << name;
    const ActualsT actuals = vda_actuals(state.dump(1), job, "states.jsonl");
    EXPECT_TRUE(actuals.refused.empty());
    ASSERT_EQ(actuals.items.size(), 2u);
    EXPECT_EQ(actuals.items[0]->item, "F02-C01-R1");
    EXPECT_EQ(actuals.items[0]->outcome, "done");
    EXPECT_EQ(actuals.items[0]->revision, 3);
    EXPECT_EQ(actuals.items[0]->by, "Acme/R2D2");
    EXPECT_EQ(actuals.items[0]->at, at_second(9));
    EXPECT_NEAR(actuals.items[0]->measured.x(), 432100.001, 1e-9);
    EXPECT_NEAR(actuals.items[0]->setting.y(), 0.0041, 1e-12);
    EXPECT_EQ(actuals.items[1]->outcome, "failed");
    EXPECT_EQ(actuals.items[1]->note, "bolt is stuck");
  }
}

/// Messages lost, doubled and reordered at random: what is reported is a part of the truth, once for each item, and all
/// of it once the last message came.
TEST(Vda5050, LostDoubleLateAndReorderedMessagesReportNothingTwiceAndNothingWrong) {
  const Job job = make_job();
  const char* way[] = {"wwww", "rwww", "fwww", "frww", "fxww", "fxrw", "fxfw", "fxfr", "fxff"};
  std::mt19937 random(5);
  for (int trial = 0; trial < 300; ++trial) {
    std::vector<std::string> messages;
    bool last = false;
    for (int i = 0; i < 9; ++i)
      for (std::size_t copies = random() % 3; copies > 0; --copies)
        messages.push_back(make_state(job, way[i], i, at_second(i), VdaVersion::v2_0).dump()), last = last || i == 8;
    for (std::size_t i = messages.size(); i > 1; --i) std::swap(messages[i - 1], messages[random() % i]);
    std::string lines;
    for (const std::string& message : messages) lines += message + "\n";
    const ActualsT actuals = vda_actuals(lines, job, "states.jsonl");
    EXPECT_TRUE(actuals.refused.empty());
    std::set<std::string> reported;
    for (const auto& actual : actuals.items) {
      EXPECT_TRUE(reported.insert(actual->item).second);
      EXPECT_EQ(actual->outcome, actual->item == "F02-C01-R2" ? "failed" : "done");
    }
    if (last) {
      EXPECT_EQ(reported.size(), 4u);
    }
  }
}

/// As `mosquitto_sub -v` writes down what it hears of several robots.
TEST(Vda5050, ALogHasItsTopicsBeforeItsMessages) {
  const Job job = make_job();
  const std::string topic = "uagv/v2/Acme/R2D2/",
                    done = make_state(job, "fw", 1, at_second(1), VdaVersion::v2_0).dump();
  const std::string log = topic + "connection {\"connectionState\": \"ONLINE\"}\n" + topic + "state " + done + "\n" +
                          topic + "visualization {\"agvPosition\": {}}\n" + topic + "order {\"orderId\": \"x\"}\n" +
                          "INFO: path obstructed\n" + topic + "secrets {}\n";
  const ActualsT actuals = vda_actuals(log, job, "log");
  ASSERT_EQ(actuals.items.size(), 1u);
  EXPECT_EQ(actuals.items[0]->outcome, "done");
  ASSERT_EQ(actuals.refused.size(), 2u);
  EXPECT_EQ(actuals.refused[0].rfind("log:5: is no state message", 0), 0u) << actuals.refused[0];
  EXPECT_EQ(actuals.refused[1].rfind("log:6: is no state message", 0), 0u) << actuals.refused[1];
}

TEST(Vda5050, MessagesThatAreWrongAreRefusedWithTheirLine) {
  const Job job = make_job();
  Job other = job;
  other.id = "job-2";
  json unknown = make_state(job, "f", 1, at_second(1), VdaVersion::v2_0), old = unknown, undated = unknown,
       strange = unknown;
  unknown["actionStates"][0]["actionId"] = "x", old["version"] = "1.1.0", undated["timestamp"] = "noon";
  strange["actionStates"][0]["resultDescription"] = R"({"measured": [1, 2]})";
  const std::string lines = "{\"no\": 1}\n[]\nnot json\n" +
                            make_state(other, "f", 1, at_second(1), VdaVersion::v2_0).dump() + "\n" + unknown.dump() +
                            "\n" + old.dump() + "\n" + undated.dump() + "\n" + strange.dump() + "\n" +
                            make_state(job, "wf", 2, at_second(2), VdaVersion::v2_0).dump() + "\n" +
                            make_state(job, "wx", 3, at_second(3), VdaVersion::v2_0).dump() + "\n";
  const ActualsT actuals = vda_actuals(lines, job, "s");
  ASSERT_EQ(actuals.items.size(), 1u);
  EXPECT_EQ(actuals.items[0]->outcome, "done");
  std::string refused;
  for (const std::string& line : actuals.refused) refused += line + "\n";
  for (const char* words :
       {"s:1: is no state message", "s:2: is no state message", "s:3: is no state message",
        "s:4: is on order 'job-2', this job is job-3", "s:5: tells of action 'x'", "s:6: is of version 1.1.0",
        "s:7: has the timestamp 'noon'", "s:8: the result of action",
        "s:10: says that action job-3-F2-0123456789ab:F02-C01-R2:3 FAILED, a message before said FINISHED"})
    EXPECT_NE(refused.find(words), std::string::npos) << words << " in\n" << refused;
}

TEST(Vda5050, KeysOfAResultThatNobodyReadsAreNamed) {
  const Job job = make_job();
  const auto read = [&](const std::string& result) {
    json state = make_state(job, "f", 1, at_second(1), VdaVersion::v2_0);
    state["actionStates"][0]["resultDescription"] = result;
    return vda_actuals(state.dump(), job, "s");
  };
  const ActualsT named = read(R"({"note": "ok", "torque": 12})");
  ASSERT_EQ(named.items.size(), 1u);
  EXPECT_EQ(named.ignored.at(0), "s: in results of actions 'torque' is not read");
  EXPECT_NE(read(R"({"mesured": [1, 2, 3]})").refused.at(0).find("has 'mesured', which is no key; 'measured' is"),
            std::string::npos);
  EXPECT_NE(read(R"({"measured": [1, 2, 3], "unit": "in"})").refused.at(0).find("lengths are in metres"),
            std::string::npos);
}

/// As actuals.json has it, by the names of its directions, which the pages show: it was refused.
TEST(Vda5050, ASettingIsReadByItsDirectionsToo) {
  const Job job = make_job();
  const auto read = [&](const std::string& result) {
    json state = make_state(job, "f", 1, at_second(1), VdaVersion::v2_0);
    state["actionStates"][0]["resultDescription"] = result;
    return vda_actuals(state.dump(), job, "s");
  };
  const ActualsT named = read(R"({"setting": {"out": 0.003, "right": 0.001, "up": 0.002}})");
  ASSERT_EQ(named.items.size(), 1u);
  EXPECT_EQ(named.items[0]->setting, Eigen::Vector3d(0.001, 0.002, 0.003));
  for (const char* wrong :
       {R"({"setting": {"right": 0.001, "up": 0.002}})", R"({"setting": {"right": 0.001, "up": 0.002, "in": 0.003}})",
        R"({"setting": {"right": "1", "up": 0.002, "out": 0.003}})"})
    EXPECT_EQ(read(wrong).refused.size(), 1u) << wrong;
  // What begins as JSON and is none is a note, and said: nobody sees otherwise that a place was measured.
  const ActualsT cut = read(R"({"measured": [1, 2)");
  ASSERT_EQ(cut.items.size(), 1u);
  ASSERT_EQ(cut.ignored.size(), 1u);
  EXPECT_NE(cut.ignored[0].find("is no JSON, and what it measured is not read"), std::string::npos) << cut.ignored[0];
}

TEST(Vda5050, OneActionByTwoRobotsIsTold) {
  const Job job = make_job();
  json other = make_state(job, "fw", 1, at_second(4), VdaVersion::v2_0);
  other["serialNumber"] = "C3PO";
  const std::string first = make_state(job, "fw", 1, at_second(3), VdaVersion::v2_0).dump();
  const ActualsT actuals = vda_actuals(first + "\n" + other.dump() + "\n" + other.dump() + "\n", job, "s");
  ASSERT_EQ(actuals.items.size(), 1u);
  EXPECT_EQ(actuals.items[0]->by, "Acme/R2D2");
  ASSERT_EQ(actuals.refused.size(), 1u) << "once";
  EXPECT_NE(actuals.refused[0].find("s:2: says that action job-3-F2-0123456789ab:F02-C01-R1:3 FINISHED by Acme/C3PO, "
                                    "and it was by Acme/R2D2: two robots had one item"),
            std::string::npos)
      << actuals.refused[0];
}

/// Bytes changed, left out and cut off at random: refused with the line or read, never an error, and never a report of
/// what the message does not hold.
TEST(Vda5050, BrokenMessagesEndNothing) {
  const Job job = make_job();
  std::mt19937 random(11);
  int refused = 0;
  for (int trial = 0; trial < 400; ++trial) {
    std::string message = make_state(job, "wwww", 1, at_second(1), VdaVersion::v2_0).dump();
    for (int i = static_cast<int>(random() % 4); i >= 0; --i) {
      const std::size_t at = random() % message.size();
      if (trial % 3 == 0)
        message[at] = static_cast<char>(random() % 256);
      else if (trial % 3 == 1)
        message.erase(at, 1 + random() % 20);
      else
        message.resize(std::max<std::size_t>(1, at));
    }
    std::replace(message.begin(), message.end(), '\n', ' ');
    const ActualsT actuals = vda_actuals(message + "\n", job, "states.jsonl");
    EXPECT_TRUE(actuals.items.empty()) << message;
    refused += !actuals.refused.empty();
  }
  EXPECT_GT(refused, 200);
}

/// Where it stands, then the first node with work; not where it stands already.
TEST(Vda5050, AnOrderBeginsWhereTheRobotStands) {
  for (const VdaVersion version : {VdaVersion::v2_0, VdaVersion::v3_0}) {
    VdaRobot robot = make_robot(version);
    const json without = json::parse(vda_order(make_job(), robot));
    robot.start = VdaPlace{"parking", "floor-1", -4, 2, 0.5};
    const json with = json::parse(vda_order(make_job(), robot));
    ASSERT_EQ(with["nodes"].size(), without["nodes"].size() + 1);
    EXPECT_EQ(with["nodes"][0]["nodeId"], "parking");
    EXPECT_EQ(with["nodes"][0]["actions"].size(), 0u);
    EXPECT_EQ(with["edges"].size(), without["edges"].size() + 1);
    for (std::size_t i = 0; i < with["nodes"].size(); ++i) EXPECT_EQ(with["nodes"][i]["sequenceId"], 2 * i);
    const std::string name = version == VdaVersion::v2_0 ? "2.0.0" : "3.0.0";
    PLUMBLINE_REQUIRE_DATA("robot/vda5050/" + name + "/order.schema");
    EXPECT_EQ(faults(schema_of(name, "order"), with), "");
    robot.start->node = without["nodes"][0]["nodeId"];
    EXPECT_EQ(json::parse(vda_order(make_job(), robot))["nodes"].size(), without["nodes"].size());
  }
}

/// What asks a robot for its state is a message of the standard, too.
TEST(Vda5050, TheQuestionForAStateIsValid) {
  struct NoLog : ExchangeLog {
    void append_sent(const std::string&) override {}
    void append_state(const std::string&) override {}
    std::vector<std::string> sent() const override { return {}; }
    std::vector<std::string> states() const override { return {}; }
  } log;
  for (const VdaVersion version : {VdaVersion::v2_0, VdaVersion::v3_0}) {
    const std::string name = version == VdaVersion::v2_0 ? "2.0.0" : "3.0.0";
    PLUMBLINE_REQUIRE_DATA("robot/vda5050/" + name + "/instantActions.schema");
    OrderExchange exchange(make_job(), make_robot(version), log);
    const auto messages = exchange.due(100, "2026-05-02T08:00:00Z");
    ASSERT_EQ(messages.size(), 1u);
    EXPECT_EQ(faults(schema_of(name, "instantActions"), json::parse(messages[0].payload)), "") << messages[0].payload;
  }
}

}  // namespace test_vda5050
}  // namespace plumbline::loop
