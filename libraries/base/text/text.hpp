// What every reader of text files needs, whatever the format: bytes of any common encoding become UTF-8, text becomes
// numbered lines, a token becomes a finite number or nothing. Survey files come from forty years of instruments:
// CR-only line ends, UTF-16 exports, Windows-1252 remarks and 'nan' tokens are normal input here, never an exception.
#pragma once

#include <concepts>
#include <cstddef>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

namespace plumbline::text {

enum class Encoding { utf8, utf16_little_endian, utf16_big_endian, windows_1252 };

/// Name of an encoding for messages, e.g. "UTF-16 (little endian)".
const char* name_of(Encoding encoding);

struct DecodedText {
  std::string text;  ///< UTF-8 without byte order mark
  Encoding encoding = Encoding::utf8;
};

/// UTF-8 of `bytes`. A byte order mark decides; else two-byte text with a zero in every other of its first bytes is
/// UTF-16; else valid UTF-8 is UTF-8; else Windows-1252 (which contains Latin-1's letters). Never fails: unpaired
/// surrogates become U+FFFD, the five bytes Windows-1252 leaves open become the C1 controls of the same value. Control
/// characters other than tab, CR and LF become blanks (NUL, form feed, Ctrl-Z) or '?'.
DecodedText decode_text(std::string_view bytes);

/// Windows-1252 bytes of UTF-8 text; nullopt if a character does not exist there.
std::optional<std::string> encode_windows_1252(std::string_view utf8);

struct Line {
  std::string_view text;  ///< without its end
  int number = 0;         ///< from 1, as an editor counts; CR LF, LF and a lone CR end a line
};

/// All lines of `text`, empty ones too; they point into `text`.
std::vector<Line> split_lines(std::string_view text);

/// A line addressed by characters instead of bytes, for fixed-column formats written in a one-byte encoding.
class CharacterLine {
 public:
  explicit CharacterLine(std::string_view utf8);
  std::size_t size() const { return ascii_ ? text_.size() : starts_.size() - 1; }
  /// The character at `index`, '\x01' for any that is not ASCII; `index` < size().
  char at(std::size_t index) const;
  /// Characters [index, index + count), clipped to the line.
  std::string_view part(std::size_t index, std::size_t count = std::string_view::npos) const;

 private:
  std::string_view text_;
  bool ascii_ = true;
  std::vector<std::size_t> starts_;  // byte offset of each character and of the end; empty for ASCII
};

/// `text` without blanks, tabs, CR, LF and NUL at both ends.
std::string_view trim(std::string_view text);

/// Same letters apart from ASCII case.
bool equal_ignoring_case(std::string_view a, std::string_view b);
std::string to_lower(std::string_view ascii);

/// The parts of `text` between single characters `delimiter`; "a;;b" has three. Blank runs: split_blanks.
std::vector<std::string_view> split(std::string_view text, char delimiter);
std::vector<std::string_view> split_blanks(std::string_view text);
// Not of a temporary: the parts would point into what is gone.
template <std::same_as<std::string> Temporary>
std::vector<std::string_view> split(Temporary&& text, char delimiter) = delete;
template <std::same_as<std::string> Temporary>
std::vector<std::string_view> split_blanks(Temporary&& text) = delete;

/// The finite number that all of `token` (trimmed) is; nullopt for anything else: empty text, rest after the number,
/// 'nan', 'inf', hexadecimal, overflow. `decimal` is the decimal separator; '+' signs and exponents are allowed.
std::optional<double> parse_number(std::string_view token, char decimal = '.');

/// The integer that all of `token` (trimmed) is; nullopt if it is none or leaves the range of long long.
std::optional<long long> parse_integer(std::string_view token);

/// `text` in quotes for a message: control characters shown as '?', at most `longest` characters.
std::string quoted(std::string_view text, std::size_t longest = 40);

/// Shortest text that reads back as the same double, '.' as decimal separator, in any locale.
std::string format_shortest(double value);
/// `value` with `decimals` digits after the point, in any locale; never "-0.000".
std::string format_fixed(double value, int decimals);

}  // namespace plumbline::text
