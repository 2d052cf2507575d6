// A journal that lies where a run delivers to is not replaced by one that lacks what was reported to it.
#pragma once

#include <filesystem>
#include <istream>
#include <string>
#include <vector>

#include "runtime/run/executor.hpp"

namespace plumbline::runtime {

/// Holds what a run would do to journals against what is there: to that in its own folder, and to that of the run
/// whose state it goes on from. While it lives no other run on that state is let through.
class JournalGuard {
 public:
  /// `out`: where outputs named journal.jsonl are delivered to. Where nothing forbids it, notes beside the journal that
  /// this run goes on from (a file that it read lies beside it) that `out` follows it: journal.next.
  JournalGuard(const Graph& graph, Store& store, const RunResult& result, std::filesystem::path out);
  ~JournalGuard();
  JournalGuard(const JournalGuard&) = delete;
  JournalGuard& operator=(const JournalGuard&) = delete;

  /// Why nothing is to be written, in words with what to do; empty: nothing forbids it. Forbidden is a journal that
  /// lacks reports of the one that lies there, one that goes on from where a run in another folder has gone
  /// on from already, and another one where a run has gone on from what lies there. Reports are lines that say who did
  /// something and when (`by` and `at`; not what the program itself says). What is simulated has no date, and may be
  /// run anew.
  const std::string& refusal() const { return refusal_; }
  /// What cannot be watched, in words; empty: nothing.
  const std::string& warning() const { return warning_; }

 private:
  void follow(const std::filesystem::path& before, const std::string& now);
  void refuse_another(const std::filesystem::path& before, const std::filesystem::path& other);

  std::filesystem::path out_;
  std::string refusal_, warning_;
  std::vector<int> locks_;
};

/// Of two journals, one JSON object a line, the reports of `there` that `now` lacks, as "ITEM by WHO at WHEN".
std::vector<std::string> missing_reports(std::istream& there, std::istream& now);

}  // namespace plumbline::runtime
