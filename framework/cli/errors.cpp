// `plumbline list errors`: exit codes and what a failed node's line in run.jsonl says, the one table that all pages are
// made of.
#include <nlohmann/json.hpp>

#include "cli/commands.hpp"
#include "cli/terminal.hpp"

namespace plumbline::cli {

namespace {

using Json = nlohmann::ordered_json;

struct Told {
  const char *where, *name, *means, *next;
};

constexpr Told kTold[] = {
    {"exit code", "0", "done", ""},
    {"exit code", "1",
     "a node failed, or an output could not be written; `diff`, `verify`, `validate` and `campaign check` found what "
     "they look for; of a bench an alternative or a scenario gave no result",
     "the last lines say what failed and what to do; of a site's folder `plumbline campaign check FOLDER` tells "
     "everything at once"},
    {"exit code", "2",
     "nothing was run: an unknown command, pipeline, variable, parameter or file, one that is missing, or a pipeline "
     "that is not valid",
     "the message has line and column, and the near name"},
    {"exit code", "3",
     "done, and not to be used: a node says so (its metric `invalid` is above 0), or rounds came to their most and not "
     "to their end",
     "the last line names the nodes; their warnings and the page say what contradicts itself and what mends it"},
    {"exit code", "4", "a solver ended without a result, though its input may be sound, and nothing else failed",
     "the last lines say what it stumbled over, if that can be named"},
    {"exit code", "130", "ended by Ctrl-C or SIGTERM", "run it again: what was done is reused"},
    {"failure", "bad_input", "what the node was given is wrong", "mend the file, field or parameter that it names"},
    {"failure", "not_converged", "a solver ended without a result", "other approximate values, or more observations"},
    {"failure", "failed", "anything else: a file that cannot be written, a program that it needs, a mistake of its own",
     "its error; `--isolate` where a plugin crashes"},
};

}  // namespace

int list_errors(const Options& options) {
  Json json = Json::array();
  std::vector<std::vector<std::string>> rows;
  for (const Told& told : kTold) {
    json.push_back({{"where", told.where}, {"name", told.name}, {"means", told.means}, {"next", told.next}});
    const std::string next = told.next;
    rows.push_back({std::string(told.where) + " " + told.name, told.means + (next.empty() ? next : ": " + next)});
  }
  if (options.json)
    std::printf("%s\n", json.dump(1).c_str());
  else
    std::printf("%s", columns(rows).c_str());
  return 0;
}

}  // namespace plumbline::cli
