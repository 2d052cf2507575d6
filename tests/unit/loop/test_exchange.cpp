// An order through a broker that loses, holds back, doubles and reorders messages and goes away, by a program that is
// killed at any moment, to a robot as VDA 5050 has it: nothing lost, nothing done twice.
#include <gtest/gtest.h>
#include <unistd.h>

#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <functional>
#include <map>
#include <nlohmann/json.hpp>
#include <set>

#include "geometry/random.hpp"
#include "loop/exchange/order_exchange.hpp"

namespace plumbline::loop {
namespace test_exchange {

using json = nlohmann::ordered_json;

Job job_of(const std::string& id, int items) {
  Job job;
  job.id = id, job.revision = 1;
  for (int i = 0; i < items; ++i) {
    JobItem item;
    item.id = "b" + std::to_string(i), item.kind = "bracket", item.operation = "setBracket", item.revision = 1;
    item.floor = 1, item.design = item.target = {2.0 * i, 0, 3};
    job.items.push_back(item);
  }
  return job;
}

const VdaRobot& robot_one() {
  static const VdaRobot robot{VdaVersion::v2_0, "RobotCompany", "001", 0, "", std::nullopt};
  return robot;
}

std::string utc_of(double seconds) {
  char text[40];
  std::snprintf(text, sizeof text, "2026-05-02T%02d:%02d:%06.3fZ", static_cast<int>(seconds / 3600) % 24,
                static_cast<int>(seconds / 60) % 60, std::fmod(seconds, 60));
  return text;
}

/// What is on disk when the program is killed.
struct Disk : ExchangeLog {
  std::vector<std::string> sent_lines, state_lines;
  std::function<void()> before, after;  ///< may throw: killed there
  void append_sent(const std::string& line) override {
    if (before) before();
    sent_lines.push_back(line);
    if (after) after();
  }
  void append_state(const std::string& line) override {
    if (before) before();
    state_lines.push_back(line);
    if (after) after();
  }
  std::vector<std::string> sent() const override { return sent_lines; }
  std::vector<std::string> states() const override { return state_lines; }
};

/// Keeps one order, in memory only; takes the same order as the one that it has; refuses another while it works.
struct Robot {
  std::string order;
  std::vector<std::pair<std::string, std::string>> actions;  ///< with their states
  std::map<std::string, int> executed;                       ///< how often each was done, whatever the robot remembers
  json errors = json::array();
  long long header = 0;
  double busy_until = 0;

  bool works() const {
    return std::any_of(actions.begin(), actions.end(), [](const auto& a) { return a.second != "FINISHED"; });
  }
  void take(const MqttMessage& message, double now) {
    const json in = json::parse(message.payload);
    if (message.topic.ends_with("instantActions")) return;  // a state follows in any case
    const std::string id = in["orderId"];
    if (id == order) return;
    if (works()) {
      errors = json::array({{{"errorType", "orderError"},
                             {"errorLevel", "WARNING"},
                             {"errorReferences", {{{"referenceKey", "orderId"}, {"referenceValue", id}}}}}});
      return;
    }
    order = id, errors = json::array(), actions.clear(), busy_until = now + 1;
    for (const json& node : in["nodes"])
      for (const json& action : node["actions"]) actions.emplace_back(action["actionId"], "WAITING");
  }
  /// True if something changed.
  bool work(double now) {
    if (now < busy_until) return false;
    for (auto& [id, state] : actions) {
      if (state == "FINISHED") continue;
      if (state == "WAITING")
        state = "RUNNING";
      else
        state = "FINISHED", ++executed[id];
      busy_until = now + 0.7;
      return true;
    }
    return false;
  }
  void restart() { order.clear(), actions.clear(), header = 0, errors = json::array(); }
  std::string state(double now) {
    json out{{"headerId", ++header},         {"timestamp", utc_of(now)},
             {"version", "2.0.0"},           {"manufacturer", "RobotCompany"},
             {"serialNumber", "001"},        {"orderId", order},
             {"orderUpdateId", 0},           {"nodeStates", json::array()},
             {"edgeStates", json::array()},  {"errors", errors},
             {"actionStates", json::array()}};
    for (const auto& [id, state] : actions) out["actionStates"].push_back({{"actionId", id}, {"actionStatus", state}});
    return out.dump();
  }
};

struct Weather {
  double lost = 0, twice = 0, late = 0, away = 0, killed = 0, restarted = 0;
};

struct OnTheWay {
  double arrives = 0, expires = 0;
  bool to_robot = false;
  MqttMessage message;
};

/// Killed here.
struct Kill {};

class World {
 public:
  World(const Weather& weather, std::uint64_t seed) : weather_(weather), luck_(seed, "weather") {
    const auto perhaps = [this] {
      if (luck_.uniform() < weather_.killed) throw Kill{};
    };
    disk.before = disk.after = perhaps;
  }

