// The results of cells in the store: cells/ab/<key>.json. The only state a sweep has; any number of programs on any
// number of machines may write the same record at the same time, because each writes the same result and renames it
// into place. What a run happened to be (host, times) stands apart from what it found.
#pragma once

#include <map>
#include <optional>
#include <string>
#include <vector>

#include "runtime/store/store.hpp"

namespace plumbline::runtime {

struct CellRecord {
  bool failed = false;
  std::string error, failed_node;         ///< why, and where
  std::map<std::string, Metric> metrics;  ///< by NODE.METRIC
  std::vector<std::string> warnings;      ///< "NODE: text"
  /// Hash of what each node got, by node: equal starts have equal hashes. What kinds of its role may lack stands by
  /// itself, as "node.port".
  std::map<std::string, std::string> inputs;
  std::map<std::string, double> seconds;  ///< of the nodes that ran now and were not taken from the store
  std::string host, run;                  ///< run: of which call of the program; empty: not known
};

class CellRecords {
 public:
  explicit CellRecords(const Store& store) : folder_(store.folder() / "cells"), temporary_(store.folder() / "tmp") {}
  /// Nothing if there is none, or a damaged one: then the cell runs again.
  std::optional<CellRecord> find(const std::string& key) const;
  void put(const std::string& key, const CellRecord& record) const;  ///< throws StoreError
  /// What was found, without what the run happened to be; as text that can be compared byte by byte.
  static std::string result_text(const CellRecord& record);

 private:
  std::filesystem::path path(const std::string& key) const { return folder_ / key.substr(0, 2) / (key + ".json"); }
  std::filesystem::path folder_, temporary_;
};

}  // namespace plumbline::runtime
