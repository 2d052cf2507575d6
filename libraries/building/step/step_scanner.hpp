// The cursor that the two passes of the Part 21 reader share; private to ifc/step*.cpp.
#pragma once

#include <string>
#include <string_view>
#include <vector>

#include "building/step/step.hpp"

namespace plumbline::step {

/// Nesting beyond this is no model but an attack on the stack.
inline constexpr int kDeepest = 100;

std::string place(std::string_view bytes, const std::string& name, std::size_t offset);

inline constexpr bool is_letter(char c) {
  return (c >= 'A' && c <= 'Z') || (c >= 'a' && c <= 'z') || c == '_' || c == '!';
}
inline constexpr bool is_digit(char c) { return c >= '0' && c <= '9'; }
inline constexpr char upper(char c) { return c >= 'a' && c <= 'z' ? static_cast<char>(c - 'a' + 'A') : c; }

class Scanner {
 public:
  Scanner(std::string_view bytes, const std::string& name, std::size_t from = 0)
      : at(from), bytes_(bytes), name_(name) {}

  std::size_t at;

  bool ended() const { return at >= bytes_.size(); }
  char peek() const { return ended() ? '\0' : bytes_[at]; }
  bool starts_with(std::string_view text) const { return bytes_.substr(at, text.size()) == text; }

  void skip_blank() {  ///< white space and comments
    if (const auto c = static_cast<unsigned char>(peek()); ended() || c <= ' ' || c == '/') skip_blanks();
  }
  void skip_string();                    ///< at its opening quote; doubled quotes need no care here
  void skip_arguments();                 ///< at '('; leaves the cursor behind the ')' that closes it
  void skip_instance(std::uint64_t id);  ///< at '('; leaves the cursor behind the ';' of the instance
  std::string read_keyword();            ///< in capitals
  std::uint64_t read_number();           ///< digits of an instance number
  bool accept(char wanted) {
    if (ended() || peek() != wanted) return false;
    ++at;
    return true;
  }
  void expect(char wanted, const char* where) {
    if (!accept(wanted)) fail(std::string("'") + wanted + "' " + where);
  }

  Value read_value(int depth);
  std::vector<Value> read_list(int depth);  ///< at '('

  /// "name:line:column: found …, expected …", at the cursor.
  [[noreturn]] void fail(const std::string& expected) const;
  [[noreturn]] void fail_at(std::size_t offset, const std::string& message) const;

 private:
  void skip_blanks();
  Value read_scalar_number();
  std::string read_text();
  std::string_view bytes_;
  const std::string& name_;
};

}  // namespace plumbline::step
