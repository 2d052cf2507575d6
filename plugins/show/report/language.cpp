#include "show/report/language.hpp"

#include <fmt/core.h>

#include <algorithm>
#include <array>
#include <cctype>
#include <charconv>
#include <cmath>
#include <optional>
#include <stdexcept>
#include <vector>

#include "show/report/catalogue.hpp"

namespace plumbline::report {

namespace {

thread_local Speech current;

// Marks within texts, which never come out: around a name, and behind a number in the units spoken.
constexpr char kNameBegins = '\x01', kNameEnds = '\x02', kConverted = '\x03';
constexpr std::string_view kNoBreak = "\u00A0", kMinus = "\u2212";

bool is_digit(char c) { return std::isdigit(static_cast<unsigned char>(c)) != 0; }
bool is_word(char c) {
  return std::isalnum(static_cast<unsigned char>(c)) != 0 || static_cast<unsigned char>(c) >= 0x80;
}

std::string without_marks(std::string text) {
  std::erase_if(text, [](char c) { return c == kNameBegins || c == kNameEnds || c == kConverted; });
  return text;
}

/// Whether a place of the text lies in a name, which stays as it is ("Glass 12 mm").
bool is_in_name(std::string_view text, std::size_t at) {
  const std::size_t begin = text.rfind(kNameBegins, at);
  return begin != std::string_view::npos && text.substr(begin, at - begin).find(kNameEnds) == std::string_view::npos;
}

/// A number that ends at `end` of the text, or with its mark there: where it begins; `end` if there is none.
std::size_t number_before(std::string_view text, const std::size_t end_with_mark) {
  const std::size_t end = end_with_mark - (end_with_mark > 0 && text[end_with_mark - 1] == kConverted ? 1 : 0);
  std::size_t at = end;
  while (at > 0 && (is_digit(text[at - 1]) ||
                    ((text[at - 1] == '.' || text[at - 1] == ',') && at < end && at > 1 && is_digit(text[at - 2]))))
    --at;
  if (at == end) return end_with_mark;
  if (at > 0 && is_word(text[at - 1]) && !text.substr(0, at).ends_with(kMinus) &&
      !text.substr(0, at).ends_with(kNoBreak) && !text.substr(0, at).ends_with("±") &&
      !text.substr(0, at).ends_with("\u2013"))
    return end_with_mark;  // "C4 mm" has no number
  if (at > 0 && (text[at - 1] == '+' || text[at - 1] == '-'))
    --at;
  else if (text.substr(0, at).ends_with(kMinus))
    at -= kMinus.size();
  return at;
}

/// Millimetres as written, in inches with two digits more, which are as fine (0.01 in = 0.25 mm); three at least.
std::string inches_of(std::string_view written) {
  std::string number(written), sign;
  if (number.starts_with(kMinus)) sign = kMinus, number.erase(0, kMinus.size());
  if (number.starts_with('+') || number.starts_with('-')) sign = number.substr(0, 1), number.erase(0, 1);
  const std::size_t point = number.find_first_of(".,");
  const char decimal = point == std::string::npos ? '.' : number[point];
  if (point != std::string::npos) number[point] = '.';
  const int decimals = point == std::string::npos ? 0 : static_cast<int>(number.size() - point - 1);
  double value = 0;
  std::from_chars(number.data(), number.data() + number.size(), value);
  std::string text = fmt::format("{:.{}f}", value / 25.4, std::clamp(decimals + 2, 3, 6));
  if (decimal == ',' || current.language == Language::german) std::replace(text.begin(), text.end(), '.', ',');
  return sign + text;
}

/// What stands between numbers that share the unit behind the last one.
std::size_t joined_before(std::string_view text, std::size_t end, bool in_list) {
  static constexpr std::array<std::string_view, 10> joints = {" ± ",   "\u00A0±\u00A0", " to ",     " bis ", " and ",
                                                              " und ", "\u2013",        " and of ", "/",     " +- "};
  for (const std::string_view joint : joints)
    if (text.substr(0, end).ends_with(joint)) return end - joint.size();
  if (in_list && text.substr(0, end).ends_with(", ")) return end - 2;
  return end;
}

/// Whether a number with decimals or a sign is left that is not converted and has no word or unit of its own behind it:
/// it may share the unit of a length further on.
bool leaves_numbers(std::string_view text) {
  for (std::size_t at = 1; at + 1 < text.size(); ++at) {
    if (is_in_name(text, at)) continue;
    const bool decimals = (text[at] == '.' || text[at] == ',') && is_digit(text[at - 1]) && is_digit(text[at + 1]);
    const bool sign = (text[at] == '+' || text[at] == '-') && text[at - 1] == ' ' && is_digit(text[at + 1]);
    if (!decimals && !sign) continue;
    std::size_t end = at + 1;
    while (end < text.size() && is_digit(text[end])) ++end;
    if (sign && end + 1 < text.size() && (text[end] == '.' || text[end] == ',') && is_digit(text[end + 1])) continue;
    if (end < text.size() && text[end] == kConverted) continue;
    if (end < text.size() && text[end] == ' ') ++end;
    if (end == text.size() || (!is_word(text[end]) && text[end] != '%') || is_digit(text[end])) return true;
  }
  return false;
}

/// Lengths in mm: those that come converted get the name of their unit, others (of artifacts' texts) are converted.
std::string with_units(std::string text) {
  const std::string as_it_was = text;
  const bool composed = text.find(kConverted) != std::string::npos;
  const std::string unit = unit_of_lengths();
  for (std::size_t at = text.find("mm"); at != std::string::npos; at = text.find("mm", at)) {
    const bool alone = (at == 0 || (!is_word(text[at - 1]) || text.substr(0, at).ends_with(kNoBreak))) &&
                       (at + 2 == text.size() || !is_word(text[at + 2]) || text.substr(at + 2).starts_with(kNoBreak));
    if (!alone || is_in_name(text, at)) {
      at += 2;
      continue;
    }
    const bool per_metre = text.substr(at).starts_with("mm/m") && !(at + 4 < text.size() && is_word(text[at + 4]));
    if (per_metre && at > 1 && (is_digit(text[at - 2]) || text.substr(0, at).ends_with(kNoBreak))) {
      at += 4;  // a slope with its number, which only notes of artifacts have: stays as it is
      continue;
    }
    const std::string name = per_metre ? unit + (current.language == Language::german ? "/Fuß" : "/ft")
                             : text.substr(0, at).ends_with(" in ") && text[at - 1] == ' '
                                 ? (current.language == Language::german ? "Zoll" : "inches")
                                 : unit;
    text.replace(at, per_metre ? 4 : 2, name);
    const std::size_t after = at + name.size();
    std::size_t end = at;
    if (text.substr(0, end).ends_with(kNoBreak))
      end -= kNoBreak.size();
    else if (end > 0 && text[end - 1] == ' ')
      --end;
    else
      end = 0;
    std::ptrdiff_t longer = 0;
    bool in_list = false;  // "4, 5 and 6 mm", "+1, -2, +4 mm"
    while (end > 0) {
      const std::size_t begin = number_before(text, end);
      if (begin == end) break;
      if (text[end - 1] != kConverted) {
        const std::string converted = inches_of(std::string_view(text).substr(begin, end - begin)) + kConverted;
        longer += static_cast<std::ptrdiff_t>(converted.size()) - static_cast<std::ptrdiff_t>(end - begin);
        text.replace(begin, end - begin, converted);
      }
      const bool has_sign = text[begin] == '+' || text[begin] == '-' || text.substr(begin).starts_with(kMinus);
      const std::size_t before = joined_before(text, begin, in_list || has_sign);
      const std::string_view joint = std::string_view(text).substr(before, begin - before);
      in_list = in_list || joint == " and " || joint == " und ";
      end = before == begin ? 0 : before;
    }
    at = static_cast<std::size_t>(static_cast<std::ptrdiff_t>(after) + longer);
  }
  // "E -1.0, N -1.4, H +0.4 mm" of an artifact: which numbers are lengths is not certain, and millimetres stay true.
  if (!composed && text.find(kConverted) != std::string::npos && leaves_numbers(text)) return as_it_was;
  return text;
}

/// Units stay with their numbers at the end of a line: the catalogue knows plain spaces only.
std::string with_units_unbroken(std::string text) {
  static constexpr std::array<std::string_view, 8> units = {"mm", "m", "%", "px", "gon", "mgon", "mrad", "µm"};
  for (std::size_t at = text.find(' '); at != std::string::npos; at = text.find(' ', at + 1)) {
    if (at == 0 || (!is_digit(text[at - 1]) && text[at - 1] != kConverted)) continue;
    const std::string_view rest = std::string_view(text).substr(at + 1);
    const bool unit = std::any_of(units.begin(), units.end(), [&](std::string_view name) {
      return rest.starts_with(name) && (rest.size() == name.size() || !is_word(rest[name.size()]));
    });
    if (unit) text.replace(at, 1, kNoBreak);
  }
  return text;
}

bool has_letters(std::string_view text) {
  return std::any_of(text.begin(), text.end(), [](char c) { return std::isalpha(static_cast<unsigned char>(c)) != 0; });
}

}  // namespace

Speech speech_of(const std::string& language, const std::string& units) {
  if (language != "en" && language != "de")
    throw std::invalid_argument("language '" + language + "' is not spoken; expected en or de");
  if (units != "mm" && units != "in") throw std::invalid_argument("units '" + units + "'; expected mm or in");
  return {language == "de" ? Language::german : Language::english, units == "in" ? Units::inches : Units::millimetres};
}

const Speech& speech() { return current; }

Speaking::Speaking(Speech now) : before_(current) { current = now; }
Speaking::~Speaking() { current = before_; }

std::string spoken(std::string_view english) {
  std::string text(english);
  if (current.plain()) return text;
  if (!has_letters(text)) return without_marks(std::move(text));
  if (text.front() == kNameBegins && text.find(kNameEnds) + 1 == text.size()) return without_marks(std::move(text));
  if (current.language == Language::german) {
    const std::size_t first = text.find_first_not_of(' '), last = text.find_last_not_of(' ');
    if (auto found = german().find(std::string_view(text).substr(first, last + 1 - first)))
      text = text.substr(0, first) + with_units_unbroken(std::move(*found)) + text.substr(last + 1);
  }
  if (current.units == Units::inches) text = with_units(std::move(text));
  return without_marks(std::move(text));
}

std::string verbatim(const std::string& name) { return current.plain() ? name : kNameBegins + name + kNameEnds; }

std::string title_spoken(const std::string& title) {
  const auto found = current.language == Language::german ? german().whole(title) : std::nullopt;
  return verbatim(found.value_or(title));
}

std::string in_units_spoken(std::string number) {
  return current.units == Units::inches ? std::move(number) + kConverted : number;
}

std::string unit_of_lengths() {
  if (current.units == Units::millimetres) return "mm";
  return current.language == Language::german ? "Zoll" : "in";
}

std::string limits_of_speech() {
  std::string text;
  if (current.language == Language::german)
    text =
        "Namen und Texte des Projekts stehen, wie sie gegeben sind. Auf Englisch stehen: was beim Lesen von Dateien "
        "auffiel; seltene Befunde von Vermessung, Bildverband und Kalibrierung; die Parameter des Laufs. "
        "Datumsangaben nach ISO 8601.";
  if (current.units == Units::inches) {
    text += text.empty() ? "" : " ";
    text +=
        current.language == Language::german
            ? "Längen in Zoll (1 Zoll = 25,4 Millimeter genau), Stellmaße dazu auf 1/32 Zoll gerundet; Koordinaten "
              "und Strecken bleiben in Metern. Beurteilt wird mit ungerundeten Werten; Dateien mit Daten (IFC, BCF, "
              "CSV, JSON, Arbeitsmappe) bleiben in Millimetern und Metern."
            : "Lengths in decimal inches (1 in = 25.4 millimeters exactly); what is to be set or shimmed also to the "
              "nearest 1/32 in. Coordinates and distances stay in meters. Verdicts are made with unrounded values; "
              "data files (IFC, BCF, CSV, JSON, workbook) stay in millimeters and meters.";
  }
  return text;
}

}  // namespace plumbline::report
