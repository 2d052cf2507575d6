// Parameter values as the text in which they cross the C ABI, and the kinds that plugin.h has for them.
#pragma once

#include <algorithm>
#include <charconv>
#include <cmath>
#include <concepts>
#include <limits>
#include <string>
#include <string_view>
#include <utility>
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
template <typename T>
concept Integer = std::integral<T> && !std::same_as<T, bool> && !std::same_as<T, char> && !std::same_as<T, wchar_t>;

inline std::string to_text(bool v) { return v ? "true" : "false"; }
template <Integer T>
std::string to_text(T v) {
  return std::to_string(v);
}
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
template <Integer T>
void from_text(std::string_view text, T& v) {
  std::from_chars(text.data(), text.data() + text.size(), v);
}
inline void from_text(std::string_view text, bool& v) { v = text == "true"; }
inline void from_text(std::string_view text, std::string& v) { v = text; }
inline void from_text(std::string_view text, FilePath& v) { v.path = text; }
inline void from_text(std::string_view text, FolderPath& v) { v.path = text; }
template <typename T>
void from_text(std::string_view text, std::vector<T>& list) {
  list.clear();
  while (!text.empty()) {
    const size_t end = text.find('\x1f');
    T item{};
    from_text(text.substr(0, end), item);
    list.push_back(std::move(item));
    if (end == std::string_view::npos) break;
    text.remove_prefix(end + 1);
  }
}

template <uint32_t Kind>
struct KnownKind {
  static constexpr bool known = true;
  static constexpr uint32_t kind = Kind, is_list = 0;
};
template <typename T>
struct ParamKind {
  static constexpr bool known = false;
  static constexpr uint32_t kind = PLUMBLINE_TEXT, is_list = 0;
};
template <>
struct ParamKind<double> : KnownKind<PLUMBLINE_NUMBER> {};
template <Integer T>
struct ParamKind<T> : KnownKind<PLUMBLINE_INTEGER> {};
template <>
struct ParamKind<bool> : KnownKind<PLUMBLINE_BOOLEAN> {};
template <>
struct ParamKind<std::string> : KnownKind<PLUMBLINE_TEXT> {};
template <>
struct ParamKind<FilePath> : KnownKind<PLUMBLINE_FILE> {};
template <>
struct ParamKind<FolderPath> : KnownKind<PLUMBLINE_FOLDER> {};
template <typename T>
struct ParamKind<std::vector<T>> {
  static constexpr bool known = ParamKind<T>::known && !ParamKind<T>::is_list;
  static constexpr uint32_t kind = ParamKind<T>::kind, is_list = 1;
};

/// The bounds of an integer parameter end where its type does; texts cross as int64.
template <typename T>
Bounds within_type(Bounds bounds) {
  if constexpr (Integer<T>) {
    using Limits = std::numeric_limits<T>;
    if constexpr (sizeof(T) < sizeof(int64_t) || Limits::min() == 0)
      bounds.minimum = std::max(bounds.minimum, static_cast<double>(Limits::min()));
    if constexpr (sizeof(T) < sizeof(int64_t))
      bounds.maximum = std::min(bounds.maximum, static_cast<double>(Limits::max()));
  }
  return bounds;
}
template <typename List>
requires Integer<typename List::value_type> && std::same_as<List, std::vector<typename List::value_type>> Bounds
within_type(Bounds bounds) {
  return within_type<typename List::value_type>(bounds);
}

}  // namespace detail

}  // namespace plumbline
