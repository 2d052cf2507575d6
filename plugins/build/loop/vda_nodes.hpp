// write.vda5050, read.vda5050: jobs as orders to mobile robots, their states as reports.
#pragma once

#include "artifacts/actuals.hpp"
#include "artifacts/file.hpp"
#include "artifacts/transform.hpp"
#include "plumbline/node.hpp"

namespace plumbline::loop {

struct WriteVda5050 : Node {
  static constexpr Info info{"write.vda5050", "", 2, "A job as an order of VDA 5050, for the topic of one robot"};
  In<File> job{"job", "job.json"};
  Param<std::string> version{"version", "2.0.0", one_of("2.0.0", "3.0.0"), "of the standard that the robot speaks"};
  Param<std::string> manufacturer{"manufacturer", "", "of the robot, as it names itself: part of its topics"};
  Param<std::string> serial_number{"serial_number", "", "of the robot, likewise"};
  Param<std::string> timestamp{"timestamp", "", "of the message, ISO 8601 in UTC, such as 2026-05-02T08:00:00Z"};
  Param<int64_t> header_id{"header_id", 0, between(0, 1000000000), "number of the message on its topic"};
  Param<double> stand_off{"stand_off", 1.5, "m", between(-20, 20),
                          "of the robot's base from the items, outward of the facade; below 0: from inside"};
  Out<File> order{"order", "order.json"};
  Out<File> topic{"topic", "topic.txt: where it is to be published"};
  void run(Context& context) override;
};

struct ReadVda5050 : Node {
  static constexpr Info info{"read.vda5050", "", 3, "State messages of robots as reports on the items of a job"};
  In<File> job{"job", "job.json that was ordered"};
  In<File> states{"states", "state messages of VDA 5050, one in each line, in any order, as often as they came"};
  Optional<Transform> frames{"frames", frame("to=building,from=?S"),
                             "what the survey was moved by into the building's frame, for a job in the survey's; "
                             "without: they share one"};
  Param<std::string> frame_name{"frame", "building", one_of("building"), "frame of its places"};
  Out<Actuals> actuals{"actuals", frame("frame=building"), "the reports, each item once"};
  void run(Context& context) override;
};

}  // namespace plumbline::loop
