// Second pass: the arguments of one instance, and the decoding of strings.
#include <charconv>
#include <cmath>
#include <system_error>

#include "building/step/step_scanner.hpp"

namespace plumbline::step {
namespace {

void append_utf8(std::string& out, char32_t code) {
  if (code > 0x10FFFF || (code >= 0xD800 && code < 0xE000)) code = 0xFFFD;  // the replacement character
  if (code < 0x80) {
    out += static_cast<char>(code);
  } else if (code < 0x800) {
    out += static_cast<char>(0xC0 | (code >> 6));
    out += static_cast<char>(0x80 | (code & 63));
  } else if (code < 0x10000) {
    out += static_cast<char>(0xE0 | (code >> 12));
    out += static_cast<char>(0x80 | ((code >> 6) & 63));
    out += static_cast<char>(0x80 | (code & 63));
  } else {
    out += static_cast<char>(0xF0 | (code >> 18));
    out += static_cast<char>(0x80 | ((code >> 12) & 63));
    out += static_cast<char>(0x80 | ((code >> 6) & 63));
    out += static_cast<char>(0x80 | (code & 63));
  }
}

/// `count` hex digits at the front of `text`; false if there are fewer.
bool read_hex(std::string_view text, std::size_t count, char32_t& code) {
  std::uint32_t number = 0;
  if (text.size() < count) return false;
  const auto [end, error] = std::from_chars(text.data(), text.data() + count, number, 16);
  code = number;
  return error == std::errc{} && end == text.data() + count;
}

/// Length of the well-formed UTF-8 sequence of two bytes or more at the front; 0 if there is none.
std::size_t utf8_length(std::string_view text) {
  const auto first = static_cast<unsigned char>(text[0]);
  const std::size_t length = (first >> 5) == 6 ? 2 : (first >> 4) == 14 ? 3 : (first >> 3) == 30 ? 4 : 0;
  if (length == 0 || text.size() < length) return 0;
  for (std::size_t i = 1; i < length; ++i)
    if ((static_cast<unsigned char>(text[i]) & 0xC0) != 0x80) return 0;
  return length;
}

/// \X2\…\X0\ (UTF-16, so pairs of surrogates occur in the wild) or \X4\…\X0\; returns the bytes used, 0 if malformed.
std::size_t decode_wide(std::string_view text, std::string& out) {
  const std::size_t width = text[2] == '2' ? 4 : 8;
  std::string decoded;
  char32_t high = 0;
  std::size_t at = 4;
  while (text.substr(at, 4) != "\\X0\\") {
    char32_t code = 0;
    if (at >= text.size() || !read_hex(text.substr(at), width, code)) return 0;
    at += width;
    const bool low = code >= 0xDC00 && code < 0xE000;
    if (high && low)
      code = 0x10000 + ((high - 0xD800) << 10) + (code - 0xDC00);
    else if (high)
      append_utf8(decoded, high);
    const bool opens_pair = code >= 0xD800 && code < 0xDC00;
    high = opens_pair ? code : 0;
    if (!opens_pair) append_utf8(decoded, code);
  }
  if (high) append_utf8(decoded, high);
  out += decoded;
  return at + 4;
}

/// One control directive at a solidus; returns the bytes used. What is none is kept as it stands: exporters write
/// C:\Temp.
std::size_t decode_directive(std::string_view text, std::string& out) {
  const auto has = [&](std::string_view start) { return text.substr(0, start.size()) == start; };
  char32_t code = 0;
  if (has("\\\\")) return out += '\\', 2;
  if (has("\\X2\\") || has("\\X4\\")) {
    if (const std::size_t used = decode_wide(text, out)) return used;
  } else if (has("\\X\\") && read_hex(text.substr(3), 2, code)) {
    return append_utf8(out, code), 5;
  } else if (has("\\S\\") && text.size() > 3 && text[3] >= ' ') {
    // Upper half of the current ISO 8859 part. Parts other than 1 need \P?\ before, which IFC does not use.
    append_utf8(out, static_cast<char32_t>((static_cast<unsigned char>(text[3]) | 0x80)));
    return text.substr(3, 2) == "''" ? 5 : 4;
  } else if (text.size() > 3 && text[1] == 'P' && text[3] == '\\') {
    return 4;
  } else if (has("\\N\\")) {
    return out += '\n', 3;
  }
  out += '\\';
  return 1;
}

}  // namespace

std::string Scanner::read_text() {
  std::string raw;
  for (;;) {  // a quote inside the string is written twice, so that it reads as two strings side by side
    const std::size_t begin = at + 1;
    skip_string();
    raw.append(bytes_.substr(begin, at - 1 - begin));
    if (peek() != '\'') break;
    raw += '\'';
  }
  std::string out;
  out.reserve(raw.size());
  for (std::string_view rest = raw; !rest.empty();) {
    std::size_t used = 1;
    const auto byte = static_cast<unsigned char>(rest[0]);
    if (byte == '\\')
      used = decode_directive(rest, out);
    else if (byte >= 0x80 && (used = utf8_length(rest)) > 0)
      out.append(rest.substr(0, used));
    else if (byte >= 0x80)
      append_utf8(out, byte), used = 1;  // Latin-1 by exporters that do not escape
    else if (byte != '\n' && byte != '\r')
      out += rest[0];  // line breaks in a string are no part of it
    rest.remove_prefix(used);
  }
  return out;
}

Value Scanner::read_scalar_number() {
  const std::size_t begin = at;
  Value value;
  value.kind = Kind::integer;
  std::string digits;
  if (peek() == '+' || peek() == '-') digits.append(peek() == '-' ? "-" : ""), ++at;
  const std::size_t unsigned_begin = digits.size();
  while (is_digit(peek()) || peek() == '.' || peek() == 'e' || peek() == 'E') {
    const bool exponent = peek() == 'e' || peek() == 'E';
    if (!is_digit(peek())) value.kind = Kind::real;
    digits += bytes_[at++];
    if (exponent && (peek() == '+' || peek() == '-')) digits += bytes_[at++];
  }
  const char* last = digits.data() + digits.size();
  const auto [end, error] = std::from_chars(digits.data(), last, value.number);
  const bool too_small =
      error == std::errc::result_out_of_range && digits.find('-', unsigned_begin) != std::string::npos;
  if (too_small)
    value.number = 0;
  else if (error != std::errc{} || end != last)
    fail_at(begin, "found '" + digits.substr(0, 40) + "', expected a number of double precision");
  return value;
}

Value Scanner::read_value(int depth) {
  if (depth > kDeepest) fail_at(at, "found arguments nested deeper than " + std::to_string(kDeepest));
  Value value;
  const char c = peek();
  if (c == '$' || c == '*') {
    value.kind = c == '$' ? Kind::null : Kind::derived;
    ++at;
  } else if (c == '\'') {
    value.kind = Kind::text;
    value.text = read_text();
  } else if (c == '#') {
    ++at;
    value.kind = Kind::reference;
    value.id = read_number();
  } else if (c == '(') {
    value.kind = Kind::list;
    value.items = read_list(depth + 1);
  } else if (c == '"') {
    const std::size_t begin = at + 1;
    skip_string();
    value.kind = Kind::binary;
    value.text = bytes_.substr(begin, at - 1 - begin);
  } else if (c == '.' && at + 1 < bytes_.size() && is_letter(bytes_[at + 1])) {
    ++at;
    value.kind = Kind::enumeration;
    value.text = read_keyword();
    expect('.', "at the end of an enumeration value");
  } else if (is_digit(c) || c == '+' || c == '-' || c == '.') {
    return read_scalar_number();
  } else if (is_letter(c)) {
    value.kind = Kind::typed;
    value.text = read_keyword();
    skip_blank();
    if (peek() != '(') fail("'(' after " + value.text);
    value.items = read_list(depth + 1);
  } else {
    fail("an argument");
  }
  return value;
}

std::vector<Value> Scanner::read_list(int depth) {
  std::vector<Value> items;
  expect('(', "at the start of a list");
  skip_blank();
  if (accept(')')) return items;
  for (;;) {
    skip_blank();
    // Some exporters leave out an argument and its sign: IFCSIUNIT(,.LENGTHUNIT.,$,.METRE.). Whoever needs it finds $.
    items.push_back(peek() == ',' || peek() == ')' ? Value{} : read_value(depth));
    skip_blank();
    if (accept(')')) return items;
    if (!accept(',')) fail("',' or ')' after an argument");
  }
}

std::vector<Value> File::arguments(const Instance& instance) const {
  Scanner scanner(bytes_, name_, arguments_at(instance));
  if (type_name(instance).empty())
    scanner.fail_at(instance.begin, "found a complex instance, expected one keyword with its arguments");
  std::vector<Value> values = scanner.read_list(0);
  scanner.skip_blank();
  scanner.expect(';', ("at the end of #" + std::to_string(instance.id)).c_str());
  return values;
}

std::vector<Record> File::records(const Instance& instance) const {
  if (!type_name(instance).empty()) return {{type_name(instance), arguments(instance)}};
  std::vector<Record> parts;
  Scanner scanner(bytes_, name_, arguments_at(instance));
  scanner.expect('(', "at the start of a complex instance");
  for (;;) {
    scanner.skip_blank();
    if (scanner.accept(')')) return parts;
    std::string keyword = scanner.read_keyword();
    scanner.skip_blank();
    parts.push_back({std::move(keyword), scanner.read_list(0)});
  }
}

}  // namespace plumbline::step
