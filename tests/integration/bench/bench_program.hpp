// A folder with the program, the plugins a bench of the test needs, a pipeline of two nodes, and a store to look into.
#pragma once

#include <gmock/gmock.h>

#include <algorithm>
#include <map>
#include <nlohmann/json.hpp>
#include <set>

#include "../cli/program.hpp"

namespace plumbline::test {

class BenchProgram : public Program {
 public:
  using Json = nlohmann::json;

  explicit BenchProgram(const std::vector<std::string>& plugins = {PLUMBLINE_STORY_PLUGIN, PLUMBLINE_TRIAL_PLUGIN,
                                                                   PLUMBLINE_BENCH_PLUGIN})
      : Program(shared_folder(plugins)) {
    write("trial.yaml",
          "plumbline: 1\nvars: {seed: 1, factor: 1}\nnodes:\n"
          "  site: {use: story.draw}\n"
          "  solver: {use: trial.plain, in: {site: site.number}, with: {factor: \"${factor}\"}}\n");
  }

  /// A bench file: what every one of these tests has, and `rest`.
  void bench_file(const std::string& rest, const std::string& name = "b.yaml") const {
    write(name, "bench: 1\npipeline: trial.yaml\nmeasure: {error: solver.rmse_z, worst: solver.max_abs_z}\n" + rest);
  }

  /// Runs the bench and returns what --json says.
  Json run(std::vector<std::string> more = {}, const std::string& file = "b.yaml") {
    more.insert(more.begin(), {"bench", file, "--json", "--out", "out/b"});
    answer = (*this)(more);
    if (answer.out.empty()) throw std::runtime_error("no answer: " + answer.err);
    return Json::parse(answer.out);
  }

  Json summary() const { return Json::parse(read_file(work() / "out/b/bench.json")); }

  /// What was found in each cell, by key, without host and times.
  std::map<std::string, std::string> results(const std::string& store = "store") const {
    std::map<std::string, std::string> found;
    const auto cells = folder.path() / store / "cells";
    if (!std::filesystem::exists(cells)) return found;
    for (const auto& entry : std::filesystem::recursive_directory_iterator(cells))
      if (entry.is_regular_file())
        found[entry.path().stem().string()] = Json::parse(read_file(entry.path())).at("result").dump();
    return found;
  }

  Answer answer;

 private:
  static std::filesystem::path shared_folder(const std::vector<std::string>& plugins) {
    static TemporaryFolder folders;
    static std::map<std::vector<std::string>, std::filesystem::path> made;
    auto& path = made[plugins];
    if (path.empty()) {
      path = folders.path() / std::to_string(made.size());
      std::filesystem::create_directory(path);
      // The role that the story's nodes have is declared beside them.
      std::filesystem::create_symlink(std::filesystem::path(PLUMBLINE_STORY_PLUGIN).parent_path() / "roles",
                                      path / "roles");
      for (const std::string& plugin : plugins)
        std::filesystem::create_symlink(plugin, path / std::filesystem::path(plugin).filename());
    }
    return path;
  }
};

}  // namespace plumbline::test
