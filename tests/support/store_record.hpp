// Records of runs in a store, for tests that change them as a tool or a crash would.
#pragma once

#include <fstream>
#include <nlohmann/json.hpp>
#include <string>

#include "runtime/base/digest.hpp"
#include "test_support.hpp"

namespace plumbline::test {

/// The record's first line; the second is its check.
inline nlohmann::json stored_record(const std::filesystem::path& file) {
  const std::string text = read_file(file);
  return nlohmann::json::parse(text.substr(0, text.find('\n')), nullptr, false);
}

/// Writes a record with the check that belongs to it.
inline void store_record(const std::filesystem::path& file, const nlohmann::json& record) {
  const std::string line = record.dump() + "\n";
  std::ofstream(file, std::ios::trunc) << line << runtime::sha256_of(line.data(), line.size()) << "\n";
}

}  // namespace plumbline::test
