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
  static constexpr std::size_t kMostEntries = 65535;

  /// `name` with '/' between folders.
  void add(const std::string& name, std::string_view content);
  /// Throws std::runtime_error if the archive is larger than its format can say.
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
