// Sizes and times as people write them.
#pragma once

#include <cstdint>
#include <optional>
#include <string>

namespace plumbline::runtime {

/// What one run of a node in a process of its own may take; 0: as much as there is.
struct Limits {
  double seconds = 0;   ///< of time; waiting for memory that others hold does not count
  uint64_t memory = 0;  ///< bytes of data
};

/// "3GiB", "500 MB", "1.5g" or plain bytes; k, M, G, T are powers of 1024 with or without "iB", and of 1000 with "B".
std::optional<uint64_t> parse_bytes(const std::string& text);

/// "90", "90 s", "1.5 min", "2 h" in seconds.
std::optional<double> parse_seconds(const std::string& text);

}  // namespace plumbline::runtime
