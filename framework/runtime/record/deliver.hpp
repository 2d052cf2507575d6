// Puts the named outputs of a pipeline where the user asked.
#pragma once

#include <atomic>
#include <filesystem>
#include <string>
#include <vector>

#include "runtime/record/output_folder.hpp"
#include "runtime/run/executor.hpp"

namespace plumbline::runtime {

struct Delivery {
  std::string file;     ///< name under the output folder
  std::string problem;  ///< empty: it is there; else why not
  std::string note;     ///< what people should know of it, mostly empty
};

/// What stands in the way of delivering the pipeline's outputs to the folder, a sentence each; empty: nothing. To be
/// asked before anything runs.
std::vector<std::string> obstacles_to(const Graph& graph, const OutputFolder& out);

/// Writes every output whose node succeeded: a File as its bytes, a Folder as a copy of its tree (its list of files, if
/// the name ends in .json), a list of Files as a folder of them, any other artifact as JSON, a list of them as a JSON
/// array. Each is put in place whole or not at all, and not written again if it is there already. Of an output whose
/// node did not succeed, what an earlier run left there is removed: it would be taken for this run's. The record must
/// have been begun in `out`. When `stop` is set, outputs that are not begun yet are left as they are, with a problem.
std::vector<Delivery> deliver(const Graph& graph, Store& store, const RunResult& result, OutputFolder& out,
                              const std::atomic<bool>* stop = nullptr);

/// An artifact of the store as JSON. Throws StoreError if it is missing, std::runtime_error if it is no valid `type`.
std::string blob_to_json(Store& store, const plumbline_type& type, const std::string& hash);

}  // namespace plumbline::runtime
