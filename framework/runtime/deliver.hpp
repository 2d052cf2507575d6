// Puts the named outputs of a pipeline where the user asked.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "runtime/executor.hpp"

namespace plumbline::runtime {

struct Delivery {
  std::string file;     ///< name under the output folder
  std::string problem;  ///< empty: it is there; else why not
};

/// Writes every output whose node succeeded: a File as its bytes, a Folder as a copy of its tree (its list of files, if
/// the name ends in .json), a list of Files as a folder of them, any other artifact as JSON, a list of them as a JSON
/// array. Each is written under a temporary name beside its place and renamed, so that it is whole or absent. Of an
/// output whose node did not succeed, what an earlier run left there is removed: it would be taken for this run's.
/// Throws std::runtime_error if the output folder cannot be made.
std::vector<Delivery> deliver(const Graph& graph, const Registry& registry, Store& store, const RunResult& result,
                              const std::filesystem::path& out);

/// An artifact of the store as JSON. Throws StoreError if it is missing, std::runtime_error if it is no valid `type`.
std::string blob_to_json(Store& store, const plumbline_type& type, const std::string& hash);

/// Writes a file under a temporary name beside its place and renames it. Throws std::runtime_error.
void write_file(const std::filesystem::path& path, const void* data, size_t size);

}  // namespace plumbline::runtime
