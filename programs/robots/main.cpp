// plumbline-robots: a job to one robot of VDA 5050, through a broker, to its end. What the robot said lies in the
// folder's states.jsonl afterwards, for read.reports. May be killed and started again at any moment.
#include <fmt/core.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <chrono>
#include <csignal>
#include <cstdio>
#include <ctime>
#include <exception>
#include <filesystem>
#include <fstream>
#include <iterator>

#include "loop/exchange/order_exchange.hpp"
#include "loop/exchange/rounds_beside.hpp"
#include "loop/job/job.hpp"
#include "loop/job/signature.hpp"
#include "mqtt_client.hpp"

namespace {

using namespace plumbline::loop;

volatile std::sig_atomic_t stopped = 0;

struct Arguments {
  std::string job, signature, public_key, robot, folder, given, version = "2.0.0", password_file;
  std::vector<int> floors;  ///< of this robot; none: all
  double stand_off = VdaRobot().stand_off;
  BrokerOptions broker;
  double longest = 0;
};

double seconds_now() {
  return std::chrono::duration<double>(std::chrono::system_clock::now().time_since_epoch()).count();
}

std::string utc_now() {
  const double now = seconds_now();
  const auto whole = static_cast<std::time_t>(now);
  std::tm parts{};
  gmtime_r(&whole, &parts);
  char date[40];
  std::strftime(date, sizeof date, "%Y-%m-%dT%H:%M:%S", &parts);
  return fmt::format("{}.{:03}Z", date, static_cast<int>(1e3 * (now - static_cast<double>(whole))));
}

std::string content_of(const std::string& path) {
  std::ifstream stream(path, std::ios::binary);
  if (!stream) throw std::runtime_error("cannot read " + path);
  return {std::istreambuf_iterator<char>(stream), {}};
}

/// The job, signed as it must be.
Job job_to_do(const Arguments& arguments) {
  const std::string text = content_of(arguments.job);
  if (!arguments.public_key.empty()) {
    const std::string signature = arguments.signature.empty() ? arguments.job + ".sig" : arguments.signature;
    if (const std::string fault = signature_fault(text, content_of(signature), content_of(arguments.public_key));
        !fault.empty())
      throw std::runtime_error(arguments.job + ": " + fault);
  }
  try {
    return read_job(text);
  } catch (const std::runtime_error& error) {
    throw std::runtime_error(arguments.job + ": " + error.what());
  }
}

/// What began within its time is followed to its end, however late; what did not is not begun.
/// Empty: its time is right.
std::string time_objection(const Job& job, const ExchangeLog& log) {
  const std::vector<std::string> sent = log.sent();
  const bool begun = std::any_of(sent.begin(), sent.end(), [&](const std::string& line) {
    return line.find("\"orderId\":\"" + vda_order_id(job) + "\"") != std::string::npos;
  });
  const auto objections = job_objections(job, 0, begun ? "" : utc_now(), job.basis);
  return objections.empty() ? "" : objections[0];
}

VdaRobot robot_of(const Arguments& arguments) {
  const auto slash = arguments.robot.find('/');
  if (slash == std::string::npos)
    throw std::runtime_error("--robot is '" + arguments.robot + "'; expected MANUFACTURER/SERIAL-NUMBER");
  VdaRobot robot;
  robot.version = arguments.version == "2.0.0" ? VdaVersion::v2_0 : VdaVersion::v3_0;
  robot.stand_off = arguments.stand_off;
  robot.manufacturer = arguments.robot.substr(0, slash), robot.serial = arguments.robot.substr(slash + 1);
  return robot;
}

void say(const std::string& line) {
  std::printf("%s %s\n", utc_now().c_str(), line.c_str());
  std::fflush(stdout);
}

int carry_out(const Arguments& arguments) {
  const Job job = part_of(job_to_do(arguments), {arguments.floors.begin(), arguments.floors.end()});
  if (arguments.public_key.empty()) say("who made this job is not checked: --public-key checks its signature");
  const std::string round = std::filesystem::absolute(arguments.job).parent_path().string();
  ExchangeFolder log(arguments.folder, arguments.given.empty() ? arguments.job + ".given.jsonl" : arguments.given,
                     round);
  if (const std::string objection = time_objection(job, log); !objection.empty()) {
    say(arguments.job + ": " + objection);
    return 3;
  }
  OrderExchange exchange(job, robot_of(arguments), log);
  if (const std::filesystem::path later = later_round(round); !later.empty() && !exchange.is_over())
    say(later.string() +
        " went on from the round of this job: what it recalled the robot does all the same; stop it "
        "there, or measure");
  MqttClient client(arguments.broker);
  std::exception_ptr trouble;  // the message comes through a C library, which no exception may pass
  client.on_message = [&](const std::string&, const std::string& payload, bool is_kept) {
    try {
      exchange.on_state(payload, seconds_now(), is_kept);
    } catch (...) {
      trouble = std::current_exception();
    }
  };
  client.on_connect = [&] { exchange.on_connect(); };
  client.subscribe(exchange.state_topic());
  std::string said, clock_said;
  const double start = seconds_now();
  while (!exchange.is_over() && !stopped && (arguments.longest <= 0 || seconds_now() - start < arguments.longest)) {
    client.poll(0.2);
    if (trouble) std::rethrow_exception(trouble);
    if (client.is_connected())
      for (const MqttMessage& message : exchange.due(seconds_now(), utc_now())) client.publish(message);
    const std::string line = !client.is_connected() && !client.trouble().empty()
                                 ? client.trouble()
                                 : std::string(name_of(exchange.status())) + " " + exchange.progress();
    if (line != said) say(said = line);
    if (const std::string doubt = exchange.clock_doubt(); clock_said.empty() && !doubt.empty()) say(clock_said = doubt);
  }
  if (exchange.status() == ExchangeStatus::finished) {
    say("job " + job.id + " is at its end: " + exchange.progress() + "; " + arguments.folder + "/states.jsonl and " +
        arguments.job + " go into the next round");
    if (exchange.failed().empty()) return 0;
    std::string items;
    for (const std::string& id : exchange.failed()) items += (items.empty() ? "" : ", ") + id;
    say("the robot FAILED on " + items + ": see to why; the next round plans them again");
    return 4;
  }
  const std::string clock = exchange.clock_doubt();
  say(exchange.is_over() ? exchange.reason()
                         : "job " + job.id + " is not at its end (" + name_of(exchange.status()) +
                               (clock.empty() ? "" : "; " + clock) + "): start again with the same words to go on");
  return stopped ? 130 : 3;
}

}  // namespace

