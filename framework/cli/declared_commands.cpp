#include "declared_commands.hpp"

#include <CLI/CLI.hpp>
#include <algorithm>
#include <cstdlib>
#include <string>

namespace plumbline::cli {

namespace {

/// CLI11's own validators name the largest number that there is, with 309 digits.
std::string not_below(const std::string& text, bool may_be_zero) {
  char* end = nullptr;
  const double value = std::strtod(text.c_str(), &end);
  const bool is_number = end != text.c_str() && *end == 0;
  if (is_number && (may_be_zero ? value >= 0 : value > 0)) return {};
  return "is '" + text + "', expected a number " + (may_be_zero ? "of 0 or more" : "above 0");
}
const CLI::Validator kNotNegative([](std::string& text) { return not_below(text, true); }, "0 or more");
const CLI::Validator kPositive([](std::string& text) { return not_below(text, false); }, "above 0");

void add_pipeline(CLI::App& app, Options& options) {
  app.add_option("pipeline", options.pipeline, "a pipeline file, or the name of one of the shipped ones")
      ->required()
      ->type_name("FILE");
  app.add_option("overrides", options.overrides,
                 "floors=3 sets a variable, poses.with.solver=epnp a parameter, poses.use=pose.opencv a kind")
      ->type_name("KEY=VALUE");
}

void add_json(CLI::App& app, Options& options) { app.add_flag("--json", options.json, "machine-readable output"); }

void add_store(CLI::App& app, Options& options) {
  app.add_option(
         "--store", options.store,
         "folder of the store (default: $PLUMBLINE_STORE, else $XDG_CACHE_HOME/plumbline, else ~/.cache/plumbline)")
      ->type_name("DIR");
  app.add_flag("--trust-others", options.trust_others,
               "use a store and plugins that other users of this machine may write (PLUMBLINE_TRUST_OTHERS=1)");
}

void add_runs(CLI::App& app, Options& options, int count) {
  app.add_option("run", options.runs, "a run.jsonl or the output folder that holds it")
      ->required(count > 0)
      ->expected(std::max(count, 1))
      ->type_name("RUN");
}

/// Adds commands in the order in which help shows them.
struct Declared {
  CLI::App& app;
  Options& options;
  std::vector<Command> commands;

  CLI::App& add(const char* name, const char* summary, int (*action)(const Options&)) {
    return add_below(app, name, summary, action);
  }

