// JSON written as it comes, without a tree in between: a line of the record costs a tenth of what the tree costs, and
// there is one for every node.
#pragma once

#include <cstddef>
#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

namespace plumbline::runtime {

/// A JSON string of it. Text that is no UTF-8 is written with U+FFFD in place of each wrong byte.
std::string json_quoted(std::string_view text);

/// A tree (nlohmann::json, nlohmann::ordered_json) on one line; texts as json_quoted() writes them.
template <typename Json>
std::string json_line(const Json& tree) {
  return tree.dump(-1, ' ', false, Json::error_handler_t::replace);
}

/// Objects and arrays are opened and closed by the caller, in pairs; commas come by themselves. Text as
/// json_quoted() writes it; a number that is not finite as null.
class JsonText {
 public:
  JsonText& open(char bracket);   ///< '{' or '['
  JsonText& close(char bracket);  ///< '}' or ']'
  JsonText& name(std::string_view text);
  JsonText& value(std::string_view text);
  JsonText& value(const char* text) { return value(std::string_view(text)); }
  JsonText& value(double number);
  JsonText& value(std::uint64_t number);
  JsonText& value(const std::vector<std::string>& texts);
  /// name and value at once
  template <typename Value>
  JsonText& field(std::string_view key, const Value& content) {
    return name(key).value(content);
  }
  std::string take() { return std::move(text_); }

 private:
  void comma();
  std::string text_;
};

}  // namespace plumbline::runtime
