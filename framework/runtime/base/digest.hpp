// SHA-256, by OpenSSL.
#pragma once

#include <cstddef>
#include <filesystem>
#include <memory>
#include <string>
#include <string_view>

struct evp_md_ctx_st;

namespace plumbline::runtime {

/// Incremental SHA-256.
class Sha256 {
 public:
  Sha256();
  ~Sha256();
  Sha256(const Sha256&) = delete;
  Sha256& operator=(const Sha256&) = delete;
  void add(const void* data, size_t size);
  /// Adds the length of the text and the text, so that ("ab", "c") and ("a", "bc") differ.
  void add_field(std::string_view text);
  std::string hex();  ///< 64 digits; the object cannot be used afterwards

 private:
  evp_md_ctx_st* context_;
};

std::string sha256_of(const void* data, size_t size);
/// Whether the text could be such a hash: 64 digits, small letters.
bool is_hash(std::string_view text);
/// Throws std::runtime_error, naming the file, if it cannot be read.
std::string sha256_of_file(const std::filesystem::path& path);

}  // namespace plumbline::runtime
