#include "photo/detect/dictionary_sources.hpp"

#include <algorithm>
#include <cmath>
#include <map>
#include <regex>
#include <stdexcept>

namespace plumbline::detect {
namespace {

[[noreturn]] void refuse_source(const std::string& file, const std::string& what) {
  throw std::runtime_error(file + ": " + what);
}

const std::regex& byte_array() {
  static const std::regex pattern(R"((\w+)\s*\[\s*\d*\s*\]\s*\[\s*4\s*\]\s*\[\s*(\d+)\s*\]\s*=)");
  return pattern;
}

/// Without comments, so that numbers in them do not count.
std::string code_alone(const std::string& text) {
  std::string result;
  for (size_t i = 0; i < text.size(); ++i) {
    if (text.compare(i, 2, "//") == 0) {
      i = text.find('\n', i);
      if (i == std::string::npos) break;
    } else if (text.compare(i, 2, "/*") == 0) {
      i = text.find("*/", i);
      if (i == std::string::npos) break;
      ++i;
      continue;
    }
    result += text[i];
  }
  return result;
}

std::vector<std::string> matches(const std::string& text, const char* pattern) {
  const std::regex expression(pattern);
  std::vector<std::string> found;
  for (std::sregex_iterator it(text.begin(), text.end(), expression), end; it != end; ++it)
    found.push_back((*it)[1].str());
  return found;
}

/// `name[i] = value;` of libapriltag, negative where cells lie left or above of the square.
std::map<int, int> assigned(const std::string& text, const std::string& name) {
  const std::regex expression(name + R"(\s*\[\s*(\d+)\s*\]\s*=\s*(-?\d+))");
  std::map<int, int> values;
  for (std::sregex_iterator it(text.begin(), text.end(), expression), end; it != end; ++it)
    if ((*it)[1].length() < 6 && (*it)[2].length() < 6) values[std::stoi((*it)[1])] = std::stoi((*it)[2]);
  return values;
}

int number_after(const std::string& text, const char* pattern) {
  const auto found = matches(text, pattern);
  return found.empty() || found[0].size() > 6 ? -1 : std::stoi(found[0]);
}

/// Cells of every bit in order, counted from the first cell inside of the border.
std::vector<std::pair<int, int>> cells_of_bits(const std::string& text, const std::string& file, int& size) {
  const auto x = assigned(text, "bit_x"), y = assigned(text, "bit_y");
  std::vector<std::pair<int, int>> cells;
  if (x.empty()) {
    size = number_after(text, R"(->\s*d\s*=\s*(\d+))");
    const int bits = number_after(text, R"((?:TagCodes\w*|super)\s*\(\s*(\d+)\s*,)");
    if (size < 0 && bits > 0) size = static_cast<int>(std::lround(std::sqrt(bits)));
    if (size < 3 || size > 8)
      refuse_source(
          file,
          "holds codes, but neither bit_x and bit_y nor the size of the tags is in it (libapriltag's tag*.c have "
          "them)");
    for (int row = 0; row < size; ++row)
      for (int column = 0; column < size; ++column) cells.emplace_back(column, row);
    return cells;
  }
  const int width = number_after(text, R"(width_at_border\s*=\s*(\d+))");
  size = width - 2;
  const bool reversed = !matches(text, R"(reversed_border\s*=\s*(true|1))").empty();
  for (const auto& [bit, column] : x) {
    const auto row = y.find(bit);
    if (row == y.end() || bit != static_cast<int>(cells.size()))
      refuse_source(file, "bit " + std::to_string(bit) + " has no bit_x or no bit_y");
    cells.emplace_back(column - 1, row->second - 1);
  }
  const bool inside = std::all_of(cells.begin(), cells.end(), [&](const auto& c) {
    return std::min(c.first, c.second) >= 0 && std::max(c.first, c.second) < size;
  });
  if (reversed || !inside || size < 3 || size > 8 || cells.size() != static_cast<size_t>(size) * size)
    refuse_source(
        file, "is a family of libapriltag whose " + std::to_string(cells.size()) +
                  " cells do not fill a square inside one black border; only such families are read from a file. Use "
                  "detector=apriltag with its name if libapriltag has it");
  return cells;
}

TagDictionary parse_apriltag(const std::string& text, const std::string& file) {
  TagDictionary dictionary;
  const auto cells = cells_of_bits(text, file, dictionary.size);
  for (const std::string& digits : matches(text, R"(\b0x([0-9a-fA-F]{4,16})[uUlL]*\b)")) {
    const std::uint64_t value = std::stoull(digits, nullptr, 16);
    if (cells.size() < 64 && value >> cells.size() != 0)
      refuse_source(file, "the code 0x" + digits + " has more than " + std::to_string(cells.size()) + " bits");
    std::vector<std::uint8_t> code(cells.size());
    for (size_t bit = 0; bit < cells.size(); ++bit)
      code[cells[bit].second * dictionary.size + cells[bit].first] =
          static_cast<std::uint8_t>(value >> (cells.size() - 1 - bit) & 1);
    dictionary.ids.push_back(static_cast<int>(dictionary.codes.size()));
    dictionary.codes.push_back(std::move(code));
  }
  if (dictionary.codes.empty()) refuse_source(file, "holds no codes in hexadecimal (0x...)");
  const int stated = number_after(text, R"(ncodes\s*=\s*(\d+))");
  if (stated >= 0 && stated != static_cast<int>(dictionary.codes.size()))
    refuse_source(file, "ncodes is " + std::to_string(stated) + ", but there are " +
                            std::to_string(dictionary.codes.size()) + " codes");
  const auto names = matches(text, R"raw(name\s*=\s*(?:strdup\s*\(\s*)?"(\w+)")raw");
  if (!names.empty()) dictionary.name = names[0];
  return dictionary;
}

/// Whether the second of the four codes is the first after a quarter turn: tells 3 x 3 from 4 x 4 cells in two bytes.
bool turns(const std::vector<int>& bytes, size_t per_turn, int size) {
  const auto upright = code_of_bytes(bytes, 0, size), next = code_of_bytes(bytes, per_turn, size);
  bool left = true, right = true;
  for (int row = 0; row < size; ++row)
    for (int column = 0; column < size; ++column) {
      const auto at = [&](const auto& code, int r, int c) { return code[r * size + c]; };
      left &= at(next, size - 1 - column, row) == at(upright, row, column);
      right &= at(next, column, size - 1 - row) == at(upright, row, column);
    }
  return left || right;
}

TagDictionary parse_byte_array(const std::string& text, const std::string& file) {
  std::smatch head;
  std::regex_search(text, head, byte_array());
  const std::string rest = head.suffix();
  if (std::regex_search(rest, byte_array()))
    refuse_source(file, "holds several dictionaries; put the one that is meant in a file of its own");
  const size_t per_turn = head[2].length() < 3 ? static_cast<size_t>(std::stoi(head[2])) : 0;
  std::vector<int> bytes;
  for (const std::string& digits : matches(rest.substr(0, rest.find(';')), R"(\b(0x[0-9a-fA-F]+|\d+)\b)")) {
    const long value = digits.size() > 4 ? 256 : std::stol(digits, nullptr, 0);
    if (value > 255) refuse_source(file, "'" + digits + "' in " + head[1].str() + " is no byte");
    bytes.push_back(static_cast<int>(value));
  }
  TagDictionary dictionary;
  dictionary.name = head[1].str();
  if (per_turn == 0 || bytes.empty() || bytes.size() % (4 * per_turn) != 0)
    refuse_source(
        file, head[1].str() + " has " + std::to_string(bytes.size()) + " bytes, no multiple of 4 x " + head[2].str());
  dictionary.size = size_of_bytes(bytes, per_turn);
  if (dictionary.size == 0)
    refuse_source(file, "the four codes of a marker in " + head[1].str() + " are not its four turns");
  for (size_t first = 0; first < bytes.size(); first += 4 * per_turn) {
    dictionary.ids.push_back(static_cast<int>(dictionary.codes.size()));
    dictionary.codes.push_back(code_of_bytes(bytes, first, dictionary.size));
  }
  return dictionary;
}

}  // namespace

std::vector<std::uint8_t> code_of_bytes(const std::vector<int>& bytes, size_t first, int size) {
  const int cells = size * size;
  std::vector<std::uint8_t> bits;
  for (int k = 0; k < cells; ++k) {
    // The last byte holds the remaining bits at its low end.
    const int in_byte = k / 8 < cells / 8 ? 8 : cells % 8;
    bits.push_back(static_cast<std::uint8_t>(bytes[first + static_cast<size_t>(k / 8)] >> (in_byte - 1 - k % 8) & 1));
  }
  return bits;
}

int size_of_bytes(const std::vector<int>& bytes, size_t per_turn) {
  for (int size = 3; size <= 10; ++size)
    if ((static_cast<size_t>(size * size) + 7) / 8 == per_turn && turns(bytes, per_turn, size)) return size;
  return 0;
}

bool is_dictionary_source(const std::string& text) {
  return std::regex_search(text, byte_array()) || text.find("bit_x") != std::string::npos ||
         std::regex_search(text, std::regex(R"(\b0x[0-9a-fA-F]{4,16}[uUlL]*\s*[,;}])"));
}

TagDictionary parse_dictionary_source(const std::string& text, const std::string& file) {
  const std::string code = code_alone(text);
  return std::regex_search(code, byte_array()) ? parse_byte_array(code, file) : parse_apriltag(code, file);
}

}  // namespace plumbline::detect
