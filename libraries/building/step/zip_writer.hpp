// A ZIP archive of stored files, without dates: the same content gives the same bytes (PKWARE APPNOTE 6.3, parts 4.3.7
// to 4.3.16).
#pragma once

#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

namespace plumbline::step {

class ZipWriter {
 public:
  /// `name` with '/' between folders.
  void add(const std::string& name, std::string_view content);
  std::string finish();

 private:
  struct Entry {
    std::string name;
    std::uint32_t crc, size, offset;
  };
  std::string bytes_;
  std::vector<Entry> entries_;
};

}  // namespace plumbline::step
