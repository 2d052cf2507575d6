// Tables of a page as their readers see them: rows of cells by the headings above them.
#pragma once

#include <gtest/gtest.h>

#include <cmath>
#include <map>
#include <string>
#include <vector>

namespace plumbline::report::page_tables {

using Row = std::map<std::string, std::string>;

/// Text between two tags, without those in it, its lines with a bar between; the real minus sign and no-break spaces as
/// they are typed.
inline std::string bare(std::string text) {
  for (auto at = text.find('<'); at != std::string::npos; at = text.find('<'))
    text.erase(at, text.find('>', at) + 1 - at);
  for (const auto& [from, to] : {std::pair<std::string, std::string>{"\u2212", "-"}, {"\u00A0", " "}, {"&lt;", "<"}})
    for (auto at = text.find(from); at != std::string::npos; at = text.find(from, at + to.size()))
      text.replace(at, from.size(), to);
  for (auto at = text.find('\n'); at != std::string::npos; at = text.find('\n', at + 1))
    text.replace(at, text.find_first_not_of('\n', at) - at, "|");
  return text;
}

/// Cells of each row of the table that begins first behind `mark`; the first row are the headings.
inline std::vector<std::vector<std::string>> cells_behind(const std::string& page, const std::string& mark) {
  std::vector<std::vector<std::string>> rows;
  const auto begin = page.find("<table", page.find(mark)), end = page.find("</table>", begin);
  if (page.find(mark) == std::string::npos || begin == std::string::npos) return rows;
  for (auto row = page.find("<tr", begin); row < end; row = page.find("<tr", row + 1)) {
    auto& cells = rows.emplace_back();
    const auto stop = std::min(page.find("</tr>", row), end);
    for (auto cell = page.find("<t", row + 1); cell < stop; cell = page.find("<t", cell + 1)) {
      const auto from = page.find('>', cell) + 1;
      cells.push_back(bare(page.substr(from, page.find(page[cell + 2] == 'h' ? "</th>" : "</td>", from) - from)));
    }
  }
  return rows;
}

/// The same by headings.
inline std::vector<Row> rows_behind(const std::string& page, const std::string& mark) {
  std::vector<Row> rows;
  const auto cells = cells_behind(page, mark);
  for (size_t r = 1; r < cells.size(); ++r) {
    EXPECT_EQ(cells[r].size(), cells[0].size()) << "row " << r << " behind " << mark;
    auto& row = rows.emplace_back();
    for (size_t k = 0; k < std::min(cells[r].size(), cells[0].size()); ++k) row[cells[0][k]] = cells[r][k];
  }
  return rows;
}

/// Numbers of a cell such as "1.0, 2.0 ± 0.3": each with as many decimals as it has to have.
inline void expect_numbers(const std::string& cell, const std::vector<double>& values, int decimals) {
  std::vector<std::string> numbers;
  bool within = false;
  for (const char c : cell) {
    const bool digit = (c >= '0' && c <= '9') || c == '.' || c == '-' || c == '+';
    if (digit && !within) numbers.emplace_back();
    if (digit) numbers.back() += c;
    within = digit;
  }
  ASSERT_EQ(numbers.size(), values.size()) << cell;
  for (size_t i = 0; i < values.size(); ++i) {
    EXPECT_NEAR(std::stod(numbers[i]), values[i], 0.501 * std::pow(10, -decimals)) << cell;
    const auto point = numbers[i].find('.');
    EXPECT_EQ(point == std::string::npos ? 0u : numbers[i].size() - point - 1, static_cast<size_t>(decimals)) << cell;
  }
}

}  // namespace plumbline::report::page_tables