  /// Runs until the exchange of this job is over; its status.
  ExchangeStatus run(const Job& job, double longest) {
    const ExchangeTimes times{3, 20, 8};
    std::unique_ptr<OrderExchange> exchange;
    for (const double end = now + longest; now < end; now += 0.1) {
      try {
        if (!exchange) exchange = std::make_unique<OrderExchange>(job, robot_one(), disk, times);
        step(*exchange);
        if (exchange->is_over()) {
          reason = exchange->reason();
          return exchange->status();
        }
      } catch (const Kill&) {
        exchange.reset(), ++kills;
        now += 4 * luck_.uniform();
      }
    }
    return exchange ? exchange->status() : ExchangeStatus::asking;
  }

  Robot robot;
  Disk disk;
  double now = 100;
  std::string reason;
  int kills = 0, lost = 0, doubled = 0, late = 0, outages = 0;  ///< faults that happened

 private:
  void send(bool to_robot, MqttMessage message) {
    if (now < away_until_) return;  // nobody takes it
    const int copies = luck_.uniform() < weather_.lost ? 0 : luck_.uniform() < weather_.twice ? 2 : 1;
    lost += copies == 0, doubled += copies == 2;
    for (int i = 0; i < copies; ++i) {
      const bool is_late = luck_.uniform() < weather_.late;
      late += is_late;
      const double delay = (is_late ? 12 : 0.2) * luck_.uniform();
      on_the_way_.push_back({now + delay, message.expires > 0 ? now + message.expires : 1e300, to_robot, message});
    }
  }

  void step(OrderExchange& exchange) {
    if (luck_.uniform() < weather_.away) away_until_ = now + 10 * luck_.uniform(), ++outages;
    if (luck_.uniform() < weather_.restarted) robot.restart();
    const bool changed = robot.work(now);
    if (changed || now >= next_state_) send(false, {exchange.state_topic(), robot.state(now)}), next_state_ = now + 5;
    std::vector<OnTheWay> here;
    for (std::size_t i = 0; i < on_the_way_.size();)
      if (on_the_way_[i].arrives <= now)
        here.push_back(on_the_way_[i]), on_the_way_.erase(on_the_way_.begin() + static_cast<std::ptrdiff_t>(i));
      else
        ++i;
    for (const OnTheWay& message : here) {
      if (message.expires <= now) continue;
      if (message.to_robot)
        robot.take(message.message, now), send(false, {exchange.state_topic(), robot.state(now)});
      else
        exchange.on_state(message.message.payload, now);
    }
    for (const MqttMessage& message : exchange.due(now, utc_of(now))) {
      if (luck_.uniform() < weather_.killed) throw Kill{};
      send(true, message);
      if (luck_.uniform() < weather_.killed) throw Kill{};
    }
  }

