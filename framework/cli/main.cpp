// The `plumbline` program: the command line, and what becomes of errors.
#include <glog/logging.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <cerrno>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <functional>
#include <iostream>
#include <memory>
#include <sstream>

#include "bench.hpp"
#include "build_info.hpp"
#include "commands.hpp"
#include "plumbline/folder_files.hpp"
#include "runtime/base/printable.hpp"
#include "runtime/record/run_record.hpp"
#include "terminal.hpp"

namespace {

using plumbline::cli::Options;

/// Help that fits the terminal.
class ScreenFormatter : public CLI::Formatter {
 public:
  std::string make_option_desc(const CLI::Option* option) const override {
    return beside(CLI::Formatter::make_option_desc(option));
  }
  std::string make_subcommand(const CLI::App* command) const override {
    std::ostringstream out;
    CLI::detail::format_help(out, command->get_name(), beside(command->get_description()), column_width_);
    return out.str();
  }
  std::string make_description(const CLI::App* app) const override {
    return plumbline::cli::lines(app->get_description()) + "\n";
  }

 private:
  std::string beside(const std::string& text) const {
    constexpr size_t narrowest = 20;
    const size_t screen = plumbline::cli::terminal_columns();
    return plumbline::cli::wrapped(text,
                                   screen == 0 ? 0 : std::max(narrowest, screen - std::min(screen, column_width_)));
  }
};

struct Command {
  CLI::App* app;
  std::function<int(const Options&)> action;
};

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

std::vector<Command> declare(CLI::App& app, Options& options, plumbline::cli::BenchOptions& bench_options) {
  std::vector<Command> commands;
  const auto add = [&](const char* name, const char* summary, int (*action)(const Options&)) -> CLI::App& {
    commands.push_back({app.add_subcommand(name, summary), action});
    return *commands.back().app;
  };
  CLI::App& run =
      add("run", "runs a pipeline; what is in the store already is not computed again", plumbline::cli::run);
  add_pipeline(run, options);
  run.add_option("--out", options.out, "folder for the named outputs and run.jsonl (default: out/<pipeline>)")
      ->type_name("DIR");
  run.add_flag("--overwrite", options.overwrite, "replace files in the way of an output whoever wrote them");
  run.add_option("--threads", options.threads, "number of threads (default: all processors)")
      ->check(CLI::Range(1, 4096));
  run.add_option("--memory", options.memory,
                 "limit for memory that nodes announce, such as 3GiB (default: half of it, at most 3GiB)")
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

  CLI::App& watch = add("watch", "runs a pipeline again whenever what it reads has changed", plumbline::cli::watch);
  add_pipeline(watch, options);
  watch.add_option("--out", options.out, "folder for the named outputs and run.jsonl (default: out/<pipeline>)")
      ->type_name("DIR");
  watch.add_flag("--overwrite", options.overwrite, "replace files in the way of an output whoever wrote them");
  watch
      .add_option("--quiet-for", options.quiet_seconds,
                  "seconds in which no file may change before a run begins: half-copied files are waited for")
      ->check(CLI::Range(0.1, 3600.0))
      ->capture_default_str();
  watch.add_option("--runs", options.most_runs, "ends after so many runs, with the last one's exit code")
      ->check(CLI::Range(1, 1000000));
  watch.add_option("--threads", options.threads, "number of threads (default: all processors)")
      ->check(CLI::Range(1, 4096));
  add_store(watch, options);
  watch.add_flag("-q,--quiet", options.quiet, "print nothing of a run but warnings and errors");

  CLI::App& serve =
      add("serve", "shows runs as a page on this machine that follows them as they go", plumbline::cli::serve);
  serve.add_option("folder", options.name, "the output folder of a run, or one that holds several (default: out)")
      ->type_name("OUT");
  serve.add_option("--port", options.port, "where to listen (default: any that is free)")->check(CLI::Range(0, 65535));
  serve
      .add_option("--host", options.host,
                  "address to listen on; others than this machine's own are reached by whoever has the token")
      ->type_name("ADDRESS");
  add_store(serve, options);

  CLI::App& made = add("new", "begins a node of your own: a folder that builds, is tested and runs as it is",
                       plumbline::cli::new_node);
  made.add_option(
          "template", options.role,
          "detector, pose_solver, adjuster, registrar, planner, robot, metric, survey_reader, writer or python_node")
      ->required()
      ->type_name("TEMPLATE");
  made.add_option("name", options.name, "of the node, as in detect.NAME")->required()->type_name("NAME");
  made.add_option("--out", options.out, "the folder to make (default: NAME)")->type_name("DIR");

  CLI::App& shipped = add("example", "makes a folder with the data of the tutorial: photographs of a printed board",
                          plumbline::cli::example);
  shipped.add_option("folder", options.name, "the folder to make (default: board)")->type_name("FOLDER");

  CLI::App* bench =
      app.add_subcommand("bench", "runs alternatives on many trials and says which is better, and by how much");
  plumbline::cli::declare_bench(*bench, bench_options);
  commands.push_back({bench, [&bench_options](const Options&) { return plumbline::cli::bench(bench_options); }});

  CLI::App& campaign = *app.add_subcommand("campaign", "proposes and checks the campaign.yaml of a site's folder");
  campaign.require_subcommand(1);
  const auto add_campaign = [&](const char* name, const char* summary, int (*action)(const Options&)) {
    CLI::App& command = *campaign.add_subcommand(name, summary);
    command.add_option("folder", options.name, "the folder of a site")->required()->type_name("FOLDER");
    command.add_option("override", options.overrides, "language=de: in German")->type_name("KEY=VALUE");
    add_store(command, options);
    commands.push_back({&command, action});
  };
  add_campaign("init", "looks at what lies in a folder and writes a commented campaign.yaml",
               plumbline::cli::campaign_init);
  add_campaign("check", "reads the folder and tells all that is wrong with it at once", plumbline::cli::campaign_check);

  CLI::App& validate =
      add("validate", "checks a pipeline and shows all that is wrong with it", plumbline::cli::validate);
  add_pipeline(validate, options);
  add_json(validate, options);
  validate.add_flag("-q,--quiet", options.quiet, "print nothing but errors");

  CLI::App& plan = add("plan", "shows which nodes would run, which are reused, and why", plumbline::cli::plan);
  add_pipeline(plan, options);
  add_store(plan, options);
  add_json(plan, options);

  CLI::App& list = add("list", "lists the kinds of nodes, the pipelines or the artifacts", plumbline::cli::list);
  list.add_option("what", options.name, "nodes (if nothing is said), pipelines or artifacts")
      ->check(CLI::IsMember({"nodes", "pipelines", "artifacts"}))
      ->type_name("WHAT");
  list.add_option("--role", options.role, "only those of this role")->type_name("ROLE");
  add_json(list, options);

  CLI::App& describe =
      add("describe", "shows ports and parameters of a kind, variables of a pipeline, fields of an artifact",
          plumbline::cli::describe);
  describe.add_option("name", options.name, "such as pose.opengv, site_campaign or plumbline.Points/1")
      ->required()
      ->type_name("NAME");
  add_json(describe, options);

  add("schema", "prints the JSON Schema of pipeline files, for editors", plumbline::cli::schema);

  CLI::App& graph = add("graph", "draws a pipeline", plumbline::cli::draw);
  add_pipeline(graph, options);
  graph.add_option("--format", options.format, "dot or mermaid")
      ->check(CLI::IsMember({"dot", "mermaid"}))
      ->capture_default_str();

  CLI::App& doctor = add("doctor", "checks plugins, store and machine, and says what to do", plumbline::cli::doctor);
  add_store(doctor, options);
  add_json(doctor, options);

  CLI::App& show = add("show", "prints an artifact as JSON", plumbline::cli::show);
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

  CLI::App& why = add("why", "says why a node ran in a run, or why it did not", plumbline::cli::why);
  why.add_option("node", options.name, "its name in the pipeline")->required()->type_name("NODE");
  add_runs(why, options, 0);
  add_json(why, options);

  CLI::App& diff = add("diff", "compares two runs node by node", plumbline::cli::diff);
  add_runs(diff, options, 2);
  diff.add_option(
          "--tolerance", options.tolerance,
          "numbers above 1 that differ by less than this count as equal, smaller ones by less than this part of "
          "them")
      ->check(CLI::Range(0.0, 1.0));
  add_store(diff, options);
  add_json(diff, options);

  CLI::App& verify = add("verify",
                         "runs a pipeline twice from nothing, with one and with several threads, and compares all "
                         "results bit by bit",
                         plumbline::cli::verify);
  add_pipeline(verify, options);
  verify.add_flag(
      "--each", options.each,
      "run it once, from the store as far as it goes, then every node alone in a fresh process, and compare "
      "that with what the store has");
  add_store(verify, options);
  verify.add_option("--threads", options.threads, "of the second run (default: 2)")->check(CLI::Range(2, 4096));
  add_json(verify, options);

  CLI::App& exported = add("export", "prints a run in a format of others", plumbline::cli::export_run);
  add_runs(exported, options, 1);
  exported.add_option("--format", options.format, "trace (Chrome, Perfetto) or ro-crate")
      ->check(CLI::IsMember({"trace", "ro-crate"}))
      ->required();

  CLI::App& journal = add("journal", "shows a journal, checks that nothing in it was changed, explains an item",
                          plumbline::cli::journal);
  journal.add_option("journal", options.name, "a journal.jsonl or the output folder that holds it")
      ->required()
      ->type_name("JOURNAL");
  journal.add_option("--item", options.item, "only what happened to this one")->type_name("ITEM");
  journal.add_flag("--check", options.check, "only whether it is whole, and where everything stands");
  add_json(journal, options);

  CLI::App& cache = add("cache", "lists what the store holds", plumbline::cli::cache);
  add_store(cache, options);
  add_json(cache, options);
  CLI::App* prune = cache.add_subcommand("prune", "removes what was not used for the longest time");
  add_store(*prune, options);
  prune->add_option("--keep", options.limit, "the store may keep that much, such as 2GiB")->type_name("SIZE");
  prune->add_option("--days", options.days, "and what was used within so many days")->check(CLI::NonNegativeNumber);
  commands.push_back({prune, plumbline::cli::prune});
  return commands;
}

/// What CLI11 says, with the near names it does not offer.
std::string usage_text(const CLI::ParseError& error, int argc, char** argv, const CLI::App& app) {
  std::vector<std::string> commands;
  for (const CLI::App* command : app.get_subcommands({})) commands.push_back(command->get_name());
  const std::string first = argc > 1 ? argv[1] : "";
  if (argc > 1 && first[0] != '-' && std::find(commands.begin(), commands.end(), first) == commands.end())
    return "there is no command '" + first + "'" + plumbline::cli::did_you_mean(first, commands);
  if (argc > 2 && argv[2][0] != '-') {  // `campaign chek`, `cache prun`: no word of theirs is anything else
    std::vector<std::string> below;
    const CLI::App* above = app.get_subcommand(first);
    for (const CLI::App* one : above->get_subcommands({})) below.push_back(one->get_name());
    const bool takes_words =
        std::ranges::any_of(above->get_options(), [](const auto* o) { return o->get_positional(); });
    if (!below.empty() && !takes_words && std::ranges::find(below, argv[2]) == below.end())
      return "there is no command '" + first + " " + argv[2] + "'" + plumbline::cli::did_you_mean(argv[2], below);
  }
  const CLI::App* command = app.get_subcommands().empty() ? &app : app.get_subcommands()[0];
  std::vector<std::string> known;
  for (const CLI::Option* option : command->get_options())
    for (const std::string& name : option->get_lnames()) known.push_back("--" + name);
  for (int i = 1; i < argc; ++i) {
    const std::string word = std::string(argv[i]).substr(0, std::string(argv[i]).find('='));
    if (word.rfind("--", 0) == 0 && word.size() > 2 && std::find(known.begin(), known.end(), word) == known.end())
      return "there is no option '" + word + "'" + plumbline::cli::did_you_mean(word, known);
  }
  return error.what();
}

/// What was printed must have arrived: on a full disk it has not.
int finished(int code) {
  if (std::fflush(stdout) == 0 && !std::ferror(stdout)) return code;
  std::fprintf(stderr, "plumbline: cannot write to standard output: %s\n", std::strerror(errno));
  return code == 0 ? 1 : code;
}

}  // namespace