int main(int argc, char** argv) {
  Arguments arguments;
  CLI::App app{
      "Carries a job to a robot of VDA 5050 through an MQTT broker, and what it says back. Exit code 0: all was done, "
      "4: "
      "the robot failed on something, 3: a person is needed, or it is not at its end, 1: an error, 2: these words are "
      "wrong"};
  app.add_option("--job", arguments.job, "job.json of write.job")->required();
  app.add_option("--robot", arguments.robot, "MANUFACTURER/SERIAL-NUMBER, as the robot names itself")->required();
  app.add_option("--folder", arguments.folder, "sent.jsonl and states.jsonl of this robot; the same each time")
      ->required();
  app.add_option("--floor", arguments.floors, "items of this floor only, again for each of several; without: all")
      ->check(CLI::Range(0, 1000));
  app.add_option("--given", arguments.given,
                 "which robot has which items, for all robots of a site; else JOB.given.jsonl");
  app.add_option("--stand-off", arguments.stand_off,
                 "of the robot's base from the items, outward of the facade [m]; below 0: from inside")
      ->check(CLI::Range(-20.0, 20.0))
      ->capture_default_str();
  app.add_option("--version", arguments.version, "of VDA 5050")->check(CLI::IsMember({"2.0.0", "3.0.0"}));
  app.add_option("--public-key", arguments.public_key, "Ed25519 in PEM: the job must be signed with its private half");
  app.add_option("--signature", arguments.signature, "of the job; else JOB.sig");
  app.add_option("--host", arguments.broker.host, "of the broker; without --ca only this machine's own addresses");
  app.add_option("--port", arguments.broker.port, "of the broker");
  app.add_option("--client-id", arguments.broker.id, "at the broker; else one of its own");
  app.add_option("--user", arguments.broker.user, "at the broker");
  app.add_option("--password-file", arguments.password_file, "file whose first line is the password");
  app.add_option("--ca", arguments.broker.ca_file,
                 "certificates of the authorities that the broker's is checked by: TLS");
  app.add_option("--certificate", arguments.broker.certificate, "of this client, where the broker asks for one");
  app.add_option("--key", arguments.broker.key, "of that certificate");
  app.add_option("--longest", arguments.longest, "stop after so many seconds; 0: never");
  try {
    app.parse(argc, argv);
  } catch (const CLI::ParseError& error) {
    return app.exit(error) == 0 ? 0 : 2;  // as of plumbline: the command is wrong
  }
  std::signal(SIGINT, [](int) { stopped = 1; });
  std::signal(SIGTERM, [](int) { stopped = 1; });
  try {
    if (!arguments.password_file.empty()) {
      arguments.broker.password = content_of(arguments.password_file);
      arguments.broker.password.resize(
          std::min(arguments.broker.password.find_first_of("\r\n"), arguments.broker.password.size()));
    }
    return carry_out(arguments);
  } catch (const std::exception& error) {
    std::fprintf(stderr, "plumbline-robots: %s\n", error.what());
    return 1;
  }
}
