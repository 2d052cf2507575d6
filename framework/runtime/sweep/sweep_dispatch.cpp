#include "runtime/sweep/sweep_dispatch.hpp"

#include <sys/wait.h>

#include <algorithm>
#include <array>
#include <cstdio>
#include <filesystem>
#include <fstream>
#include <stdexcept>

#include "runtime/base/new_file.hpp"

namespace plumbline::runtime {

namespace fs = std::filesystem;

namespace {

struct Output {
  std::string text;
  int exit_code = 0;
};

/// Runs a command line and returns what it said on both streams.
Output call(const std::string& command) {
  Output output;
  FILE* pipe = popen((command + " 2>&1").c_str(), "r");
  if (!pipe) throw std::runtime_error("cannot run '" + command + "'");
  std::array<char, 4096> buffer{};
  while (const size_t got = fread(buffer.data(), 1, buffer.size(), pipe)) output.text.append(buffer.data(), got);
  const int status = pclose(pipe);
  output.exit_code = WIFEXITED(status) ? WEXITSTATUS(status) : 128;
  return output;
}

void need(const std::string& program, const std::string& package) {
  if (call("command -v " + program).exit_code != 0)
    throw std::runtime_error("there is no program '" + program + "' here; install " + package +
                             ", or use --executor print and run the commands yourself");
}

std::vector<std::string> task_command(const DispatchOptions& options, const std::string& number) {
  std::vector<std::string> words = options.command;
  words.insert(words.end(), {"--task", number});
  return words;
}

void write_file(const fs::path& path, const std::string& text) {
  std::error_code ignored;
  fs::remove(path, ignored);
  write_new_file(path, text.data(), text.size());
}

fs::path folder_of(const SweepPlan& plan, const Store& store) {
  const fs::path folder = store.folder() / "sweeps" / plan.id;
  fs::create_directories(folder);
  return folder;
}

void submit(const SweepPlan& plan, const Store& store, const DispatchOptions& options, const std::vector<size_t>& tasks,
            Dispatched& sent) {
  need("sbatch", "slurm-client");
  const fs::path folder = folder_of(plan, store), script = folder / "task.sh";
  // The array index is the task's number. Slurm starts the task again when a node fails (--requeue); what it had done
  // is in the store.
  const std::string text = "#!/bin/sh\n#SBATCH --job-name=plumbline-bench\n#SBATCH --requeue\n#SBATCH --output=" +
                           (folder / "task-%a.log").string() + "\n#SBATCH --open-mode=append\nexec " +
                           shell_text(options.command) + " --task \"$SLURM_ARRAY_TASK_ID\"\n";
  write_file(script, text);
  const Output output = call("sbatch --parsable --array=" + array_text(tasks) +
                             (options.scheduler_options.empty() ? "" : " " + options.scheduler_options) + " " +
                             shell_text({script.string()}));
  if (output.exit_code != 0) throw std::runtime_error("sbatch refuses: " + output.text);
  std::string job = output.text.substr(0, output.text.find_first_of("\n;"));
  sent.text = "Slurm job " + job + ": " + std::to_string(sent.cells) + " cells in " + std::to_string(sent.tasks) +
              " tasks; logs in " + folder.string() + ". This program need not wait: ask with --status.\n";
}

void run_parallel(const SweepPlan& plan, const Store& store, const DispatchOptions& options,
                  const std::vector<size_t>& tasks, Dispatched& sent) {
  // moreutils has another program of that name.
  if (call("parallel --version").text.find("GNU parallel") == std::string::npos)
    throw std::runtime_error(
        "there is no GNU parallel here; install the package parallel, or use --executor print and "
        "run the commands yourself");
  if (options.hosts.empty()) throw std::runtime_error("--executor ssh needs --hosts HOST,HOST,… (':' is this machine)");
  const fs::path list = folder_of(plan, store) / "tasks.txt";
  std::string lines, hosts;
  for (const size_t task : tasks) lines += shell_text(task_command(options, std::to_string(task))) + "\n";
  write_file(list, lines);
  for (const std::string& host : options.hosts) hosts += (hosts.empty() ? "" : ",") + host;
  const Output output = call("parallel --will-cite --halt never --retries 3 --workdir . --sshlogin " +
                             shell_text({hosts}) + " --arg-file " + shell_text({list.string()}));
  sent.exit_code = output.exit_code;
  sent.text = output.text;
  if (output.exit_code != 0)
    sent.text += "parallel ended with code " + std::to_string(output.exit_code) + ": some tasks did not end well on " +
                 hosts + "; what they finished is kept, and the same command sends what is missing\n";
}

}  // namespace

std::vector<size_t> open_tasks(const SweepPlan& plan, const std::vector<std::vector<size_t>>& chunks,
                               const CellRecords& records, bool retry) {
  std::vector<size_t> tasks;
  for (size_t k = 0; k < chunks.size(); ++k) {
    const bool open = std::any_of(chunks[k].begin(), chunks[k].end(), [&](size_t index) {
      const auto record = records.find(plan.cells[index].key);
      return !record || (retry && record->failed);
    });
    if (open) tasks.push_back(k);
  }
  return tasks;
}

std::string array_text(const std::vector<size_t>& numbers) {
  std::string text;
  for (size_t i = 0; i < numbers.size();) {
    size_t end = i;
    while (end + 1 < numbers.size() && numbers[end + 1] == numbers[end] + 1) ++end;
    text += (text.empty() ? "" : ",") + std::to_string(numbers[i]);
    if (end > i) text += "-" + std::to_string(numbers[end]);
    i = end + 1;
  }
  return text;
}

std::string shell_text(const std::vector<std::string>& words) {
  std::string text;
  for (const std::string& word : words) {
    const bool plain = !word.empty() && word.find_first_not_of(
                                            "abcdefghijklmnopqrstuvwxyzABCDEFGHIJKLMNOPQRSTUVWXYZ"
                                            "0123456789_-./=:,@%+") == std::string::npos;
    std::string quoted = word;
    if (!plain) {
      quoted = "'";
      for (const char c : word) quoted += c == '\'' ? std::string("'\\''") : std::string(1, c);
      quoted += "'";
    }
    text += (text.empty() ? "" : " ") + quoted;
  }
  return text;
}

size_t task_size(const SweepPlan& plan, size_t wished) {
  return std::max(std::clamp<size_t>(wished, 1, 100), (plan.cells.size() + 999) / 1000);
}

Dispatched dispatch(const SweepPlan& plan, Store& store, const DispatchOptions& options) {
  const auto chunks = chunks_of(plan, task_size(plan, options.cells_per_task));
  const std::vector<size_t> tasks = open_tasks(plan, chunks, CellRecords(store), options.retry);
  Dispatched sent;
  sent.tasks = tasks.size();
  for (const size_t task : tasks) sent.cells += chunks[task].size();
  if (tasks.empty()) {
    sent.text = "nothing is left to do\n";
  } else if (options.executor == "slurm") {
    submit(plan, store, options, tasks, sent);
  } else if (options.executor == "ssh") {
    run_parallel(plan, store, options, tasks, sent);
  } else {
    for (const size_t task : tasks) sent.text += shell_text(task_command(options, std::to_string(task))) + "\n";
  }
  return sent;
}

}  // namespace plumbline::runtime
