// update.state and release.state: reports in, verified and released items out.
#pragma once

#include "artifacts/actuals.hpp"
#include "artifacts/file.hpp"
#include "artifacts/installation_plan.hpp"
#include "artifacts/loop_state.hpp"
#include "loop/state/machine.hpp"
#include "plumbline/node.hpp"

namespace plumbline::loop {

struct UpdateState : Node {
  static constexpr Info info{"update.state", "", 9,
                             "Takes what robots and people report into the state of brackets and panels"};
  Optional<LoopState> before{"state", frame("frame=?F"),
                             "the state of the round before; without: nothing was done yet"};
  Optional<Actuals> reports{"actuals", frame("frame=?F"), "reports since then"};
  Param<std::vector<std::string>> moved_control{
      "moved_control", std::vector<std::string>{},
      "control points that moved since work was released (compare_epochs names them): all of it becomes stale"};
  Param<std::vector<std::string>> accept{
      "accept", std::vector<std::string>{},
      "what a person has looked at after which round, as next.txt asks for it: 'F01-C02-R1@4' is planned again, a "
      "panel "
      "was seen hanging ('F01-P02 hangs@4' where a report says that it does not); 'control of floor 3@4': its next "
      "measurement is the reference. Of another round than the state's last one nothing is accepted"};
  Param<std::vector<std::string>> removed{
      "removed", std::vector<std::string>{},
      "panels that somebody took down, or found not hanging, after which round, as next.txt asks for it: "
      "'F01-P02@4' is planned again"};
  Param<std::string> now{"now", "",
                         "when this round is, ISO 8601 with zone: reports that are dated later are refused; empty: not "
                         "said"};
  Param<std::string> by{"by", "",
                        "who says what accept, removed and moved_control say: the journal has it; empty: 'a person'"};
  Out<LoopState> after{"state", frame("frame=?F"), "the state with these reports"};
  void run(Context& context) override;
};

struct ReleaseState : Node {
  static constexpr Info info{"release.state", "", 10,
                             "Verifies by a new plan what was done, and releases what is GO and whose turn it is"};
  In<LoopState> before{"state", frame("frame=?F"), "the state with all reports"};
  In<InstallationPlan> plan{"plan", frame("frame=?F"), "the plan on the measurement made since, with this state"};
  Param<int64_t> most_reworks{"most_reworks", 3, between(0, 100),
                              "how often an item is done again before it is given up"};
  Param<double> setting_tolerance{"setting_tolerance", 0.003, "m", between(1e-5, 0.1),
                                  "of a bracket against where it was to be set, each direction"};
  Param<std::string> measured_at{
      "measured_at", "",
      "when the measurement under the plan began, ISO 8601 with zone: what was reported as done "
      "later, or without a date, is not judged by it; empty: not said"};
  Param<double> verified{"verified", 0.95, "1", between(0.5, 0.9999),
                         "least probability of a hanging panel that is verified, and of 1 - p for its rework"};
  Param<std::string> released_at{"released_at", "",
                                 "when, ISO 8601 with a zone: reports that are older are refused; empty: not said"};
  Param<std::string> valid_until{"valid_until", "",
                                 "until when robots may take what is released, ISO 8601 with a zone: refused if that "
                                 "is over at released_at; empty: no end"};
  Out<LoopState> after{"state", frame("frame=?F"), "the state of this round"};
  Out<File> journal{"journal", "journal.jsonl: every change, with the hash of the line before"};
  Out<File> file{"file", "state.json: what the next round of a site reads (read.state)"};
  Out<File> next{"next", "next.txt: what to do next, by floor"};
  void run(Context& context) override;
};

}  // namespace plumbline::loop
