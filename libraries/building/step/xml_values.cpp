#include "building/step/xml_values.hpp"

#include <algorithm>
#include <cctype>
#include <charconv>
#include <set>

#include "base/text/text.hpp"
#include "building/step/step_writer.hpp"
#include "building/step/xml_schema.hpp"

namespace plumbline::step {
namespace {

/// What exporters write where they have no number: "NaN", "NAN(SNAN)", "-inf".
bool is_no_number(std::string_view lower) {
  if (lower.starts_with('-') || lower.starts_with('+')) lower.remove_prefix(1);
  return lower == "nan" || (lower.starts_with("nan(") && lower.ends_with(')')) || lower == "inf" || lower == "infinity";
}

/// The digits as they were written, with the point that STEP demands.
std::optional<std::string> number(std::string_view text, bool whole) {
  if (text.empty() || is_no_number(text::to_lower(text))) return null;
  if (!text::parse_number(text)) return std::nullopt;
  if (text.front() == '+') text.remove_prefix(1);
  const std::size_t exponent = std::min(text.find_first_of("eE"), text.size());
  std::string digits(text.substr(0, exponent));
  const std::size_t point = digits.find('.');
  if (whole) {
    const bool integral = point == std::string::npos || digits.find_first_not_of('0', point + 1) == std::string::npos;
    if (!integral || exponent < text.size()) return std::nullopt;
    return digits.substr(0, point);
  }
  if (point == std::string::npos) digits += '.';
  if (digits[0] == '.') digits.insert(0, "0");
  if (digits.starts_with("-.")) digits.insert(1, "0");
  return exponent < text.size() ? digits + "E" + std::string(text.substr(exponent + 1)) : digits;
}

std::optional<std::string> truth(std::string_view text, bool may_be_unknown) {
  const std::string lower = text::to_lower(text);
  if (lower.empty()) return null;
  if (lower == "true" || lower == "1" || lower == "t" || lower == ".t.") return ".T.";
  if (lower == "false" || lower == "0" || lower == "f" || lower == ".f.") return ".F.";
  if (may_be_unknown && (lower == "unknown" || lower == "u" || lower == ".u.")) return ".U.";
  return std::nullopt;
}

std::optional<std::string> enumerated(std::string_view text) {
  if (text.empty()) return null;
  const bool is_name =
      std::all_of(text.begin(), text.end(), [](unsigned char c) { return std::isalnum(c) || c == '_'; });
  return is_name ? std::optional(enumeration(capitals(text))) : std::nullopt;
}

std::optional<std::string> binary(std::string_view text) {
  if (text.empty()) return null;
  const bool is_hex = std::all_of(text.begin(), text.end(), [](unsigned char c) { return std::isxdigit(c) != 0; });
  return is_hex ? std::optional("\"0" + capitals(text) + "\"") : std::nullopt;
}

/// Items of inner lists that all have `size` become lists.
std::optional<std::vector<std::string>> in_groups(const std::vector<std::string>& items, std::size_t size) {
  if (size == 0 || items.size() % size != 0) return std::nullopt;
  std::vector<std::string> groups;
  for (std::size_t i = 0; i < items.size(); i += size)
    groups.push_back(
        list({items.begin() + static_cast<std::ptrdiff_t>(i), items.begin() + static_cast<std::ptrdiff_t>(i + size)}));
  return groups;
}

}  // namespace

std::optional<std::string> argument_of(std::string_view text, std::string_view kind,
                                       const std::function<std::string_view(std::string_view)>& resolve) {
  if (kind == "s") return step::text(text);
  text = text::trim(text);
  if (kind == "r" || kind == "i") return number(text, kind == "i");
  if (kind == "b" || kind == "l") return truth(text, kind == "l");
  if (kind == "e") return enumerated(text);
  if (kind == "x") return binary(text);
  if (kind[0] != '[') return std::nullopt;
  if (text.empty()) return null;
  // "[0][3]r": the sizes from outside in, then what the innermost hold.
  std::vector<std::size_t> sizes;
  while (kind[0] == '[') {
    sizes.push_back(size_of_list(kind)), kind = resolve(kind.substr(kind.find(']') + 1));
  }
  std::vector<std::string> items;
  for (const std::string_view word : text::split_blanks(text)) {
    const auto one = argument_of(word, kind, resolve);
    if (!one || *one == null) return std::nullopt;  // a list has no gaps
    items.push_back(*one);
  }
  for (std::size_t level = sizes.size(); level-- > 1;) {
    const auto groups = in_groups(items, sizes[level]);
    if (!groups) return std::nullopt;
    items = *groups;
  }
  if (sizes[0] > 0 && items.size() != sizes[0]) return std::nullopt;
  return list(items);
}

std::size_t size_of_list(std::string_view kind) {
  std::size_t size = 0;
  if (kind.starts_with('[')) std::from_chars(kind.data() + 1, kind.data() + kind.find(']'), size);
  return size;
}

std::string words_of_kind(std::string_view kind) {
  switch (kind[0]) {
    case 's':
      return "a text";
    case 'r':
      return "a number";
    case 'i':
      return "a whole number";
    case 'b':
      return "true or false";
    case 'l':
      return "true, false or unknown";
    case 'x':
      return "hexadecimal digits";
    case 'e':
      return "a name of an enumeration";
    case '[':
      return "values with blanks between them, as many as lists of that kind have";
    default:
      return "an element with " + std::string(kind);
  }
}

std::string with_references(const std::string& given, const std::vector<std::uint64_t>& others) {
  std::vector<std::string> items;
  std::set<std::string> known;
  if (given.starts_with('('))
    for (const std::string_view item : text::split(given, ',')) {
      const std::string_view one = item.substr(item.starts_with('(') ? 1 : 0);
      items.emplace_back(one.substr(0, one.find(')'))), known.insert(items.back());
    }
  for (const std::uint64_t other : others)
    if (known.insert(reference(other)).second) items.push_back(reference(other));
  return list(items);
}

}  // namespace plumbline::step
