// The commands of the program and their options, as CLI11 takes them.
#pragma once

#include <functional>
#include <vector>

#include "bench.hpp"
#include "commands.hpp"

namespace CLI {
class App;
}

namespace plumbline::cli {

struct Command {
  CLI::App* app;
  std::function<int(const Options&)> action;
};

/// Declares every command on `app`; parsing it fills `options`, or `bench_options` for `bench`. A command below another
/// one stands after it.
std::vector<Command> declare_commands(CLI::App& app, Options& options, BenchOptions& bench_options);

}  // namespace plumbline::cli
