// Staked points of layout tools as reports.
#include <algorithm>
#include <array>
#include <cctype>
#include <cmath>
#include <map>
#include <regex>
#include <set>
#include <stdexcept>

#include "base/text/text.hpp"
#include "loop/fit/facade.hpp"
#include "loop/job/layout_files.hpp"
#include "loop/job/unknown_keys.hpp"

namespace plumbline::loop {
namespace {

/// Which column is what; a tool's own order unless the head of the table says otherwise.
struct StakedColumns {
  std::size_t name = 0, east = 1, north = 2, height = 3, date = std::string::npos;
  std::size_t most() const { return std::max({name, east, north, height}); }
};

std::string lower_case(std::string_view text) {
  std::string out(text);
  std::transform(out.begin(), out.end(), out.begin(), [](unsigned char c) { return std::tolower(c); });
  return out;
}

/// "Easting [m]" is "easting" and "m".
std::pair<std::string, std::string> name_and_unit(std::string_view cell) {
  const std::string text = lower_case(text::trim(cell));
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

/// Takes the head's word for the order of the columns if it names all three. Throws std::runtime_error for a unit that
/// is not metres, for a head that names some of the columns, because the tool's own order may contradict it, and for
/// one that names something twice, such as where a point was to be and where it is. Columns that are not read are named
/// in `ignored`.
void read_head(const std::vector<std::string_view>& cells, const std::string& source, StakedColumns& columns,
               std::vector<std::string>& ignored) {
  std::map<char, std::size_t> found;
  std::vector<std::size_t> unknown;
  for (std::size_t i = 0; i < cells.size(); ++i) {
    const auto [name, unit] = name_and_unit(cells[i]);
    const auto known = meaning_of_heads().find(name);
    if (known == meaning_of_heads().end()) {
      if (!name.empty() && name != "code") unknown.push_back(i);
      continue;
    }
    if (!found.emplace(known->second, i).second)
      throw std::runtime_error(source + ": its columns '" + std::string(text::trim(cells[found.at(known->second)])) +
                               "' and '" + std::string(text::trim(cells[i])) +
                               "' say the same: which of them was measured nobody can tell; keep that one alone");
    if (std::string("enh").find(known->second) != std::string::npos && !unit.empty() && unit != "m" &&
        unit != "metre" && unit != "meter")
      throw std::runtime_error(source + ": its column '" + std::string(text::trim(cells[i])) + "' is in " + unit +
                               "; expected metres: export it in metres");
  }
  if (found.count('e') && found.count('n') && found.count('h'))
    columns.east = found['e'], columns.north = found['n'], columns.height = found['h'];
  else if ((found.count('e') && found['e'] != columns.east) || (found.count('n') && found['n'] != columns.north) ||
           (found.count('h') && found['h'] != columns.height))
    throw std::runtime_error(source +
                             ": its head names some of the coordinates, and not where this tool writes them; expected "
                             "all three as E, N and H");
  if (found.count('p')) columns.name = found['p'];
  if (found.count('t')) columns.date = found['t'];
  std::map<std::string, int> not_read;
  for (const std::size_t i : unknown) {
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

/// Whether a line names easting, northing and height: a head, wherever it stands.
bool names_all_coordinates(const std::vector<std::string_view>& cells) {
  std::set<char> found;
  for (const std::string_view cell : cells)
    if (const auto known = meaning_of_heads().find(name_and_unit(cell).first); known != meaning_of_heads().end())
      found.insert(known->second);
  return found.contains('e') && found.contains('n') && found.contains('h');
}

/// "# Units: metres", "# Units = m", "# coordinates in units [m]". Throws std::runtime_error if a comment says that
/// they are others. What is called a unit and is none of lengths ("Total station unit: TS16") says nothing.
void look_at_units(std::string_view comment, std::size_t line, const std::string& source) {
  static const std::regex said("(^[#/;\\s]*|\\b)units?\\b(?: of)?[\\s:=(\\[]*([^\\])]*)");
  static const std::regex metres("m(et(re|er)s?)?\\b.*"),
      others(
          "(us|u\\.s\\.|survey|international|ft|sft|feet|foot|[mck]m|(milli|centi|kilo)met(re|er)s?|in|inch(es)?|yards?"
          ")\\b.*");
  const std::string words = lower_case(comment.substr(0, 200));  // the expressions go deeper with each letter
  std::smatch found;
  if (!std::regex_search(words, found, said)) return;
  const bool heads = text::trim(found.prefix().str() + found[1].str()).find_first_not_of("#/; ") == std::string::npos;
  const std::string unit(text::trim(found[2].str()));
  if (std::regex_match(unit, metres) || (!std::regex_match(unit, others) && !heads)) return;
  throw std::runtime_error(source + ":" + std::to_string(line) + ": its units are '" + unit +
                           "'; expected metres: export it in metres");
}

/// Where ';' separates cells a comma is that of a decimal fraction.
std::optional<double> staked_number(std::string_view cell, LayoutFormat format) {
  const std::string_view text = text::trim(cell);
  const bool comma = format == LayoutFormat::hilti && text.find(',') != std::string_view::npos &&
                     text.find('.') == std::string_view::npos;
  const auto number = text::parse_number(text, comma ? ',' : '.');
  return number && std::isfinite(*number) ? number : std::nullopt;
}

}  // namespace

ActualsT read_staked(const std::string& text, LayoutFormat format, const std::string& source) {
  ActualsT out;
  out.sources.push_back(source);
  const std::string decoded = text::decode_text(text).text;
  std::set<std::string> seen;
  StakedColumns columns;
  if (format == LayoutFormat::trimble) columns.north = 1, columns.east = 2;
  bool first = true;
  for (const text::Line& line : text::split_lines(decoded)) {
    if (text::trim(line.text).empty()) continue;
    if (text::trim(line.text).front() == '#') {  // some writers put what they are before the head
      look_at_units(line.text, line.number, source);
      continue;
    }
    const std::string place = source + ":" + std::to_string(line.number);
    const auto refuse = [&](const std::string& why) { out.refused.push_back(place + ": " + why); };
    const auto split = text::split(line.text, format == LayoutFormat::hilti ? ';' : ',');
    const std::vector<std::string_view> cells(split.begin(), split.end());
    // A first point with one coordinate that cannot be read is no head.
    const bool is_head = (std::exchange(first, false) || names_all_coordinates(cells)) &&
                         std::none_of(cells.begin() + 1, cells.end(),
                                      [&](std::string_view cell) { return staked_number(cell, format).has_value(); });
    if (is_head) {
      read_head(cells, source, columns, out.ignored);
      continue;
    }
    if (cells.size() <= columns.most()) {
      refuse("found " + std::to_string(cells.size()) + " columns, expected a name and three coordinates");
      continue;
    }
    const std::string name(text::trim(cells[columns.name]));
    const std::array<std::optional<double>, 3> at = {staked_number(cells[columns.east], format),
                                                     staked_number(cells[columns.north], format),
                                                     staked_number(cells[columns.height], format)};
    if (!at[0] || !at[1] || !at[2]) {
      refuse("the coordinates of '" + name + "' are no numbers");
      continue;
    }
    if (!seen.insert(name).second) {
      refuse("'" + name + "' occurs twice; the first is taken");
      continue;
    }
    auto actual = std::make_unique<ActualT>();
    actual->item = name, actual->outcome = "done", actual->by = source, actual->source = place;
    actual->measured = {*at[0], *at[1], *at[2]};
    actual->sigma.setConstant(kUnknown), actual->setting.setConstant(kUnknown);
    if (columns.date < cells.size()) actual->at = std::string(text::trim(cells[columns.date]));
    out.items.push_back(std::move(actual));
  }
  return out;
}

}  // namespace plumbline::loop