int main(int argc, char** argv) {
  // Libraries that plugins bring (Ceres) log through glog: uninitialised, it writes to standard error; initialised, to
  // files in /tmp. Neither is wanted: what a solver has to say comes in its summary.
  FLAGS_minloglevel = google::GLOG_FATAL;
  google::InitGoogleLogging("plumbline");

  plumbline::announce_printed_files();
  Options options;
  plumbline::cli::BenchOptions bench_options;
  CLI::App app("Plumbline: survey-controlled photogrammetry as a dataflow of plugins");
  app.formatter(std::make_shared<ScreenFormatter>());
  app.set_version_flag("--version", "plumbline " PLUMBLINE_VERSION " (commit " + plumbline::cli::build_commit() + ")");
  app.name("plumbline");
  app.require_subcommand(1);
  app.failure_message(CLI::FailureMessage::simple);
  const std::vector<Command> commands = declare(app, options, bench_options);
  // `help`, `help run` and `version`, as people try them first.
  std::vector<std::string> words(argv + 1, argv + argc);
  const bool nothing = words.empty();
  std::vector<std::string> known;
  for (const CLI::App* command : app.get_subcommands({})) known.push_back(command->get_name());
  if (words.size() > 1 && words[0] == "help" && words[1][0] != '-' &&
      std::ranges::find(known, words[1]) == known.end()) {
    std::fprintf(stderr, "plumbline: there is no command '%s'%s\nRun with --help for what there is.\n",
                 words[1].c_str(), plumbline::cli::did_you_mean(words[1], known).c_str());
    return 2;
  }
  if (nothing) words = {"--help"};
  if (words[0] == "version") words = {"--version"};
  if (words[0] == "help") {
    words.erase(words.begin());
    words.emplace_back("--help");
  }
  try {
    std::reverse(words.begin(), words.end());  // as CLI11 takes them
    app.parse(std::move(words));
  } catch (const CLI::Success& success) {  // --help, --version
    app.exit(success, nothing ? std::cerr : std::cout);
    return nothing ? 2 : 0;
  } catch (const CLI::ParseError& error) {
    std::fprintf(stderr, "plumbline: %s\nRun with --help for what there is.\n",
                 usage_text(error, argc, argv, app).c_str());
    return 2;
  }
  if (options.trust_others) setenv("PLUMBLINE_TRUST_OTHERS", "1", 1);
  try {
    // The last one first: a command below another one stands after it.
    for (auto command = commands.rbegin(); command != commands.rend(); ++command)
      if (command->app->parsed()) return finished(command->action(options));
  } catch (const plumbline::cli::UsageError& error) {
    std::fprintf(stderr, "plumbline: %s\n", plumbline::runtime::printable(error.what()).c_str());
    return 2;
  } catch (const plumbline::runtime::InvalidPipeline& error) {  // unknown variables and parameters, too
    std::fprintf(stderr, "%s\n", plumbline::runtime::printable(error.what()).c_str());
    return 2;
  } catch (const plumbline::runtime::NoRunRecord& error) {
    std::fprintf(stderr, "plumbline: %s\n", plumbline::runtime::printable(error.what()).c_str());
    return 2;
  } catch (const std::exception& error) {
    std::fprintf(stderr, "plumbline: %s\n", plumbline::runtime::printable(error.what()).c_str());
    return 1;
  }
  return 2;
}
