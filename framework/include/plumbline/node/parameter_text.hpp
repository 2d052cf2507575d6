// Parameter values as the text in which they cross the C ABI, and the kinds that plugin.h has for them.
#pragma once

#include <charconv>
#include <cmath>
#include <limits>
#include <string>
#include <string_view>
#include <vector>

#include "plumbline/node/declarations.hpp"
#include "plumbline/plugin.h"

namespace plumbline {

namespace detail {

inline std::string to_text(double v) {
  if (std::isnan(v)) return "nan";
  char buffer[40];
  const auto end = std::to_chars(buffer, buffer + sizeof buffer, v).ptr;  // shortest text that reads back the same
  return {buffer, end};
}
inline std::string to_text(int64_t v) { return std::to_string(v); }
inline std::string to_text(bool v) { return v ? "true" : "false"; }
inline std::string to_text(const std::string& v) { return v; }
inline std::string to_text(const FilePath& v) { return v.path; }
inline std::string to_text(const FolderPath& v) { return v.path; }
template <typename T>
std::string to_text(const std::vector<T>& list) {
  std::string text;
  for (size_t i = 0; i < list.size(); ++i) text += (i ? "\x1f" : "") + to_text(list[i]);
  return text;
}

inline void from_text(std::string_view text, double& v) {
  if (text == "nan") {
    v = std::numeric_limits<double>::quiet_NaN();
    return;
  }
  std::from_chars(text.data(), text.data() + text.size(), v);
}
inline void from_text(std::string_view text, int64_t& v) { std::from_chars(text.data(), text.data() + text.size(), v); }
inline void from_text(std::string_view text, bool& v) { v = text == "true"; }
inline void from_text(std::string_view text, std::string& v) { v = text; }
inline void from_text(std::string_view text, FilePath& v) { v.path = text; }
inline void from_text(std::string_view text, FolderPath& v) { v.path = text; }
template <typename T>
void from_text(std::string_view text, std::vector<T>& list) {
  list.clear();
  while (!text.empty()) {
    const size_t end = text.find('\x1f');
    from_text(text.substr(0, end), list.emplace_back());
    if (end == std::string_view::npos) break;
    text.remove_prefix(end + 1);
  }
}

template <typename T>
struct ParamKind;
template <>
struct ParamKind<double> {
  static constexpr uint32_t kind = PLUMBLINE_NUMBER, is_list = 0;
};
template <>
struct ParamKind<int64_t> {
  static constexpr uint32_t kind = PLUMBLINE_INTEGER, is_list = 0;
};
template <>
struct ParamKind<bool> {
  static constexpr uint32_t kind = PLUMBLINE_BOOLEAN, is_list = 0;
};
template <>
struct ParamKind<std::string> {
  static constexpr uint32_t kind = PLUMBLINE_TEXT, is_list = 0;
};
template <>
struct ParamKind<FilePath> {
  static constexpr uint32_t kind = PLUMBLINE_FILE, is_list = 0;
};
template <>
struct ParamKind<FolderPath> {
  static constexpr uint32_t kind = PLUMBLINE_FOLDER, is_list = 0;
};
template <typename T>
struct ParamKind<std::vector<T>> {
  static constexpr uint32_t kind = ParamKind<T>::kind, is_list = 1;
};

}  // namespace detail

}  // namespace plumbline
