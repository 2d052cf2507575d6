#include "base/text/csv_table.hpp"

#include <algorithm>
#include <array>
#include <utility>

namespace plumbline::text {
namespace {

constexpr std::size_t kSampledLines = 200;
constexpr std::size_t kLongestSampledLine = 4096;
constexpr std::size_t kMostTitles = 10;   // rows above a header
constexpr std::size_t kMostCells = 1000;  // of one row; a longer row is no survey table

bool is_comment(std::string_view line) {
  line = trim(line);
  return line.starts_with('#') || line.starts_with('%') || line.starts_with("//");
}

// Apostrophes, then what a spreadsheet begins a formula with: csv_field writes one apostrophe more than the text has.
bool has_formula_sign(std::string_view text) {
  const std::size_t first = text.find_first_not_of('\'');
  return first != std::string_view::npos && std::string_view("=+-@").find(text[first]) != std::string_view::npos;
}

// A comment mark with a name at once behind it, and at least two numbers in the cells after the first.
bool is_doubtful(std::string_view line, const CsvRow& row, const CsvTable& table) {
  line = trim(line);
  const std::size_t mark = line.starts_with("//") ? 2 : 1;
  if (line.size() <= mark || std::string_view(" \t#%/-=*").find(line[mark]) != std::string_view::npos) return false;
  if (row.cells.size() < 3 ||
      (!table.header.empty() && row.cells.size() < std::min<std::size_t>(table.header.size(), 4)))
    return false;
  std::size_t numbers = 0;
  for (std::size_t i = 1; i < row.cells.size(); ++i) numbers += table.number(row.cells[i]) ? 1 : 0;
  return numbers >= 2;
}

std::vector<CsvCell> cells_of(std::string_view line, char delimiter) {
  std::vector<CsvCell> cells;
  const bool blanks = delimiter == ' ';
  const auto is_delimiter = [&](char c) { return blanks ? c == ' ' || c == '\t' : c == delimiter; };
  std::size_t i = 0, counted = 0, characters = 0;
  while (cells.size() < kMostCells) {
    while (i < line.size() && (line[i] == ' ' || line[i] == '\t') && (blanks || !is_delimiter(line[i]))) ++i;
    if (blanks && i >= line.size()) break;
    CsvCell cell;
    characters += CharacterLine(line.substr(counted, i - counted)).size();
    counted = i;
    cell.column = static_cast<int>(characters) + 1;
    if (i < line.size() && line[i] == '"') {
      for (++i; i < line.size(); ++i) {
        if (line[i] != '"') {
          cell.text.push_back(line[i]);
        } else if (i + 1 < line.size() && line[i + 1] == '"') {
          cell.text.push_back('"'), ++i;
        } else {
          ++i;
          break;
        }
      }
      while (i < line.size() && !is_delimiter(line[i])) cell.text.push_back(line[i++]);
    } else {
      const std::size_t start = i;
      while (i < line.size() && !is_delimiter(line[i])) ++i;
      cell.text = line.substr(start, i - start);
    }
    cell.text = std::string(trim(cell.text));
    if (cell.text.starts_with('\'') && has_formula_sign(cell.text)) cell.text.erase(0, 1);
    cells.push_back(std::move(cell));
    if (i >= line.size()) break;
    ++i;
  }
  return cells;
}

struct Dialect {
  char delimiter, decimal;
};

// How many parts of the line are numbers; quotes around one do not matter here.
std::size_t numbers_in(std::string_view line, const Dialect& dialect) {
  const auto is_delimiter = [&](char c) { return c == dialect.delimiter || (dialect.delimiter == ' ' && c == '\t'); };
  std::size_t numbers = 0;
  for (std::size_t start = 0; start <= line.size();) {
    std::size_t end = start;
    while (end < line.size() && !is_delimiter(line[end])) ++end;
    std::string_view part = trim(line.substr(start, end - start));
    if (part.size() > 2 && part.front() == '"' && part.back() == '"') part = part.substr(1, part.size() - 2);
    numbers += !part.empty() && parse_number(part, dialect.decimal) ? 1 : 0;
    start = end + 1;
  }
  return numbers;
}

CsvHeaderCell header_cell(std::string_view text, const std::map<std::string, std::string>& known_names) {
  CsvHeaderCell cell;
  const std::size_t open = text.find_first_of("[(");
  if (open != std::string_view::npos) {
    const std::size_t close = text.find_first_of("])", open);
    cell.unit = to_lower(trim(text.substr(open + 1, close == std::string_view::npos ? close : close - open - 1)));
    text = text.substr(0, open);
  }
  for (const char c : to_lower(trim(text))) {
    if ((c >= 'a' && c <= 'z') || (c >= '0' && c <= '9') || static_cast<unsigned char>(c) >= 0x80)
      cell.name.push_back(c);
    else if (!cell.name.empty() && cell.name.back() != '_')
      cell.name.push_back('_');
  }
  while (!cell.name.empty() && cell.name.back() == '_') cell.name.pop_back();
  cell.written = cell.name;
  if (const auto known = known_names.find(cell.name); known != known_names.end()) {
    cell.name = known->second;
    return cell;
  }
  // "sd_m", "hz_gon": a known name with its unit behind.
  const std::size_t bar = cell.name.rfind('_');
  if (bar == std::string::npos || !cell.unit.empty()) return cell;
  if (const auto known = known_names.find(cell.name.substr(0, bar)); known != known_names.end()) {
    cell.unit = cell.name.substr(bar + 1);
    cell.written = cell.name.substr(0, bar);
    cell.name = known->second;
  }
  return cell;
}

// Empty unless two cells are known names and none but the first is a number.
std::vector<CsvHeaderCell> header_of(const std::vector<CsvCell>& cells, char decimal,
                                     const std::map<std::string, std::string>& known_names) {
  std::vector<CsvHeaderCell> header;
  int known = 0;
  for (std::size_t i = 0; i < cells.size(); ++i) {
    if (i > 0 && parse_number(cells[i].text, decimal)) return {};
    header.push_back(header_cell(cells[i].text, known_names));
    for (const auto& [ignored, name] : known_names)
      if (header.back().name == name) {
        ++known;
        break;
      }
  }
  if (known < 2) header.clear();
  return header;
}

// The index among `lines` of a header that nothing but titles stands above; 0 if there is none.
std::size_t header_under_titles(const std::vector<Line>& lines, const Dialect& dialect,
                                const std::map<std::string, std::string>& known_names) {
  std::size_t rows = 0, most_filled = 0;
  for (std::size_t at = 0; at < lines.size() && rows <= kMostTitles; ++at) {
    if (trim(lines[at].text).empty() || is_comment(lines[at].text)) continue;
    const std::vector<CsvCell> cells = cells_of(lines[at].text.substr(0, kLongestSampledLine), dialect.delimiter);
    std::size_t filled = 0, numbers = 0;
    for (const CsvCell& cell : cells)
      filled += !cell.text.empty(), numbers += parse_number(cell.text, dialect.decimal) ? 1 : 0;
    if (filled == 0) continue;
    if (!header_of(cells, dialect.decimal, known_names).empty()) return filled > most_filled ? at : 0;
    if (numbers > 1) return 0;
    most_filled = std::max(most_filled, filled);
    ++rows;
  }
  return 0;
}

// How many cells of the first row are names we know, if at least two are.
std::size_t names_in(const std::vector<Line>& lines, char delimiter,
                     const std::map<std::string, std::string>& known_names) {
  for (const Line& line : lines) {
    if (trim(line.text).empty()) continue;
    std::size_t known = 0;
    for (const CsvCell& cell : cells_of(line.text.substr(0, kLongestSampledLine), delimiter))
      known += cell.text.size() < 64 && known_names.contains(header_cell(cell.text, known_names).name) ? 1 : 0;
    return known < 2 ? 0 : known;
  }
  return 0;
}

// The same of the header under titles.
std::size_t names_under_titles(const std::vector<Line>& lines, const Dialect& dialect,
                               const std::map<std::string, std::string>& known_names) {
  const std::size_t at = header_under_titles(lines, dialect, known_names);
  return at == 0 ? 0 : names_in({lines[at]}, dialect.delimiter, known_names);
}

// The pair that makes most cells of the first row known names, then most cells numbers; in a tie the earlier one of the
// list.
Dialect detect(const std::vector<Line>& lines, const std::map<std::string, std::string>& known_names,
               TitleRows titles) {
  constexpr std::array<Dialect, 9> candidates = {Dialect{';', '.'},  Dialect{'\t', '.'}, Dialect{',', '.'},
                                                 Dialect{'|', '.'},  Dialect{' ', '.'},  Dialect{';', ','},
                                                 Dialect{'\t', ','}, Dialect{'|', ','},  Dialect{' ', ','}};
  Dialect best = {',', '.'};
  std::pair<std::size_t, std::size_t> most = {0, 0};
  // A blank separates nothing where every row has tabs: "Point ID<tab>Slope Dist".
  const bool tabs = std::all_of(lines.begin(), lines.end(), [](const Line& line) {
    return trim(line.text).empty() || is_comment(line.text) || std::count(line.text.begin(), line.text.end(), '\t') > 1;
  });
  const bool under_titles = titles == TitleRows::passed_over &&
                            std::none_of(candidates.begin(), candidates.end(), [&](const Dialect& candidate) {
                              return names_in(lines, candidate.delimiter, known_names) > 0;
                            });
  for (const Dialect& candidate : candidates) {
    if (tabs && candidate.delimiter == ' ') continue;
    std::size_t numbers = 0, sampled = 0;
    const std::size_t names = under_titles ? names_under_titles(lines, candidate, known_names)
                                           : names_in(lines, candidate.delimiter, known_names);
    for (const Line& line : lines) {
      if (trim(line.text).empty() || is_comment(line.text)) continue;
      if (++sampled > kSampledLines) break;
      numbers += numbers_in(line.text.substr(0, kLongestSampledLine), candidate);
    }
    if (std::pair(names, numbers) > most) most = {names, numbers}, best = candidate;
  }
  return best;
}

}  // namespace

std::string CsvTable::dialect() const {
  const std::string shown = delimiter == '\t' ? "tab" : delimiter == ' ' ? "blank" : std::string("'") + delimiter + "'";
  return "delimiter " + shown + ", decimal separator '" + decimal + "'";
}

std::string titles_left_out(int titles) {
  return titles == 1 ? "the row above the header is a title, and is left out"
                     : std::to_string(titles) + " rows above the header are titles, and are left out";
}

Thousands thousands_of(const CsvTable& table, const std::vector<std::size_t>& columns) {
  Thousands result;
  if (table.delimiter == ',' && table.decimal == '.') return result;  // who groups with '.' separates cells with ';'
  for (const CsvRow& row : table.rows)
    for (std::size_t column = 1; column < row.cells.size(); ++column) {  // the first has names
      if (!table.number(row.cells[column])) continue;
      const bool asked = std::find(columns.begin(), columns.end(), column) != columns.end();
      std::string_view digits = row.cells[column].text;
      if (!digits.empty() && (digits[0] == '-' || digits[0] == '+')) digits.remove_prefix(1);
      const std::size_t at = digits.find(table.decimal);
      if (at == std::string_view::npos) {
        if (!asked || digits.find_first_not_of("0123456789") != digits.npos) continue;
        if (digits.size() > 3) return {};  // nobody groups here
        if (digits == "0") continue;       // says nothing
        result.integers = true;
        continue;
      }
      // "0,250", "1234,567" and "1,5" are no thousands, whatever column they are in.
      if (at < 1 || at > 3 || digits.size() != at + 4 || digits[0] == '0') return {};
      if (asked && result.example.empty()) result.example = row.cells[column].text;
    }
  return result;
}

CsvTable read_csv(std::string_view bytes, const std::map<std::string, std::string>& known_names, TitleRows titles) {
  CsvTable table;
  table.decoded = decode_text(bytes);
  auto lines = split_lines(table.decoded.text);
  // Spreadsheets may write "sep=;" in front: the delimiter is found without it.
  if (!lines.empty() && to_lower(trim(lines.front().text)).starts_with("sep=")) lines.erase(lines.begin());
  const Dialect dialect = detect(lines, known_names, titles);
  table.delimiter = dialect.delimiter;
  table.decimal = dialect.decimal;
  const std::size_t under_titles =
      titles == TitleRows::passed_over ? header_under_titles(lines, dialect, known_names) : 0;
  bool first = true;
  for (std::size_t at = 0; at < lines.size(); ++at) {
    const Line& line = lines[at];
    std::string_view text = line.text;
    if (trim(text).empty()) continue;
    const bool comment = is_comment(text);
    if (comment && first) text.remove_prefix(std::min(text.find_first_not_of("#%/ \t"), text.size()));
    CsvRow row = {line.number, cells_of(text, table.delimiter)};
    // A spreadsheet writes rows of delimiters where nothing stands.
    if (std::all_of(row.cells.begin(), row.cells.end(), [](const CsvCell& cell) { return cell.text.empty(); }))
      continue;
    if (at < under_titles && !comment) {
      ++table.titles;
      continue;
    }
    if (first && table.header.empty()) {
      table.header = header_of(row.cells, table.decimal, known_names);
      if (!table.header.empty()) {
        table.header_line = line.number;
        first = false;
        continue;
      }
    }
    if (comment) {
      CsvRow whole = {line.number, cells_of(line.text, table.delimiter)};
      if (is_doubtful(line.text, whole, table)) table.doubtful.push_back(std::move(whole));
      continue;
    }
    first = false;
    table.rows.push_back(std::move(row));
  }
  return table;
}

std::string csv_field(std::string_view plain_text) {
  const bool formula = has_formula_sign(plain_text) && !parse_number(plain_text, '.');  // "-1" is a number to both
  const std::string text = (formula ? "'" : "") + std::string(plain_text);
  const bool plain = text.find_first_of(",;\"\r\n\t") == std::string::npos && trim(text) == text &&
                     !(!text.empty() && (text[0] == '#' || text[0] == '%' || text[0] == '/'));
  if (plain) return text;
  std::string out = "\"";
  for (const char c : text) {
    if (c == '"') out += '"';
    out += c == '\r' || c == '\n' ? ' ' : c;  // a row is one line
  }
  return out + '"';
}

}  // namespace plumbline::text
