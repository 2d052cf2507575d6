#include "loop/job/staked_columns.hpp"

#include <map>
#include <optional>
#include <set>
#include <stdexcept>

#include "base/text/text.hpp"
#include "loop/job/unknown_keys.hpp"

namespace plumbline::loop {
namespace {

/// "Easting [m]" is "easting" and "m".
std::pair<std::string, std::string> name_and_unit(std::string_view cell) {
  const std::string text = text::to_lower(text::trim(cell));
  const auto open = text.find_first_of("[(");
  if (open == std::string::npos) return {text, ""};
  const auto close = text.find_first_of("])", open);
  return {std::string(text::trim(text.substr(0, open))),
          close == std::string::npos ? "" : std::string(text::trim(text.substr(open + 1, close - open - 1)))};
}

/// X and Y are left out: half of the world takes X for north.
const std::map<std::string, char>& meaning_of_heads() {
  static const std::map<std::string, char> heads = {
      {"ptid", 'p'},      {"name", 'p'},       {"point", 'p'}, {"point id", 'p'}, {"pointid", 'p'},
      {"id", 'p'},        {"point name", 'p'}, {"punkt", 'p'}, {"e", 'e'},        {"east", 'e'},
      {"easting", 'e'},   {"rechtswert", 'e'}, {"n", 'n'},     {"north", 'n'},    {"northing", 'n'},
      {"hochwert", 'n'},  {"h", 'h'},          {"z", 'h'},     {"height", 'h'},   {"elev", 'h'},
      {"elevation", 'h'}, {"el", 'h'},         {"höhe", 'h'},  {"hoehe", 'h'},    {"timestamp", 't'},
      {"datetime", 't'},  {"date time", 't'}};
  return heads;
}

/// What stands beside a coordinate in the name of its column.
enum class Said { nothing, staked, designed, difference, something };

/// Of the rest of the name: "design", "as staked", "diff".
Said said_by(const std::set<std::string>& words) {
  static const std::set<std::string> staked = {"staked",   "as staked", "as-staked", "measured", "actual", "built",
                                               "as-built", "observed",  "set",       "stakeout", "ist",    "gemessen"},
                                     designed = {"design",      "designed", "planned", "nominal",
                                                 "theoretical", "soll",     "plan"},
                                     difference = {"delta", "diff",     "difference", "deviation", "dev",
                                                   "error", "residual", "differenz",  "abweichung"};
  const auto has = [&](const std::set<std::string>& some) {
    return std::any_of(words.begin(), words.end(), [&](const std::string& word) { return some.contains(word); });
  };
  if (words.empty()) return Said::nothing;
  return has(difference) ? Said::difference
         : has(staked)   ? Said::staked
         : has(designed) ? Said::designed
                         : Said::something;
}

/// A column whose name is that of a coordinate, or has one as its only such word: "Design E", "H_staked".
struct Coordinate {
  char which;
  Said said;
};
std::optional<Coordinate> coordinate_of(const std::string& name) {
  const auto meaning = [](const std::string& word) {
    const auto known = meaning_of_heads().find(word);
    return known != meaning_of_heads().end() && std::string("enh").find(known->second) != std::string::npos
               ? known->second
               : '\0';
  };
  if (const char which = meaning(name)) return Coordinate{which, Said::nothing};
  std::set<std::string> words;
  char which = 0;
  std::string word;
  for (const char c : name + " ") {
    if (c != ' ' && c != '_' && c != '.' && c != ':' && c != '/') {
      word += c;
      continue;
    }
    if (const char found = meaning(word); found && which)
      return std::nullopt;
    else if (found)
      which = found;
    else if (!word.empty())
      words.insert(word);
    word.clear();
  }
  if (!which) return std::nullopt;
  return Coordinate{which, said_by(words)};
}

/// The columns of a head, by what they say they hold.
struct Head {
  std::map<char, std::size_t> plain, staked, designed, other;  ///< 'e', 'n', 'h'; of plain also 'p' and 't'
  std::vector<std::size_t> unknown;
  std::map<char, std::pair<std::size_t, std::size_t>> twice;  ///< of others: "Grid E" and "Local E"
};

[[noreturn]] void say_the_same(const std::vector<std::string_view>& cells, std::size_t a, std::size_t b,
                               const std::string& source) {
  throw std::runtime_error(source + ": its columns '" + std::string(text::trim(cells[a])) + "' and '" +
                           std::string(text::trim(cells[b])) +
                           "' say the same: which of them was measured nobody can tell; keep that one alone");
}

/// Throws std::runtime_error for a unit that is not metres, and for two columns that say the same: which of them was
/// measured nobody can tell.
Head columns_of_head(const std::vector<std::string_view>& cells, const std::string& source) {
  Head head;
  for (std::size_t i = 0; i < cells.size(); ++i) {
    const auto [name, unit] = name_and_unit(cells[i]);
    const auto known = meaning_of_heads().find(name);
    const auto coordinate = coordinate_of(name);
    if (known == meaning_of_heads().end() && (!coordinate || coordinate->said == Said::difference)) {
      if (!name.empty() && name != "code") head.unknown.push_back(i);
      continue;
    }
    const Said said = coordinate ? coordinate->said : Said::nothing;
    auto& of_its_kind = said == Said::staked     ? head.staked
                        : said == Said::designed ? head.designed
                        : said == Said::nothing  ? head.plain
                                                 : head.other;
    const auto [before, is_new] = of_its_kind.emplace(coordinate ? coordinate->which : known->second, i);
    if (said == Said::something || (said == Said::designed && !is_new)) head.unknown.push_back(i);
    if (!is_new && said == Said::something) head.twice.emplace(before->first, std::pair(before->second, i));
    if (!is_new && (said == Said::nothing || said == Said::staked)) say_the_same(cells, before->second, i, source);
    if (coordinate && said != Said::something && said != Said::designed && !unit.empty() && unit != "m" &&
        unit != "metre" && unit != "meter")
      throw std::runtime_error(source + ": its column '" + std::string(text::trim(cells[i])) + "' is in " + unit +
                               "; expected metres: export it in metres");
  }
  return head;
}

bool has_all(const std::map<char, std::size_t>& columns) {
  return columns.contains('e') && columns.contains('n') && columns.contains('h');
}

/// Columns of unknown names, those that were taken nevertheless by the order of the tool's own files, and where points
/// were to be.
void tell_what_is_not_read(const std::vector<std::string_view>& cells, const std::string& source,
                           const StakedColumns& columns, const Head& head, std::vector<std::string>& ignored) {
  std::map<std::string, int> not_read;
  std::vector<std::size_t> others = head.unknown;
  for (const auto& [which, i] : head.designed) others.push_back(i);
  if (!head.staked.empty())
    for (const auto& [which, i] : head.plain)
      if (which != 'p' && which != 't') others.push_back(i);
  std::sort(others.begin(), others.end());
  for (const std::size_t i : others) {
    const std::string name(text::trim(cells[i]));
    const char* taken = i == columns.east     ? "easting"
                        : i == columns.north  ? "northing"
                        : i == columns.height ? "height"
                                              : nullptr;
    if (taken)
      ignored.push_back(source + ": what its column '" + name + "' is nobody knows here; it is taken for the " + taken +
                        ", by the order of the tool's own files");
    else if (i != columns.name)
      ++not_read[name];
  }
  if (const std::string words = words_of_ignored(not_read); !words.empty()) ignored.push_back(source + ": " + words);
}

}  // namespace

void read_head(const std::vector<std::string_view>& cells, const std::string& source, StakedColumns& columns,
               std::vector<std::string>& ignored) {
  const Head head = columns_of_head(cells, source);
  const auto own = [&](const std::map<char, std::size_t>& found) {
    return std::none_of(found.begin(), found.end(), [&](const auto& one) {
      return (one.first == 'e' && one.second != columns.east) || (one.first == 'n' && one.second != columns.north) ||
             (one.first == 'h' && one.second != columns.height);
    });
  };
  const auto& taken = !head.staked.empty() ? head.staked : head.plain;
  for (const auto& [which, two] : head.twice)
    if (!taken.contains(which)) say_the_same(cells, two.first, two.second, source);
  if (!has_all(head.staked) && (!head.staked.empty() || (!has_all(head.plain) && !head.designed.empty())))
    throw std::runtime_error(source + ": its head names " +
                             (head.staked.empty() ? "where points were to be, and not" : "some coordinates of") +
                             " where they were staked; expected all three as E, N and H, or as Staked E, Staked N and "
                             "Staked H");
  if (has_all(taken))
    columns.east = taken.at('e'), columns.north = taken.at('n'), columns.height = taken.at('h');
  else if (!own(taken))
    throw std::runtime_error(source +
                             ": its head names some of the coordinates, and not where this tool writes them; expected "
                             "all three as E, N and H");
  if (head.plain.contains('p')) columns.name = head.plain.at('p');
  if (head.plain.contains('t')) columns.date = head.plain.at('t');
  tell_what_is_not_read(cells, source, columns, head, ignored);
}

bool names_all_coordinates(const std::vector<std::string_view>& cells) {
  std::set<char> found;
  for (const std::string_view cell : cells)
    if (const auto coordinate = coordinate_of(name_and_unit(cell).first)) found.insert(coordinate->which);
  return found.size() == 3;
}

}  // namespace plumbline::loop