  CLI::App& add_below(CLI::App& above, const char* name, const char* summary, int (*action)(const Options&)) {
    commands.push_back({above.add_subcommand(name, summary), action});
    return *commands.back().app;
  }
};

/// What runs a pipeline and shows it as it goes.
void declare_runs(Declared& all) {
  Options& options = all.options;
  CLI::App& run = all.add("run", "runs a pipeline; what is in the store already is not computed again", cli::run);
  add_pipeline(run, options);
  run.add_option("--out", options.out, "folder for the named outputs and run.jsonl (default: out/<pipeline>)")
      ->type_name("DIR");
  run.add_flag("--overwrite", options.overwrite, "replace files in the way of an output whoever wrote them");
  run.add_option("--threads", options.threads, "number of threads (default: all processors)")
      ->check(CLI::Range(1, 4096));
  run.add_option("--memory", options.memory,
                 "limit for memory that nodes announce, such as 3GiB; one that takes more fails (default: half of the "
                 "machine's, at most 3GiB, where such a node runs alone with a warning)")
      ->type_name("SIZE");
  add_store(run, options);
  run.add_flag("--durable", options.durable,
               "sync every file of the store to disk before the next step: a power failure then costs nothing");
  add_json(run, options);
  run.add_flag("--rehash", options.rehash,
               "read every input file once more, and trust nothing that is remembered of its time and size");
  run.add_flag("--isolate", options.isolate,
               "run every node in a process of its own, so that a crash is an error of that node alone");
  run.add_flag("-q,--quiet", options.quiet, "print nothing but warnings and errors");

  CLI::App& watch = all.add("watch", "runs a pipeline again whenever what it reads has changed", cli::watch);
  add_pipeline(watch, options);
  watch.add_option("--out", options.out, "folder for the named outputs and run.jsonl (default: out/<pipeline>)")
      ->type_name("DIR");
  watch.add_flag("--overwrite", options.overwrite, "replace files in the way of an output whoever wrote them");
  watch
      .add_option("--quiet-for", options.quiet_seconds,
                  "seconds in which no file may change before a run begins; a new JPEG or PNG without its end is "
                  "waited for up to 60 s longer")
      ->check(CLI::Range(0.1, 3600.0))
      ->capture_default_str();
  watch.add_option("--runs", options.most_runs, "ends after so many runs, with the last one's exit code")
      ->check(CLI::Range(1, 1000000));
  watch.add_option("--threads", options.threads, "number of threads (default: all processors)")
      ->check(CLI::Range(1, 4096));
  add_store(watch, options);
  watch.add_flag("-q,--quiet", options.quiet, "print nothing of a run but warnings and errors");

  CLI::App& serve = all.add("serve", "shows runs as a page on this machine that follows them as they go", cli::serve);
  serve.add_option("folder", options.name, "the output folder of a run, or one that holds several (default: out)")
      ->type_name("OUT");
  serve.add_option("--port", options.port, "where to listen (default: any that is free)")->check(CLI::Range(0, 65535));
  serve
      .add_option("--host", options.host,
                  "address to listen on; others than this machine's own are reached by whoever has the token")
      ->type_name("ADDRESS");
  add_store(serve, options);
}

/// What makes a folder to begin with.
void declare_beginnings(Declared& all) {
  Options& options = all.options;
  CLI::App& made =
      all.add("new", "begins a node of your own: a folder that builds, is tested and runs as it is", cli::new_node);
  made.add_option(
          "template", options.role,
          "detector, pose_solver, adjuster, registrar, planner, robot, metric, survey_reader, writer or python_node")
      ->required()
      ->type_name("TEMPLATE");
  made.add_option("name", options.name, "of the node, as in detect.NAME")->required()->type_name("NAME");
  made.add_option("--out", options.out, "the folder to make (default: NAME)")->type_name("DIR");

  CLI::App& shipped =
      all.add("example", "makes a folder with the data of the tutorial: photographs of a printed board", cli::example);
  shipped.add_option("folder", options.name, "the folder to make (default: board)")->type_name("FOLDER");
}

/// What looks at the folder of a site.
void declare_campaign(Declared& all) {
  Options& options = all.options;
  CLI::App& campaign = *all.app.add_subcommand("campaign", "proposes and checks the campaign.yaml of a site's folder");
  campaign.require_subcommand(1);
  const auto add = [&](const char* name, const char* summary, int (*action)(const Options&)) {
    CLI::App& command = all.add_below(campaign, name, summary, action);
    command.add_option("folder", options.name, "the folder of a site")->required()->type_name("FOLDER");
    command.add_option("override", options.overrides, "language=de: in German")->type_name("KEY=VALUE");
    add_store(command, options);
  };
  add("init", "looks at what lies in a folder and writes a commented campaign.yaml", campaign_init);
  add("check", "reads the folder and tells all that is wrong with it at once", campaign_check);
}

/// What is said of pipelines and nodes before anything runs.
void declare_pipelines(Declared& all) {
  Options& options = all.options;
  CLI::App& validate = all.add("validate", "checks a pipeline and shows all that is wrong with it", cli::validate);
  add_pipeline(validate, options);
  add_json(validate, options);
  validate.add_flag("-q,--quiet", options.quiet, "print nothing but errors");

  CLI::App& plan = all.add("plan", "shows which nodes would run, which are reused, and why", cli::plan);
  add_pipeline(plan, options);
  plan.add_option("--out", options.out, "as `run` takes it, so that its command can be typed again; nothing is written")
      ->type_name("DIR");
  add_store(plan, options);
  add_json(plan, options);

  CLI::App& list = all.add("list", "lists the kinds of nodes, the pipelines, the artifacts or the errors", cli::list);
  list.add_option("what", options.name,
                  "nodes (if nothing is said), pipelines, artifacts or errors (exit codes and failures)")
      ->check(CLI::IsMember({"nodes", "pipelines", "artifacts", "errors"}))
      ->type_name("WHAT");
  list.add_option("--role", options.role, "only those of this role")->type_name("ROLE");
  add_json(list, options);

  CLI::App& describe =
      all.add("describe", "shows ports and parameters of a kind, variables of a pipeline, fields of an artifact",
              cli::describe);
  describe.add_option("name", options.name, "such as pose.opengv, site_campaign or plumbline.Points/1")
      ->required()
      ->type_name("NAME");
  add_json(describe, options);

  all.add("schema", "prints the JSON Schema of pipeline files, for editors", cli::schema);

  CLI::App& graph = all.add("graph", "draws a pipeline", cli::draw);
  add_pipeline(graph, options);
  graph.add_option("--format", options.format, "dot or mermaid")
      ->check(CLI::IsMember({"dot", "mermaid"}))
      ->capture_default_str();

  CLI::App& doctor = all.add("doctor", "checks plugins, store and machine, and says what to do", cli::doctor);
  add_store(doctor, options);
  add_json(doctor, options);
}

/// What is said of results.
void declare_results(Declared& all) {
  Options& options = all.options;
  CLI::App& show = all.add("show", "prints an artifact as JSON", cli::show);
  show.add_option("artifact", options.name,
                  "start of its hash, or RUN.jsonl:NODE.PORT, or a file; a run for --relative")
      ->required()
      ->type_name("ARTIFACT");
  show.add_option("--type", options.role, "its type, such as plumbline.Points/1, where the bytes leave a choice")
      ->type_name("TYPE");
  show.add_option("--relative", options.relative,
                  "two points of a run (RUN or RUN.jsonl:NODE.PORT): difference, distances, standard deviations")
      ->expected(2)
      ->type_name("A B");
  show.add_flag("--json", options.json, "with --relative: as JSON");
  add_store(show, options);

  CLI::App& why = all.add("why", "says why a node ran in a run, or why it did not", cli::why);
  why.add_option("node", options.name, "its name in the pipeline")->required()->type_name("NODE");
  add_runs(why, options, 0);
  add_json(why, options);

  CLI::App& diff = all.add("diff", "compares two runs node by node", cli::diff);
  add_runs(diff, options, 2);
  diff.add_option(
          "--tolerance", options.tolerance,
          "numbers above 1 that differ by less than this count as equal, smaller ones by less than this part of "
          "them")
      ->check(CLI::Range(0.0, 1.0));
  add_store(diff, options);
  add_json(diff, options);

  CLI::App& verify = all.add("verify",
                             "runs a pipeline twice from nothing, with one and with several threads, and compares all "
                             "results bit by bit",
                             cli::verify);
  add_pipeline(verify, options);
  verify.add_flag(
      "--each", options.each,
      "run it once, from the store as far as it goes, then every node alone in a fresh process, and compare "
      "that with what the store has");
  add_store(verify, options);
  verify.add_option("--threads", options.threads, "of the second run (default: 2)")->check(CLI::Range(2, 4096));
  add_json(verify, options);

  CLI::App& exported = all.add("export", "prints a run in a format of others", cli::export_run);
  add_runs(exported, options, 1);
  exported.add_option("--format", options.format, "trace (Chrome, Perfetto) or ro-crate")
      ->check(CLI::IsMember({"trace", "ro-crate"}))
      ->required();

  CLI::App& journal =
      all.add("journal", "shows a journal, checks that nothing in it was changed, explains an item", cli::journal);
  journal.add_option("journal", options.name, "a journal.jsonl or the output folder that holds it")
      ->required()
      ->type_name("JOURNAL");
  journal.add_option("--item", options.item, "only what happened to this one")->type_name("ITEM");
  journal.add_flag("--check", options.check, "only whether it is whole, and where everything stands");
  add_json(journal, options);
}

/// The store.
void declare_store(Declared& all) {
  Options& options = all.options;
  CLI::App& cache = all.add("cache", "lists what the store holds", cli::cache);
  add_store(cache, options);
  add_json(cache, options);
  CLI::App& prune = all.add_below(cache, "prune", "removes what was not used for the longest time", cli::prune);
  add_store(prune, options);
  prune.add_option("--keep", options.limit, "the store may keep that much, such as 2GiB")->type_name("SIZE");
  prune.add_option("--days", options.days, "and what was used within so many days")->check(kNotNegative);
}

void declare_bench(CLI::App& command, BenchOptions& options) {
  command
      .add_option("file", options.file,
                  "a bench file, or the name of one of the shipped ones; or 'verify' and then a folder that "
                  "--archive wrote")
      ->required()
      ->type_name("FILE");
  command.add_option("overrides", options.overrides, "variables and parameters for all cells, as for run")
      ->type_name("KEY=VALUE");
  command
      .add_option("--out", options.out,
                  "folder for bench.html, .csv, .json, .md, .tex, .svg, .pdf (default: out/<file>)")
      ->type_name("DIR");
  command
      .add_option("--archive", options.archive,
                  "folder for what makes the bench again: files, seeds, commit, versions, hashes, raw results")
      ->type_name("DIR");
  command.add_option("--cells", options.cells, "for verify: how many cells are made again, 0 for all")
      ->check(kNotNegative)
      ->capture_default_str();
  command.add_option("--store", options.store, "folder of the store; where other machines work, one they all see")
      ->type_name("DIR");
  command.add_option("--seeds", options.seeds, "in place of the file's, such as 1-20")->type_name("SEEDS");
  command
      .add_option("--scenario", options.scenarios, "only this one of the file's scenarios; may be given several times")
      ->type_name("NAME")
      ->allow_extra_args(false);
  command.add_option("--workers", options.workers, "trials side by side (default: one a processor)")
      ->check(CLI::Range(1, 4096));
  command
      .add_option(
          "--memory", options.memory,
          "memory that nodes of all workers may announce, such as 3GiB; one that takes more than its worker's share "
          "runs alone there")
      ->type_name("SIZE");
  command.add_option("--limit", options.limit, "seconds after which a cell is ended and counts as failed")
      ->check(kPositive);
  command.add_flag("--retry", options.retry, "run failed cells again");
  command.add_flag("--status", options.status, "run nothing: say how far it is, and with --out write the tables");
  command.add_option("--executor", options.executor, "local, slurm (one sbatch --array), ssh (GNU parallel) or print")
      ->check(CLI::IsMember({"local", "slurm", "ssh", "print"}))
      ->capture_default_str();
  command.add_option("--hosts", options.hosts, "for ssh: HOST,HOST,…")->type_name("HOSTS");
  command.add_option("--sbatch", options.scheduler_options, "more options for sbatch")->type_name("TEXT");
  command.add_option("--cells-per-task", options.cells_per_task, "for slurm, ssh and print")
      ->check(CLI::Range(1, 100))
      ->capture_default_str();
  command.add_option("--task", options.task, "run this task of the plan only; the executors use it")
      ->check(kNotNegative);
  command.add_option("--plan", options.plan, "the plan that the task belongs to");
  command.add_flag("--overwrite", options.overwrite, "replace files in the output folder whoever wrote them");
  command.add_flag("--json", options.json, "machine-readable output");
  command.add_flag("-q,--quiet", options.quiet, "print nothing but warnings and errors");
}

}  // namespace

std::vector<Command> declare_commands(CLI::App& app, Options& options, BenchOptions& bench_options) {
  Declared all{app, options, {}};
  declare_runs(all);
  declare_beginnings(all);
  CLI::App* const bench =
      app.add_subcommand("bench", "runs alternatives on many trials and says which is better, and by how much");
  declare_bench(*bench, bench_options);
  all.commands.push_back({bench, [&bench_options](const Options&) { return cli::bench(bench_options); }});
  declare_campaign(all);
  declare_pipelines(all);
  declare_results(all);
  declare_store(all);
  return std::move(all.commands);
}

}  // namespace plumbline::cli
