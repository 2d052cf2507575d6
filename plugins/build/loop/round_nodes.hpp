// read.state, read.reports: what a site's round begins with.
#pragma once

#include "artifacts/actuals.hpp"
#include "artifacts/loop_state.hpp"
#include "artifacts/transform.hpp"
#include "plumbline/node.hpp"

namespace plumbline::loop {

struct ReadState : Node {
  static constexpr Info info{"read.state", "", 1, "The state that the round before left in its state.json"};
  Param<FilePath> file{"file", FilePath{}, "state.json of the round before"};
  Param<bool> first{"first", false,
                    "this is the first round: nothing was set or hung yet. Without it a round that forgot its state "
                    "would plan what hangs already"};
  Param<std::string> frame_name{"frame", "building", one_of("building"), "frame of its places"};
  Out<LoopState> state{"state", frame("frame=building"), "the state"};
  void run(Context& context) override;
};

struct ReadReports : Node {
  static constexpr Info info{"read.reports", "", 5,
                             "What robots and people report since the last round, out of as many files as there are"};
  Optional<Transform> frames{"frames", frame("to=building,from=?S"),
                             "what the survey was moved by into the building's frame: staked points, and what answers "
                             "a job in the survey's frame, are there; without: they share one"};
  Param<std::vector<FilePath>> json{"json", std::vector<FilePath>{}, "files like actuals.json"};
  Param<std::vector<FilePath>> hilti{"hilti", std::vector<FilePath>{}, "staked points: PtID;E;N;H"};
  Param<std::vector<FilePath>> trimble{"trimble", std::vector<FilePath>{},
                                       "staked points: name, N, E, elevation, code"};
  Param<std::vector<FilePath>> leica{"leica", std::vector<FilePath>{}, "staked points: PtID, E, N, H, code"};
  Param<std::vector<FilePath>> states{"states", std::vector<FilePath>{},
                                      "state messages of VDA 5050, one in each line, as many files as `jobs`"};
  Param<std::vector<FilePath>> jobs{"jobs", std::vector<FilePath>{}, "job.json that each of `states` answers"};
  Param<std::string> at{"at", "", "when what has no date of its own was done, ISO 8601 with zone; empty: not said"};
  Param<std::string> frame_name{"frame", "building", one_of("building"), "frame of their places"};
  Out<Actuals> actuals{"actuals", frame("frame=building"), "the reports, in the order of the files"};
  void run(Context& context) override;

 private:
  /// `text`: of the file.
  void take(ActualsT read, const std::string& text, ActualsT& into);
};

}  // namespace plumbline::loop
