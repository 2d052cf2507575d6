// Bytes that go from one process of this machine to another: numbers in the machine's order, texts and bytes after
// their length.
#pragma once

#include <cstdint>
#include <cstring>
#include <stdexcept>
#include <string>
#include <utility>

namespace plumbline::runtime {

class WireWriter {
 public:
  template <typename Number>
  void number(Number value) {
    bytes_.append(reinterpret_cast<const char*>(&value), sizeof value);
  }
  void bytes(const void* data, size_t size) {
    number(static_cast<uint64_t>(size));
    if (size) bytes_.append(static_cast<const char*>(data), size);
  }
  void text(const char* text) {
    number(static_cast<uint8_t>(text != nullptr));
    if (text) bytes(text, std::strlen(text));
  }
  void text(const std::string& text) { this->text(text.c_str()); }
  std::string take() { return std::move(bytes_); }

 private:
  std::string bytes_;
};

/// Throws std::runtime_error where the bytes end too early.
class WireReader {
 public:
  explicit WireReader(const std::string& bytes) : bytes_(bytes) {}
  template <typename Number>
  Number number() {
    Number value;
    std::memcpy(&value, take(sizeof value), sizeof value);
    return value;
  }
  uint32_t count() {
    const auto value = number<uint32_t>();
    if (value > bytes_.size()) fail();  // every entry takes at least a byte
    return value;
  }
  std::string bytes() {
    const auto size = number<uint64_t>();
    const char* data = take(size);
    return {data, static_cast<size_t>(size)};
  }
  bool there() { return number<uint8_t>() != 0; }
  std::string text() { return there() ? bytes() : std::string(); }
  void end() const {
    if (at_ != bytes_.size()) fail();
  }

 private:
  [[noreturn]] static void fail() { throw std::runtime_error("bytes from another process end too early or too late"); }
  const char* take(uint64_t size) {
    if (size > bytes_.size() - at_) fail();
    at_ += size;
    return bytes_.data() + at_ - size;
  }
  const std::string& bytes_;
  size_t at_ = 0;
};

}  // namespace plumbline::runtime
