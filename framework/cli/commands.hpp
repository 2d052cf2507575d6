// The commands of the program. Each returns the exit code: 0 done, 1 failed run, 130 cancelled. Wrong usage and
// invalid pipelines (exit code 2) are main's business.
#pragma once

#include <filesystem>
#include <memory>
#include <string>
#include <vector>

#include "runtime/graph/graph.hpp"
#include "runtime/plugins/registry.hpp"
#include "runtime/store/store.hpp"

namespace plumbline::cli {

/// The request cannot be carried out: an unknown name, say. Printed as it is, exit code 2.
class UsageError : public std::runtime_error {
 public:
  using std::runtime_error::runtime_error;
};

struct Options {
  std::string pipeline;                ///< a file or the name of a pipeline
  std::vector<std::string> overrides;  ///< KEY=VALUE
  std::string item;                    ///< of `journal`: only lines about it
  std::string name;                    ///< of a kind, a pipeline or an artifact; of `list`: what
  std::string role;                    ///< filter of `list`
  std::string out;                     ///< empty: out/<pipeline>
  std::string store;                   ///< empty: Store::default_folder()
  std::string memory;                  ///< "3GiB"; empty: the default
  std::string format = "dot";
  std::vector<std::string> runs;      ///< records: run.jsonl or their folders
  std::vector<std::string> relative;  ///< of `show`: two points
  double tolerance = 0;               ///< of `diff`
  std::string limit;                  ///< of `cache prune`: "2GiB"
  double days = -1;                   ///< likewise; negative: any age
  double quiet_seconds = 2;           ///< of `watch`
  std::string host;                   ///< of `serve`; empty: loopback
  int port = 0;                       ///< likewise; 0: any that is free
  int most_runs = 0;                  ///< of `watch`; 0: without end
  int threads = 0;
  bool durable = false, json = false, quiet = false, overwrite = false, trust_others = false, isolate = false,
       rehash = false, each = false, check = false;
};

int run(const Options& options);
int validate(const Options& options);
int plan(const Options& options);
int draw(const Options& options);
int list(const Options& options);
int describe(const Options& options);
/// `list pipelines`, `list artifacts`.
int list_pipelines(const Options& options);
int list_artifacts(const Options& options);
/// Exit codes, and kinds of failures of nodes.
int list_errors(const Options& options);
/// What `describe` knows beside nodes: pipelines, and artifacts by their short names.
std::vector<std::string> names_of_pipelines_and_artifacts(const runtime::Registry& registry);
/// `describe` of what is no kind of node; false if options.name is no pipeline, or no artifact.
bool describe_pipeline(const Options& options, const runtime::Registry& registry);
bool describe_artifact(const Options& options, const runtime::Registry& registry);
int schema(const Options& options);
int doctor(const Options& options);
int show(const Options& options);
/// `show RUN --relative A B`: difference and distances of two points of a run, with standard deviations.
int show_relative(const Options& options);
int why(const Options& options);
int diff(const Options& options);
int export_run(const Options& options);
int verify(const Options& options);
int watch(const Options& options);
int serve(const Options& options);
/// `new`: options.role is the template, options.name that of the node, options.out the folder.
int new_node(const Options& options);
/// `example`: options.name is the folder to make.
int example(const Options& options);
int campaign_init(const Options& options);
int campaign_check(const Options& options);
int journal(const Options& options);
int cache(const Options& options);
int prune(const Options& options);

/// The file of `name`: itself if there is such a file, else <name>.yaml in ./pipelines, in the source tree the program
/// was built from, or in share/plumbline/pipelines beside it. Throws UsageError with near names.
std::filesystem::path find_pipeline(const std::string& name);

/// The same for bench files: <name>.yaml in `benchmarks` beside those folders, and below. Throws UsageError.
std::string find_bench(const std::string& name);

/// Folders of pipelines that are found by name, also by `include:`.
std::vector<std::filesystem::path> pipeline_folders();

/// The pipeline of the command line: found, read and linked, with warn_of_kinds_offered_twice().
runtime::Graph load(const Options& options, const runtime::Registry& registry);

/// "B.so has one of that name, too, which is not used"; empty if nobody else offers the kind.
std::string offered_too_by(const runtime::Registry& registry, const std::string& kind);

/// Which of two nodes of one name runs must not be a matter of folders that nobody looks at: a warning on standard
/// error for every kind that has two.
void warn_of_kinds_offered_twice(const runtime::Graph& graph, const runtime::Registry& registry);
void warn_of_kinds_offered_twice(const std::vector<const runtime::Graph*>& graphs, const runtime::Registry& registry);

runtime::Registry discover();
runtime::Store open_store(const Options& options);
/// For commands that only look: also one that cannot be written.
std::unique_ptr<runtime::Store> open_store_to_read(const Options& options);

/// "3GiB", "500 MB", "1.5g" or plain bytes; k, M, G are powers of 1024 with or without "iB", and of 1000 with "B".
/// Throws UsageError.
uint64_t parse_size(const std::string& text);

/// " — did you mean 'a' or 'b'?", or nothing.
std::string did_you_mean(const std::string& wanted, const std::vector<std::string>& candidates);

}  // namespace plumbline::cli
