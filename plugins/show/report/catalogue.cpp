#include "show/report/catalogue.hpp"

#include <algorithm>
#include <cctype>
#include <limits>
#include <map>
#include <set>
#include <stdexcept>

#include "report_page_parts.hpp"

namespace plumbline::report {

namespace {

using Part = Catalogue::Part;
using Sentence = Catalogue::Sentence;
using Places = std::map<std::string, std::string_view>;

constexpr int kDeepest = 8;  ///< sentences within sentences, and one after another
/// Letters below which a sentence says little ("{id}: {~note}"): it is one only where nothing else fits.
constexpr std::size_t kWeak = 6;

[[noreturn]] void refuse(std::size_t line, const std::string& why) {
  throw std::runtime_error("catalogue, line " + std::to_string(line) + ": " + why);
}

/// With plain spaces in place of U+00A0, and none at the end.
std::string plain_spaces(std::string_view text) {
  while (text.ends_with(' ')) text.remove_suffix(1);
  std::string out;
  for (std::size_t i = 0; i < text.size(); ++i) {
    if (text.substr(i, 2) == "\u00A0")
      out += ' ', ++i;
    else
      out += text[i];
  }
  return out;
}

Sentence parsed(std::string_view text, std::size_t line) {
  Sentence sentence;
  while (!text.empty()) {
    const std::size_t brace = std::min(text.find('{'), text.size());
    if (brace > 0) sentence.push_back({Part::Kind::words, std::string(text.substr(0, brace))});
    text.remove_prefix(brace);
    if (text.empty()) break;
    const std::size_t end = text.find('}');
    if (end == std::string_view::npos || end < 2) refuse(line, "a '{' without a name and '}'");
    std::string name(text.substr(1, end - 1));
    const auto kind = name[0] == '#' ? Part::Kind::number : name[0] == '~' ? Part::Kind::sentence : Part::Kind::taken;
    if (kind != Part::Kind::taken) name.erase(0, 1);
    if (!sentence.empty() && sentence.back().kind != Part::Kind::words)
      refuse(line, "two places without a word between them: nobody can tell them apart");
    sentence.push_back({kind, std::move(name)});
    text.remove_prefix(end + 1);
  }
  return sentence;
}

std::set<std::pair<Part::Kind, std::string>> places_of(const Sentence& sentence) {
  std::set<std::pair<Part::Kind, std::string>> names;
  for (const Part& part : sentence)
    if (part.kind != Part::Kind::words) names.emplace(part.kind, part.text);
  return names;
}

/// Digits with a sign and a decimal sign, or a fraction ("1-7/16"), and the mark of those that are in the units spoken
/// already.
bool is_number(std::string_view text) {
  bool digit = false, decimal = false;
  if (text.ends_with('\x03')) text.remove_suffix(1);
  if (text.starts_with('+') || text.starts_with('-'))
    text.remove_prefix(1);
  else if (text.starts_with("\u2212") || text.starts_with("\u2013"))
    text.remove_prefix(3), digit = text.empty();  // "–": not known
  for (const char c : text) {
    if (std::isdigit(static_cast<unsigned char>(c)))
      digit = true;
    else if (digit && (c == '/' || c == '-'))
      continue;
    else if ((c != '.' && c != ',') || decimal)
      return false;  // "0.2.0" is a version
    else
      decimal = true;
  }
  return digit && (text.empty() || std::isdigit(static_cast<unsigned char>(text.back())) != 0);
}

bool is_letter(char c) {
  return std::isalpha(static_cast<unsigned char>(c)) != 0 || static_cast<unsigned char>(c) >= 0x80;
}

/// Runs of letters.
std::vector<std::string_view> words_of(std::string_view text) {
  std::vector<std::string_view> words;
  for (std::size_t at = 0; at < text.size();) {
    const auto begin = static_cast<std::size_t>(
        std::find_if(text.begin() + static_cast<std::ptrdiff_t>(at), text.end(), is_letter) - text.begin());
    at = static_cast<std::size_t>(
        std::find_if_not(text.begin() + static_cast<std::ptrdiff_t>(begin), text.end(), is_letter) - text.begin());
    if (at > begin) words.push_back(text.substr(begin, at - begin));
  }
  return words;
}

/// Of the sentence's own words, but for those that a place may continue ("sigma{#s}").
std::string longest_word(const Sentence& sentence) {
  std::string longest;
  for (std::size_t i = 0; i < sentence.size(); ++i) {
    if (sentence[i].kind != Part::Kind::words) continue;
    const std::string_view text = sentence[i].text;
    for (const std::string_view word : words_of(text)) {
      const bool continued = (i > 0 && word.data() == text.data()) ||
                             (i + 1 < sentence.size() && word.data() + word.size() == text.data() + text.size());
      if (!continued && word.size() > longest.size()) longest = word;
    }
  }
  return longest;
}

/// Whether every bracket that closes was opened: "a (b); c (d" is two sentences cut apart, not one.
bool is_whole(std::string_view text) {
  int open = 0;
  for (const char c : text) {
    open += c == '(' ? 1 : c == ')' ? -1 : 0;
    if (open < 0) return false;
  }
  return open == 0;
}

/// Whether `text` is the sentence from `part` on; places get the least that lets the rest fit.
bool fits(const Sentence& sentence, std::size_t part, std::string_view text, Places& places) {
  if (part == sentence.size()) return text.empty();
  const Part& now = sentence[part];
  if (now.kind == Part::Kind::words)
    return text.starts_with(now.text) && fits(sentence, part + 1, text.substr(now.text.size()), places);
  const bool in_brackets = part > 0 && sentence[part - 1].text.ends_with('(');
  const auto takes = [&](std::size_t length) {
    const std::string_view taken = text.substr(0, length);
    if (taken.empty() || (now.kind == Part::Kind::number && !is_number(taken))) return false;
    if (now.kind == Part::Kind::taken && taken.ends_with(',')) return false;  // the end of a list's part, and no name
    if ((now.kind == Part::Kind::sentence || in_brackets) && !is_whole(taken)) return false;
    places[now.text] = taken;
    return true;
  };
  if (part + 1 == sentence.size()) return takes(text.size());
  const std::string& next = sentence[part + 1].text;
  for (std::size_t at = text.find(next, 1); at != std::string_view::npos; at = text.find(next, at + 1))
    if (takes(at) && fits(sentence, part + 1, text.substr(at), places)) return true;
  return false;
}

}  // namespace

Catalogue::Catalogue(std::string_view text, char decimal_sign) : decimal_sign_(decimal_sign) {
  std::string english;
  std::set<std::string> known;
  std::size_t number = 0;
  while (!text.empty()) {
    const std::size_t end = std::min(text.find('\n'), text.size());
    const std::string_view line = text.substr(0, end);
    text.remove_prefix(std::min(end + 1, text.size()));
    ++number;
    if (line.empty() || line[0] == '#') continue;
    if (line[0] != ' ') {
      if (!english.empty()) refuse(number, "'" + english + "' has nothing in the other language");
      english = line;
      if (!known.insert(english).second) refuse(number, "'" + english + "' stands twice");
      continue;
    }
    if (english.empty()) refuse(number, "a sentence of the other language without an English one before it");
    Entry entry{english, parsed(english, number), parsed(line.substr(2), number), 0};
    const auto places = places_of(entry.english);
    std::set<std::string> names;
    for (const auto& [kind, name] : places) names.insert(name);
    const auto filled_in = std::count_if(entry.english.begin(), entry.english.end(),
                                         [](const Part& part) { return part.kind != Part::Kind::words; });
    if (static_cast<std::size_t>(filled_in) != names.size())
      refuse(number, "'" + english + "' has two places of one name: one would be told in the other's place");
    if (places != places_of(entry.other))
      refuse(number, "'" + english + "' does not have the same places in both languages");
    for (const Part& part : entry.english)
      if (part.kind == Part::Kind::words) entry.letters += part.text.size();
    entries_.push_back(std::move(entry));
    english.clear();
  }
  if (!english.empty()) refuse(number, "'" + english + "' has nothing in the other language");
  std::stable_sort(entries_.begin(), entries_.end(),
                   [](const Entry& a, const Entry& b) { return a.letters > b.letters; });
  for (std::size_t i = 0; i < entries_.size(); ++i) {
    const Sentence& sentence = entries_[i].english;
    if (places_of(sentence).empty()) {
      whole_.emplace(entries_[i].written, i);
      continue;
    }
    const std::string word = longest_word(sentence);
    (word.empty() ? without_word_ : by_word_[word]).push_back(i);
  }
}

std::string Catalogue::number(std::string text) const {
  std::replace(text.begin(), text.end(), '.', decimal_sign_);
  return text;
}

std::optional<std::string> Catalogue::sentence(std::string_view english, int depth) const {
  if (is_number(english)) return number(std::string(english));
  if (auto found = find(english, depth)) return found;
  static constexpr std::pair<std::string_view, std::string_view> lists[] = {
      {"; ", "; "}, {", ", ", "}, {" and ", " und "}};
  for (const auto& [between, other] : lists) {
    const std::size_t at = english.find(between);
    if (at == std::string_view::npos || at == 0) continue;
    const auto first = sentence(english.substr(0, at), depth);
    const auto rest = first ? sentence(english.substr(at + between.size()), depth) : std::nullopt;
    if (rest) return *first + std::string(other) + *rest;
  }
  return std::nullopt;
}

std::optional<std::string> Catalogue::list(std::string_view english, int depth) const {
  constexpr std::size_t of_its_own = 3;  // "bow: {~why}", and not "{what}: {~why}", which is anything
  std::string text;
  for (std::size_t begin = 0; begin <= english.size();) {
    const std::size_t end = std::min(english.find("; ", begin), english.size());
    if (begin == 0 && end == english.size()) return std::nullopt;
    const std::string_view part = english.substr(begin, end - begin);
    auto said = whole(std::string(part));
    if (!said) said = filled(part, depth + 1, of_its_own, std::numeric_limits<std::size_t>::max());
    if (!said) said = filled(part, depth + 1, 1, of_its_own, true);  // "p 0.067"
    if (!said) return std::nullopt;
    text += (begin == 0 ? "" : "; ") + *said;
    begin = end + 2;
  }
  return text;
}

std::optional<std::string> Catalogue::whole(const std::string& english) const {
  const auto found = whole_.find(english);
  if (found == whole_.end()) return std::nullopt;
  const Sentence& other = entries_[found->second].other;
  return other.empty() ? std::string() : other.front().text;
}

std::optional<std::string> Catalogue::find(std::string_view english, int depth) const {
  if (depth >= kDeepest || english.empty()) return std::nullopt;
  // A place that reaches over the end of a sentence is tried last: "Rings: {~what}." is one sentence, not all to the
  // end.
  if (auto found = whole(std::string(english))) return found;
  if (auto found = paragraph(english, depth)) return found;
  // "step: 2 of 3 (why); bow: all (why)" is a list before it is one thing that is said of steps.
  if (auto found = list(english, depth)) return found;
  if (english.ends_with('.'))
    if (const auto found = list(english.substr(0, english.size() - 1), depth)) return *found + ".";
  if (auto found = single(english, depth)) return found;
  return filled(english, depth, 0, kWeak);
}

std::optional<std::string> Catalogue::paragraph(std::string_view english, int depth) const {
  if (depth >= kDeepest) return std::nullopt;
  for (std::size_t at = english.find(". "); at != std::string_view::npos; at = english.find(". ", at + 1)) {
    const auto first = single(english.substr(0, at + 1), depth + 1);
    if (!first) continue;
    const std::string_view rest = english.substr(at + 2);
    auto more = paragraph(rest, depth + 1);
    if (!more) more = single(rest, depth + 1);
    if (more) return *first + " " + *more;
  }
  return std::nullopt;
}

std::optional<std::string> Catalogue::single(std::string_view english, int depth) const {
  const auto said = [&](std::string_view text) {
    auto found = whole(std::string(text));
    return found ? found : filled(text, depth, kWeak, std::numeric_limits<std::size_t>::max());
  };
  if (auto found = said(english)) return found;
  if (!english.ends_with('.')) return std::nullopt;
  const auto clause = said(english.substr(0, english.size() - 1));
  return clause ? std::optional(*clause + ".") : std::nullopt;
}

std::string Catalogue::taken_as(std::string_view taken) const {
  // "F01-K1, F01-K2 and 43 more", as lists of names are cut.
  constexpr std::string_view before = " and ", after = " more";
  const std::size_t at = taken.rfind(before);
  if (!taken.ends_with(after) || at == std::string_view::npos) return std::string(taken);
  const std::string_view count = taken.substr(at + before.size(), taken.size() - after.size() - at - before.size());
  const auto other = is_number(count) ? find("and " + std::string(count) + " more", 0) : std::nullopt;
  return std::string(taken.substr(0, at)) + (other ? " " + *other : std::string(taken.substr(at)));
}

std::optional<std::string> Catalogue::filled(std::string_view english, int depth, std::size_t least, std::size_t most,
                                             bool only_numbers) const {
  std::vector<std::size_t> candidates = without_word_;
  for (const std::string_view word : words_of(english))
    if (const auto found = by_word_.find(std::string(word)); found != by_word_.end())
      candidates.insert(candidates.end(), found->second.begin(), found->second.end());
  std::sort(candidates.begin(), candidates.end());  // those with most letters first
  for (const std::size_t candidate : candidates) {
    const Entry& entry = entries_[candidate];
    Places places;
    if (entry.letters >= most || entry.letters < least) continue;
    if (only_numbers && std::any_of(entry.english.begin(), entry.english.end(), [](const Part& part) {
          return part.kind != Part::Kind::words && part.kind != Part::Kind::number;
        }))
      continue;
    if (!fits(entry.english, 0, english, places)) continue;
    std::string text;
    for (const Part& part : entry.other) {
      if (part.kind == Part::Kind::words) {
        text += part.text;
        continue;
      }
      const std::string_view taken = places.at(part.text);
      text += part.kind == Part::Kind::taken    ? taken_as(taken)
              : part.kind == Part::Kind::number ? number(std::string(taken))
                                                : sentence(taken, depth + 1).value_or(std::string(taken));
    }
    return text;
  }
  return std::nullopt;
}

std::optional<std::string> Catalogue::find(std::string_view english) const {
  return sentence(plain_spaces(english), 0);
}

const Catalogue& german() {
  static const Catalogue catalogue(parts::german_sentences, ',');
  return catalogue;
}

}  // namespace plumbline::report
