// What `plumbline bench` hands to the node bench.summary: every cell with what was measured (docs/benchmarking.md).
#pragma once

#include <cmath>
#include <cstdint>
#include <map>
#include <string>
#include <vector>

namespace plumbline::bench {

struct Cell {
  std::string scenario;
  std::string place;                           ///< scenario and variables, in words; empty if there is only one
  std::map<std::string, std::string> values;   ///< of the matrix
  std::map<std::string, std::string> choices;  ///< alternative by group
  std::uint64_t seed = 0;
  std::string status;  ///< "done", "failed", "missing"
  std::string error;
  bool planned = true;     ///< false: no pipeline could be made of it, so nothing of it ran; its status is "failed"
  bool forbidden = false;  ///< failed, because a node says of its own result that it is not to be used
  /// Whether an alternative was tried there: it gave a result, or ran and failed.
  bool has_run() const { return planned && status != "missing"; }
  std::map<std::string, double> measures;  ///< nan where not known
  /// What is found and stated in parts of the errors: "scale", then found, predicted, nees, freedom.
  std::map<std::string, std::map<std::string, double>> modes;
  std::map<std::string, std::string> inputs;                        ///< hash of what each node got
  std::map<std::string, double> seconds;                            ///< of the nodes that ran
  std::string run;                                                  ///< of which call of the program
  double measure(const std::string& quantity) const;                ///< nan if it is not there
  double error_size() const { return std::abs(measure("error")); }  ///< a metric may have a sign, an error has a size
};

struct Group {
  std::string name;
  std::vector<std::string> alternatives;
  std::vector<std::string> nodes;  ///< that the alternatives change
  bool whole_pipelines = false;    ///< alternatives are pipelines of their own
};

struct Variable {
  std::string name;
  std::vector<std::string> values;
};

struct Excluded {
  std::string what, why;
  std::size_t cells = 0;
};

struct Bench {
  std::string title, file, error_metric;
  std::vector<std::string> overrides;          ///< KEY=VALUE of the command line, for all cells
  std::map<std::string, std::string> metrics;  ///< NODE.METRIC that each quantity is read from
  double rope = 0;                             ///< [m]
  std::vector<double> tolerances;              ///< [m]
  std::vector<std::string> scenarios;
  std::vector<std::size_t> looks;         ///< numbers of seeds at which the bench may stop
  std::size_t judged_seeds = 0;           ///< the first so many of the file; 0: not told
  std::size_t behind = 0;                 ///< cells of others that have run and are not among `cells` as such
  std::map<std::string, double> weights;  ///< of places, or of scenarios; empty: the file states none
  bool weights_of_scenarios = false;      ///< of which those places share one that count in a comparison
  std::string weights_text;               ///< "all places weighing alike", …
  std::vector<Variable> variables;
  std::vector<Group> groups;
  std::vector<Excluded> excluded;
  std::vector<std::string> machine;  ///< lines to show
  /// Nodes of which the bench itself computed start_cost and final_cost; empty: the file measures them, or nobody.
  std::vector<std::string> judged;
  std::vector<Cell> cells;
  std::vector<std::string> places() const;  ///< in the file's order
  /// The largest tolerance, if it is a yardstick: some answer of the bench lies within it; else infinity. What is off
  /// by more is of no use to anybody who asked for it, however often it is given.
  double useless_above() const;
  /// The largest tolerance where something has run and no trial came within it, else nan.
  double none_within() const;
};

/// Throws std::runtime_error if the text is not what sweep_table() writes.
Bench parse_bench(const std::string& json);

/// "adjust.ceres · pose.opengv"; the choice of `without` left out.
std::string choices_text(const std::map<std::string, std::string>& choices, const std::string& without = "");

}  // namespace plumbline::bench
