// plumbline campaign init, campaign check
#include <algorithm>
#include <cerrno>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <fstream>
#include <nlohmann/json.hpp>

#include "commands.hpp"
#include "runtime/base/printable.hpp"
#include "terminal.hpp"

namespace plumbline::cli {

namespace fs = std::filesystem;

namespace {

/// A folder for the outputs of a pipeline that only answers a question.
class Scratch {
 public:
  Scratch() {
    std::error_code error;
    const fs::path place = fs::temp_directory_path(error);
    std::string name = (place / "plumbline-XXXXXX").string();
    if (error || !mkdtemp(name.data()))
      throw std::runtime_error("cannot make a folder for a moment in " + (error ? "TMPDIR" : place.string()) + ": " +
                               (error ? error.message() : std::strerror(errno)) +
                               "; let TMPDIR name a folder that can be written");
    path_ = name;
  }
  ~Scratch() {
    std::error_code ignored;
    fs::remove_all(path_, ignored);
  }
  Scratch(const Scratch&) = delete;
  Scratch& operator=(const Scratch&) = delete;
  const fs::path& path() const { return path_; }

 private:
  fs::path path_;
};

int ask(const char* pipeline, const Options& options, const fs::path& out) {
  if (!fs::is_directory(options.name)) throw UsageError("'" + options.name + "' is no folder");
  Options question = options;
  question.pipeline = pipeline;
  question.overrides.insert(question.overrides.begin(), "folder=" + options.name);
  question.out = out.string();
  question.quiet = true;
  return run(question);
}

/// What these verbs say themselves; all else is said by the pipeline.
bool is_german(const Options& options) {
  return std::find(options.overrides.begin(), options.overrides.end(), "language=de") != options.overrides.end();
}

void print(const fs::path& file) {
  std::ifstream stream(file);
  for (std::string line; std::getline(stream, line);)
    std::printf("%s\n", paint_verdict(hanging_lines(runtime::printable(line), terminal_columns())).c_str());
}

/// What the pipeline `init_campaign` or `check_campaign` names as the one that takes the folder; none: "".
std::string named_pipeline(const fs::path& outputs) {
  std::ifstream stream(outputs / "pipeline.txt");
  std::string name;
  std::getline(stream, name);
  return name;
}

/// How many warnings its nodes gave, by the record.
std::size_t warnings_of(const fs::path& outputs) {
  std::size_t count = 0;
  std::ifstream stream(outputs / "run.jsonl");
  for (std::string line; std::getline(stream, line);) {
    const auto event = nlohmann::json::parse(line, nullptr, false);
    if (event.is_object() && event.contains("warnings")) count += event["warnings"].size();
  }
  return count;
}

/// ", with the 2 warnings above": what is no problem is not forgotten for that either.
std::string with_warnings(std::size_t count, bool german) {
  if (count == 0) return "";
  if (count == 1) return german ? ", mit der Warnung oben" : ", with the warning above";
  return (german ? ", mit den " : ", with the ") + std::to_string(count) +
         (german ? " Warnungen oben" : " warnings above");
}

}  // namespace

int campaign_init(const Options& options) {
  const fs::path target = fs::path(options.name) / "campaign.yaml";
  if (fs::exists(fs::symlink_status(target)))
    throw UsageError(target.string() +
                     " is there already, and is left as it is; `plumbline campaign check` says whether it "
                     "is sound");
  const Scratch scratch;
  if (const int code = ask("init_campaign", options, scratch.path()); code != 0) return code;
  std::error_code error;
  fs::copy_file(scratch.path() / "campaign.yaml", target, error);
  if (error)
    throw std::runtime_error("cannot write " + target.string() + ": " + error.message() +
                             "; check the rights on the folder, or work on a copy of it");
  print(scratch.path() / "summary.txt");
  const bool german = is_german(options);
  const std::string whole = named_pipeline(scratch.path());
  std::printf(german ? "%s ist geschrieben.\n" : "%s is written.\n", target.c_str());
  if (!whole.empty())
    std::printf(german ? "Damit läuft schon: plumbline run %s folder=%s language=de\n"
                       : "As it is, this runs: plumbline run %s folder=%s\n",
                whole.c_str(), options.name.c_str());
  std::printf(german ? "%s in Ordnung bringen, was dort steht, dann: plumbline campaign check %s language=de\n"
                     : "%s mend what it says, then: plumbline campaign check %s\n",
              !whole.empty()
                  ? (german ? "Für eine Baustelle mit Fotos von Marken" : "For a site with photographs of tags")
                  : (german ? "Lesen," : "Read it,"),
              options.name.c_str());
  return 0;
}

int campaign_check(const Options& options) {
  const Scratch scratch;
  const int code = ask("check_campaign", options, scratch.path());
  if (code != 0) return code;
  print(scratch.path() / "summary.txt");
  const bool german = is_german(options);
  std::printf("%s%s: plumbline run %s folder=%s%s\n", german ? "Als Nächstes" : "Next",
              with_warnings(warnings_of(scratch.path()), german).c_str(), named_pipeline(scratch.path()).c_str(),
              options.name.c_str(), german ? " language=de" : "");
  return 0;
}

}  // namespace plumbline::cli