  Weather weather_;
  Random luck_;
  double away_until_ = 0, next_state_ = 0;
  std::vector<OnTheWay> on_the_way_;
};

/// Reports that the files give, by item.
std::map<std::string, int> reports_of(const World& world, const Job& job) {
  std::string lines;
  for (const std::string& line : world.disk.state_lines)
    if (json::parse(line)["orderId"] == job.id) lines += line + "\n";
  std::map<std::string, int> reports;
  for (const auto& actual : vda_actuals(lines, job, "states.jsonl").items) ++reports[actual->item];
  return reports;
}

TEST(Exchange, AnOrderGoesToItsEndOnAQuietDay) {
  World world({}, 1);
  const Job job = job_of("job-a", 4);
  EXPECT_EQ(world.run(job, 100), ExchangeStatus::finished);
  EXPECT_EQ(world.disk.sent_lines.size(), 1u);
  EXPECT_EQ(reports_of(world, job).size(), 4u);
  // Asked again, it is known to be done, and nothing is sent.
  EXPECT_EQ(world.run(job, 100), ExchangeStatus::finished);
  EXPECT_EQ(world.disk.sent_lines.size(), 1u);
}

TEST(Exchange, NothingIsLostAndNothingIsDoneTwiceInAnyWeather) {
  const int seeds = std::getenv("PLUMBLINE_LONG") ? 2500 : 250;
  int kills = 0, sendings = 0, lost = 0, doubled = 0, late = 0, outages = 0;
  for (int seed = 1; seed <= seeds; ++seed) {
    World world({0.2, 0.2, 0.3, 0.003, 0.03, 0}, static_cast<std::uint64_t>(seed));
    for (const char* id : {"job-a", "job-b", "job-c"}) {
      const Job job = job_of(id, 3);
      ASSERT_EQ(world.run(job, 2000), ExchangeStatus::finished) << seed << " " << id << " " << world.reason;
      const auto reports = reports_of(world, job);
      EXPECT_EQ(reports.size(), 3u) << seed;
      for (const auto& [item, n] : reports) EXPECT_EQ(n, 1) << seed << " " << item;
    }
    EXPECT_EQ(world.robot.executed.size(), 9u);
    for (const auto& [action, n] : world.robot.executed) EXPECT_EQ(n, 1) << seed << " " << action;
    lost += world.lost, doubled += world.doubled, late += world.late, outages += world.outages;
    kills += world.kills, sendings += static_cast<int>(world.disk.sent_lines.size());
  }
  std::printf("%d jobs: %d messages lost, %d doubled, %d late, %d times without a broker, %d times killed\n", 3 * seeds,
              lost, doubled, late, outages, kills);
  for (const int faults : {lost, doubled, late, outages}) EXPECT_GT(faults, 200);
  EXPECT_GT(kills, 2 * seeds) << "the program was hardly killed";
  EXPECT_GT(sendings, 3 * seeds + seeds / 4) << "hardly an order was lost";
}

/// It forgets its order. Nobody may send it again, and what is not known is said.
TEST(Exchange, ARobotThatIsStartedAgainIsNeverAskedTwice) {
  std::map<ExchangeStatus, int> ends;
  for (int seed = 1; seed <= 200; ++seed) {
    World world({0.1, 0, 0, 0, 0.01, 0.01}, static_cast<std::uint64_t>(1000 + seed));
    const Job job = job_of("job-a", 3);
    ++ends[world.run(job, 600)];
    for (const auto& [action, n] : world.robot.executed) EXPECT_EQ(n, 1) << seed << " " << action;
  }
  EXPECT_GT(ends[ExchangeStatus::finished], 20);
  EXPECT_GT(ends[ExchangeStatus::unknown], 20);
  EXPECT_EQ(ends[ExchangeStatus::finished] + ends[ExchangeStatus::unknown], 200);
}

TEST(Exchange, ARobotAtAnotherOrderIsWaitedForAndARefusalIsSaid) {
  World world({}, 5);
  world.robot.order = "somebody-elses", world.robot.actions = {{"x", "RUNNING"}}, world.robot.busy_until = 130;
  Disk disk;
  OrderExchange exchange(job_of("job-a", 1), robot_one(), disk);
  EXPECT_EQ(exchange.due(100, utc_of(100)).at(0).topic, "uagv/v2/RobotCompany/001/instantActions");
  exchange.on_state(world.robot.state(101), 101);
  EXPECT_EQ(exchange.status(), ExchangeStatus::busy);
  EXPECT_TRUE(disk.sent_lines.empty());
  world.robot.actions[0].second = "FINISHED";
  exchange.on_state(world.robot.state(131), 131);
  EXPECT_EQ(exchange.due(131, utc_of(131)).at(0).topic, "uagv/v2/RobotCompany/001/order");
  world.robot.errors = {{{"errorType", "validationError"},
                         {"errorReferences", {{{"referenceKey", "orderId"}, {"referenceValue", "job-a"}}}}}};
  exchange.on_state(world.robot.state(132), 132);
  EXPECT_EQ(exchange.status(), ExchangeStatus::rejected);
  EXPECT_NE(exchange.reason().find("validationError"), std::string::npos);
  EXPECT_TRUE(exchange.due(200, utc_of(200)).empty());
}

/// The robot is off, and the broker has kept what it said last night.
TEST(Exchange, WhatABrokerHasKeptIsNoAnswer) {
  World world({}, 5);
  Disk disk;
  world.robot.header = 500;
  const std::string kept = world.robot.state(50);
  OrderExchange exchange(job_of("job-a", 1), robot_one(), disk);
  exchange.due(100, utc_of(100));
  exchange.on_state(kept, 100.1, true);
  for (double now = 101; now < 160; now += 1)
    for (const MqttMessage& message : exchange.due(now, utc_of(now)))
      EXPECT_TRUE(message.topic.ends_with("instantActions")) << now;
  EXPECT_TRUE(disk.sent_lines.empty());
  // Nor is what comes before the question.
  OrderExchange early(job_of("job-a", 1), robot_one(), disk);
  early.on_state(world.robot.state(99), 100);
  EXPECT_TRUE(early.due(100, utc_of(100)).at(0).topic.ends_with("instantActions"));
  world.robot.restart();
  exchange.on_state(world.robot.state(161), 161);
  EXPECT_TRUE(exchange.due(161, utc_of(161)).at(0).topic.ends_with("order"));
  EXPECT_NE(exchange.status(), ExchangeStatus::unknown);
}

/// It was two hours ahead and busy; then somebody sets its clock.
TEST(Exchange, ARobotWhoseClockIsPutBackIsHeardByItsNumbers) {
  World world({}, 5);
  Disk disk;
  OrderExchange exchange(job_of("job-a", 1), robot_one(), disk);
  exchange.due(100, utc_of(100));
  world.robot.order = "somebody-elses", world.robot.actions = {{"x", "RUNNING"}};
  exchange.on_state(world.robot.state(7300), 100);
  world.robot.order.clear(), world.robot.actions.clear();
  EXPECT_EQ(exchange.clock_doubt(), "");
  exchange.on_state(world.robot.state(101), 101);
  EXPECT_EQ(exchange.clock_doubt(), "") << "one that is late";
  exchange.on_state(world.robot.state(101.5), 101.5);
  EXPECT_EQ(exchange.status(), ExchangeStatus::busy);
  EXPECT_NE(exchange.clock_doubt().find("dated up to 120 min before the last one that it sent"), std::string::npos)
      << exchange.clock_doubt();
  bool is_sent = false;
  for (double now = 102; now < 140 && !is_sent; now += 1)
    for (const MqttMessage& message : exchange.due(now, utc_of(now)))
      if (message.topic.ends_with("order"))
        is_sent = true;
      else
        exchange.on_state(world.robot.state(now), now);
  EXPECT_TRUE(is_sent);
  EXPECT_EQ(exchange.clock_doubt(), "");
}

TEST(Exchange, AJobIsNotSentAfterItsTime) {
  World world({}, 6);
  world.robot.order = "somebody-elses", world.robot.actions = {{"x", "RUNNING"}};
  Job job = job_of("job-a", 1);
  job.valid_until = "2026-05-02T00:02:00Z";
  const auto sent = [&](double free_at, Disk& disk, OrderExchange& exchange) {
    exchange.due(100, utc_of(100));
    exchange.on_state(world.robot.state(101), 101);
    Robot done = world.robot;
    done.actions[0].second = "FINISHED";
    exchange.on_state(done.state(free_at), free_at);
    exchange.due(free_at, utc_of(free_at));
    return disk.sent_lines.size();
  };
  Disk early, late;
  OrderExchange in_time(job, robot_one(), early), too_late(job, robot_one(), late);
  EXPECT_EQ(sent(119, early, in_time), 1u);
  EXPECT_EQ(sent(121, late, too_late), 0u);
  EXPECT_EQ(too_late.status(), ExchangeStatus::rejected);
  EXPECT_NE(too_late.reason().find("was valid until 2026-05-02T00:02:00Z"), std::string::npos) << too_late.reason();
  // One that was sent in time, and lost, is not sent again.
  in_time.due(124, utc_of(124));
  in_time.on_state(world.robot.state(124), 124);
  Robot idle = world.robot;
  idle.actions[0].second = "FINISHED";
  in_time.on_state(idle.state(125), 125);
  EXPECT_TRUE(in_time.due(125, utc_of(125)).empty());
  EXPECT_EQ(early.sent_lines.size(), 1u);
  EXPECT_EQ(in_time.status(), ExchangeStatus::unknown);
}

/// The file of the round before, given once more: the robot would set what it has set by a later plan.
TEST(Exchange, AJobOfAnOlderRevisionThanOneThatWasSentIsNotSent) {
  Disk disk;
  Robot robot;
  Job old = job_of("job-1-a", 1), next = job_of("job-2-b", 1);
  next.revision = 2;
  OrderExchange newer(next, robot_one(), disk);
  newer.due(100, utc_of(100));
  newer.on_state(robot.state(101), 101);
  ASSERT_EQ(newer.due(102, utc_of(102)).size(), 1u);
  OrderExchange exchange(old, robot_one(), disk);
  EXPECT_EQ(exchange.status(), ExchangeStatus::rejected);
  EXPECT_NE(exchange.reason().find("job job-1-a is revision 1, revision 2 is out: fetch that one"), std::string::npos)
      << exchange.reason();
  exchange.on_state(robot.state(200), 200);
  EXPECT_TRUE(exchange.due(200, utc_of(200)).empty());
  EXPECT_EQ(disk.sent_lines.size(), 1u);
  // Another job of the same plan, and the same one again.
  EXPECT_FALSE(OrderExchange(next, robot_one(), disk).is_over());
  Job beside = job_of("job-2-c", 1);
  beside.revision = 2;
  EXPECT_FALSE(OrderExchange(beside, robot_one(), disk).is_over());
}

/// A state that refuses two orders refuses ours, whichever stands last.
TEST(Exchange, EveryRefusalCounts) {
  for (const bool last : {true, false}) {
    Disk disk;
    OrderExchange exchange(job_of("job-a", 1), robot_one(), disk);
    Robot robot;
    exchange.due(100, utc_of(100));
    exchange.on_state(robot.state(101), 101);
    ASSERT_EQ(exchange.due(102, utc_of(102)).size(), 1u);
    const auto refusal = [](const std::string& id, const std::string& why) {
      return json{{"errorType", "validationError"},
                  {"errorLevel", "WARNING"},
                  {"errorDescription", why},
                  {"errorReferences", {{{"referenceKey", "orderId"}, {"referenceValue", id}}}}};
    };
    robot.errors = json::array({refusal("job-a", "no such map"), refusal("job-a", "no such tool")});
    robot.errors.insert(last ? robot.errors.end() : robot.errors.begin(), refusal("job-b", "of another"));
    exchange.on_state(robot.state(103), 103);
    EXPECT_EQ(exchange.status(), ExchangeStatus::rejected);
    EXPECT_EQ(exchange.reason(),
              "the robot refuses the order: validationError: no such map; validationError: no such tool");
  }
}

TEST(Exchange, WhatFailedIsNamed) {
  Disk disk;
  OrderExchange exchange(job_of("job-a", 2), robot_one(), disk);
  Robot robot;
  exchange.due(100, utc_of(100));
  exchange.on_state(robot.state(101), 101);
  for (const MqttMessage& message : exchange.due(102, utc_of(102))) robot.take(message, 102);
  ASSERT_EQ(robot.actions.size(), 2u);
  robot.actions[0].second = "FINISHED", robot.actions[1].second = "FAILED";
  exchange.on_state(robot.state(103), 103);
  EXPECT_EQ(exchange.status(), ExchangeStatus::finished);
  ASSERT_EQ(exchange.failed().size(), 1u);
  EXPECT_NE(robot.actions[1].first.find(exchange.failed()[0]), std::string::npos) << exchange.failed()[0];
}

TEST(Exchange, WhatIsNoStateOfThisRobotChangesNothing) {
  Disk disk;
  OrderExchange exchange(job_of("job-a", 1), robot_one(), disk);
  Robot robot;
  json other = json::parse(robot.state(101));
  other["serialNumber"] = "002";
  for (const std::string& text : {std::string("nonsense"), std::string("[]"), std::string("{}"), other.dump()})
    exchange.on_state(text, 101);
  EXPECT_EQ(exchange.due(102, utc_of(102)).at(0).topic, "uagv/v2/RobotCompany/001/instantActions");
}

TEST(ExchangeFolder, LinesOutliveAKillAndOneProgramWorksAtATime) {
  const std::filesystem::path folder =
      std::filesystem::temp_directory_path() / ("plumbline_exchange_" + std::to_string(getpid()));
  std::filesystem::remove_all(folder);
  {
    ExchangeFolder disk(folder);
    disk.append_sent("{\"a\":1}"), disk.append_state("{\"b\":2}");
    EXPECT_THROW(ExchangeFolder second(folder), std::runtime_error);
  }
  std::ofstream(folder / "states.jsonl", std::ios::app) << "{\"torn\":";
  ExchangeFolder disk(folder);
  EXPECT_EQ(disk.states(), std::vector<std::string>{"{\"b\":2}"});
  disk.append_state("{\"c\":3}");
  EXPECT_EQ(disk.states(), (std::vector<std::string>{"{\"b\":2}", "{\"c\":3}"}));
  std::filesystem::remove_all(folder);
}

/// Two robots, a folder each: what one was asked for is not asked of the other, in a part of the job neither.
TEST(ExchangeFolder, WhatOneRobotHasNoOtherIsGiven) {
  const std::filesystem::path folder =
      std::filesystem::temp_directory_path() / ("plumbline_given_" + std::to_string(getpid()));
  std::filesystem::remove_all(folder);
  std::filesystem::create_directories(folder);
  const std::string given = folder / "job.json.given.jsonl";
  Job job = job_of("job-a", 4);
  job.items[2].floor = job.items[3].floor = 2;
  const VdaRobot two{VdaVersion::v2_0, "RobotCompany", "002", 0, "", std::nullopt};
  ExchangeFolder first(folder / "001", given), second(folder / "002", given);
  Robot robot;
  OrderExchange lower(part_of(job, {1}), robot_one(), first);
  lower.due(100, utc_of(100)), lower.on_state(robot.state(101), 101);
  // Nothing is given before it is sent.
  EXPECT_EQ(OrderExchange(job, two, second).status(), ExchangeStatus::asking);
  EXPECT_TRUE(lower.due(101, utc_of(101)).at(0).topic.ends_with("order"));
  OrderExchange whole(job, two, second);
  EXPECT_EQ(whole.status(), ExchangeStatus::rejected);
  EXPECT_EQ(whole.reason().substr(0, whole.reason().find(" (")), "b0, b1 were given to RobotCompany/001");
  EXPECT_NE(whole.reason().find("--floor 1, --floor 2"), std::string::npos);
  EXPECT_EQ(OrderExchange(part_of(job, {2}), two, second).status(), ExchangeStatus::asking);
  // The same robot neither, with other floors than before: that is another orderId, which it would do again.
  for (const Job& other : {job, part_of(job, {1, 2})}) {
    const OrderExchange again(other, robot_one(), first);
    EXPECT_EQ(again.status(), ExchangeStatus::rejected) << vda_order_id(other);
    EXPECT_EQ(again.reason().substr(0, again.reason().find(" (")),
              "b0, b1 were given to RobotCompany/001 itself, in order job-a-F1");
  }
  EXPECT_EQ(OrderExchange(part_of(job, {2}), robot_one(), first).status(), ExchangeStatus::asking);
  // It goes on where it was, and another revision of an item is other work.
  EXPECT_EQ(OrderExchange(part_of(job, {1}), robot_one(), first).status(), ExchangeStatus::asking);
  for (JobItem& item : job.items) item.revision = 2;
  EXPECT_EQ(OrderExchange(job, two, second).status(), ExchangeStatus::asking);
  std::ofstream(given, std::ios::app) << "nonsense\n";
  EXPECT_THROW(OrderExchange(job, two, second), std::runtime_error);
  std::filesystem::remove_all(folder);
}

}  // namespace test_exchange
}  // namespace plumbline::loop
