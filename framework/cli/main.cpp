// The `plumbline` program: the command line, and what becomes of errors.
#include <glog/logging.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <cerrno>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <iostream>
#include <memory>
#include <sstream>

#include "build_info.hpp"
#include "commands.hpp"
#include "declared_commands.hpp"
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
  std::vector<std::string> known;  // to the command that was called and those above it
  for (const CLI::App* command = &app; command;
       command = command->get_subcommands().empty() ? nullptr : command->get_subcommands()[0])
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
  const std::vector<plumbline::cli::Command> commands = plumbline::cli::declare_commands(app, options, bench_options);
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
  using plumbline::cli::tell;
  using plumbline::runtime::printable;
  try {
    // The last one first: a command below another one stands after it.
    for (auto command = commands.rbegin(); command != commands.rend(); ++command)
      if (command->app->parsed()) return finished(command->action(options));
  } catch (const plumbline::cli::UsageError& error) {
    tell("plumbline: " + printable(error.what()));
    return 2;
  } catch (const plumbline::runtime::InvalidPipeline& error) {  // unknown variables and parameters, too
    tell(printable(error.what()));
    return 2;
  } catch (const plumbline::runtime::NoRunRecord& error) {
    tell("plumbline: " + printable(error.what()));
    return 2;
  } catch (const std::exception& error) {
    tell("plumbline: " + printable(error.what()));
    return 1;
  }
  return 2;
}
