// The stored files of a ZIP.
#pragma once

#include <map>
#include <string>

namespace plumbline::test {

/// The stored files of a ZIP by name.
inline std::map<std::string, std::string> unzipped(const std::string& bytes) {
  std::map<std::string, std::string> files;
  const auto number = [&](std::size_t at, int count) {
    std::size_t value = 0;
    for (int i = count - 1; i >= 0; --i)
      value = value << 8 | static_cast<unsigned char>(bytes[at + static_cast<std::size_t>(i)]);
    return value;
  };
  for (std::size_t at = 0; number(at, 4) == 0x04034b50;) {
    const std::size_t size = number(at + 18, 4), name = number(at + 26, 2);
    files[bytes.substr(at + 30, name)] = bytes.substr(at + 30 + name, size);
    at += 30 + name + size;
  }
  return files;
}

}  // namespace plumbline::test
