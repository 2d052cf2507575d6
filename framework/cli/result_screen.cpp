#include "result_screen.hpp"

#include <algorithm>
#include <cctype>
#include <map>
#include <sstream>
#include <string_view>

#include "terminal.hpp"

namespace plumbline::cli {

namespace {

const std::string kMore = "  … ";

struct Shown {
  std::string text;
  size_t list = 0;  ///< lines of one list have one number; 0: of none
  size_t rows = 1;
};

std::string first_word(const std::string& text) {
  std::string word;
  std::istringstream(text) >> word;
  return word;
}

/// By character, not byte.
std::vector<std::string> characters(const std::string& text) {
  std::vector<std::string> all;
  for (const char c : text) {
    if ((static_cast<unsigned char>(c) & 0xC0) != 0x80 || all.empty()) all.emplace_back();
    all.back() += c;
  }
  return all;
}

bool is_indented(const std::string& text) { return text.starts_with("  ") && !text.starts_with(kMore); }

bool is_sentence(const std::string& line) { return line.find("  ", is_indented(line) ? 2 : 0) == std::string::npos; }

/// Rows of a table that is wider than the screen move together where all of them have two blanks behind the
/// indentation.
void squeeze(std::vector<std::string>& lines, size_t begin, size_t end, size_t columns) {
  std::vector<std::vector<std::string>> rows;
  size_t widest = 0;
  for (size_t i = begin; i < end; ++i) {
    rows.push_back(characters(lines[i]));
    widest = std::max(widest, rows.back().size());
  }
  const auto blank = [&](size_t at) {
    return std::ranges::all_of(rows, [&](const auto& row) { return at >= row.size() || row[at] == " "; });
  };
  for (size_t at = widest; widest > columns && at-- > 3;) {
    if (!blank(at) || !blank(at - 1)) continue;
    for (auto& row : rows)
      if (at < row.size()) row.erase(row.begin() + static_cast<std::ptrdiff_t>(at));
    --widest;
  }
  for (size_t i = begin; i < end; ++i) {
    lines[i].clear();
    for (const std::string& character : rows[i - begin]) lines[i] += character;
  }
}

std::vector<std::string> squeezed(std::vector<std::string> lines, size_t columns) {
  for (size_t begin = 0; begin < lines.size();) {
    const bool indented = is_indented(lines[begin]);
    size_t end = begin;
    while (end < lines.size() && !is_sentence(lines[end]) && is_indented(lines[end]) == indented) ++end;
    squeeze(lines, begin, end, columns);
    begin = std::max(end, begin + 1);
  }
  return lines;
}

/// A line on a narrow screen: sentences, and rows that are still too wide, are broken between words, what is indented
/// with its next lines two further in.
std::string broken(const std::string& line, size_t columns) {
  if (characters(line).size() <= columns) return line;
  if (is_indented(line)) return "  " + wrapped(line, columns > 24 ? columns - 4 : 20, 4);
  return is_sentence(line) ? wrapped(line, columns) : line;
}

/// "floor 3 ..." of a table; of an indented line the word that begins several ("panel"), for the others "".
std::string list_of(const std::string& text, const std::map<std::string, size_t>& begin) {
  const auto is_digit = [](char c) { return std::isdigit(static_cast<unsigned char>(c)) != 0; };
  const std::string word = first_word(text);
  if (is_indented(text))
    return std::none_of(word.begin(), word.end(), is_digit) && begin.at(word) > 1 ? "  " + word : "  ";
  std::istringstream words(text);
  std::string second;
  words >> second >> second;
  return !second.empty() && std::all_of(second.begin(), second.end(), is_digit) ? word : "";
}

std::vector<Shown> shown(const std::vector<std::string>& lines, size_t columns) {
  std::map<std::string, size_t> begin;
  for (const std::string& line : lines) ++begin[first_word(line)];
  std::vector<Shown> all;
  std::string before;
  size_t lists = 0;
  for (const std::string& line : lines) {
    const std::string list = list_of(line, begin);
    if (list != before) ++lists;
    before = list;
    const std::string text = broken(line, columns);
    const auto breaks = static_cast<size_t>(std::ranges::count(text, '\n'));
    const size_t length = breaks ? 1 : characters(text).size();
    all.push_back({text, list.empty() ? 0 : lists, breaks + std::max<size_t>(1, (length + columns - 1) / columns)});
  }
  return all;
}

/// How much a line is missed: one that passes least, one that fails most.
enum class Weight { passes, stands_between, fails };

Weight weight_of(const std::string& text) {
  static constexpr std::string_view passing[] = {" pass", " in Ordnung"}, failing[] = {"FAIL", "AUSSERHALB"};
  const auto has = [&](std::string_view word) { return text.find(word) != std::string::npos; };
  if (std::ranges::any_of(failing, has)) return Weight::fails;
  return std::ranges::any_of(passing, has) ? Weight::passes : Weight::stands_between;
}

/// The line to be left out next: the last of the least weight of the longest list, as long as more than one line of it
/// is left. What fails is left out of no list before `even_failures`.
std::vector<Shown>::iterator least(std::vector<Shown>& all, bool even_failures) {
  std::map<size_t, size_t> lengths, lighter;
  for (const Shown& line : all)
    if (line.list != 0) ++lengths[line.list], lighter[line.list] += weight_of(line.text) != Weight::fails;
  size_t list = 0;
  for (const auto& [one, length] : lengths)
    if (length > 1 && (even_failures || lighter[one] > 0) && (list == 0 || length > lengths[list])) list = one;
  auto found = all.end();
  for (auto it = all.begin(); list != 0 && it != all.end(); ++it)
    if (it->list == list && (found == all.end() || weight_of(it->text) <= weight_of(found->text))) found = it;
  return found;
}

/// The sentence that takes most rows, and more than `kept`, loses its last one. The first line is the result itself,
/// and stays whole.
bool cut_longest_sentence(std::vector<Shown>& all, size_t kept) {
  static const std::string cut = " …";
  if (all.empty()) return false;
  const auto is_sentence = [](const Shown& line) { return line.text.find('\n') != std::string::npos; };
  auto longest = all.end();
  for (auto it = all.begin() + 1; it != all.end(); ++it)
    if (is_sentence(*it) && weight_of(it->text) != Weight::fails && it->rows > kept &&
        (longest == all.end() || it->rows > longest->rows))
      longest = it;
  if (longest == all.end()) return false;
  const size_t last = longest->text.rfind('\n');
  longest->text.erase(last);
  if (longest->text.ends_with(",")) longest->text.pop_back();
  if (const size_t blank = longest->text.find_last_of(" \n"); blank != std::string::npos)
    longest->text.erase(blank);  // room for the sign that something is missing
  longest->text += cut;
  --longest->rows;
  return true;
}

bool is_cut(const Shown& line) { return line.text.ends_with(" …"); }

}  // namespace

std::vector<std::string> in_a_screen(const std::vector<std::string>& lines, size_t columns, size_t rows,
                                     const std::string& file) {
  if (columns == 0 || rows == 0) return lines;
  std::vector<Shown> all = shown(squeezed(lines, columns), columns);
  std::map<size_t, size_t> left_out;
  const auto ends_list = [&](size_t i) { return i + 1 == all.size() || all[i + 1].list != all[i].list; };
  const auto says_more = [&](size_t i) { return i < all.size() && all[i].text.starts_with(kMore); };
  const auto total = [&] {
    size_t sum = 0;
    for (size_t i = 0; i < all.size(); ++i)  // a line for each list that is shortened and has none yet
      sum += all[i].rows + (left_out.count(all[i].list) && ends_list(i) && !says_more(i + 1) ? 1 : 0);
    // And one that says where what was cut stands whole, unless such a line names the file.
    if (left_out.empty() && std::ranges::any_of(all, is_cut)) sum += (kMore.size() + file.size()) / columns + 1;
    return sum;
  };
  const auto leave_out = [&](bool even_failures) {
    const auto line = least(all, even_failures);
    if (line == all.end()) return false;
    ++left_out[line->list];
    all.erase(line);
    return true;
  };
  // One row is the next prompt's. What explains goes before what fails.
  while (total() >= rows &&
         (leave_out(false) || cut_longest_sentence(all, 2) || cut_longest_sentence(all, 1) || leave_out(true))) {
  }
  std::vector<std::string> texts;
  for (size_t i = 0; i < all.size(); ++i) {
    texts.push_back(all[i].text);
    if (!left_out.count(all[i].list) || !ends_list(i)) continue;
    const std::string more = kMore + "+" + std::to_string(left_out[all[i].list]);  // in no language
    if (says_more(i + 1))
      texts.push_back(more + " " + all[++i].text.substr(kMore.size()));
    else
      texts.push_back(more + ": " + file);
  }
  if (left_out.empty() && std::ranges::any_of(all, is_cut)) texts.push_back(kMore + file);
  return texts;
}

}  // namespace plumbline::cli
