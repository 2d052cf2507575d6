#include "photo/detect/dictionary_tables.hpp"

#include <yaml-cpp/yaml.h>

#include <algorithm>
#include <cctype>
#include <cmath>
#include <regex>
#include <sstream>
#include <stdexcept>

#include "photo/detect/dictionary_sources.hpp"

namespace plumbline::detect {
namespace {

[[noreturn]] void refuse_table(const std::string& file, const std::string& what) {
  throw std::runtime_error(file + ": " + what);
}

/// The value of the first of the keys, whatever their case.
YAML::Node value(const YAML::Node& root, std::initializer_list<const char*> keys) {
  for (const auto& entry : root) {
    std::string key = entry.first.as<std::string>("");
    std::transform(key.begin(), key.end(), key.begin(), [](unsigned char c) { return std::tolower(c); });
    if (std::find(keys.begin(), keys.end(), key) != keys.end()) return entry.second;
  }
  return YAML::Node(YAML::NodeType::Undefined);
}

/// OpenCV's bytesList, which scripts write under whatever name.
YAML::Node matrix_of_bytes(const YAML::Node& root, const std::string& file) {
  const auto is_matrix = [](const YAML::Node& node) {
    return node.IsMap() && node["rows"].IsDefined() && node["data"].IsDefined();
  };
  const YAML::Node named = value(root, {"byteslist"});
  if (named.IsDefined()) return named;
  std::vector<std::string> names;
  for (const auto& entry : root)
    if (is_matrix(entry.second)) names.push_back(entry.first.as<std::string>(""));
  if (names.size() > 1)
    refuse_table(file,
                 "holds several matrices (" + names[0] + ", " + names[1] + "); call the one of the codes bytesList");
  return names.empty() ? YAML::Node(YAML::NodeType::Undefined) : root[names[0]];
}

int stated_size(const YAML::Node& root) {
  if (const YAML::Node size = value(root, {"markersize", "marker_size"}); size.IsDefined()) return size.as<int>(0);
  const YAML::Node bits = value(root, {"nbits"});
  return bits.IsDefined() ? static_cast<int>(std::lround(std::sqrt(std::max(0, bits.as<int>(0))))) : 0;
}

void add(TagDictionary& dictionary, std::vector<std::uint8_t> code, int id = -1) {
  dictionary.ids.push_back(id < 0 ? static_cast<int>(dictionary.codes.size()) : id);
  dictionary.codes.push_back(std::move(code));
}

void add_bytes(const YAML::Node& matrix, const std::string& file, TagDictionary& dictionary) {
  std::vector<int> bytes;
  for (const auto& byte : matrix["data"]) bytes.push_back(byte.as<int>(-1));
  const size_t rows = static_cast<size_t>(std::max(0, matrix["rows"].as<int>(0)));
  const bool even = rows > 0 && !bytes.empty() && bytes.size() % (4 * rows) == 0;
  if (!even || *std::min_element(bytes.begin(), bytes.end()) < 0 || *std::max_element(bytes.begin(), bytes.end()) > 255)
    refuse_table(file, "bytesList has " + std::to_string(rows) + " rows and " + std::to_string(bytes.size()) +
                           " values; expected bytes, four turns of each code in a row, as OpenCV writes it");
  const size_t per_turn = bytes.size() / (4 * rows);
  if (dictionary.size == 0) dictionary.size = size_of_bytes(bytes, per_turn);
  if (dictionary.size < 3 || (static_cast<size_t>(dictionary.size * dictionary.size) + 7) / 8 != per_turn)
    refuse_table(file, "bytesList has " + std::to_string(per_turn) + " bytes a code, which is no marker of " +
                           std::to_string(dictionary.size) + " x " + std::to_string(dictionary.size) +
                           " cells (markerSize)");
  for (size_t row = 0; row < rows; ++row) add(dictionary, code_of_bytes(bytes, 4 * per_turn * row, dictionary.size));
}

void add_numbers(const YAML::Node& list, const std::string& file, TagDictionary& dictionary) {
  const int cells = dictionary.size * dictionary.size;
  if (cells < 9 || cells > 64)
    refuse_table(file, "nBits is missing or not the square of 3 to 8: how many cells the numbers of codeList are");
  for (const auto& number : list) {
    const std::string text = number.as<std::string>("");
    size_t end = 0;
    std::uint64_t code = 0;
    try {
      code = std::stoull(text, &end, 0);
    } catch (const std::exception&) {
    }
    if (end == 0 || end != text.size() || (cells < 64 && code >> cells != 0))
      refuse_table(file, "'" + text + "' in codeList is no number of " + std::to_string(cells) + " bits");
    std::vector<std::uint8_t> bits;
    for (int k = cells - 1; k >= 0; --k) bits.push_back(static_cast<std::uint8_t>(code >> k & 1));
    add(dictionary, std::move(bits));
  }
}

void collect(const YAML::Node& node, std::vector<std::uint8_t>& bits) {
  if (!node.IsScalar()) {
    for (const auto& part : node) collect(part, bits);
    return;
  }
  for (const char c : node.as<std::string>())
    if (c == '0' || c == '1') bits.push_back(static_cast<std::uint8_t>(c - '0'));
}

std::vector<std::uint8_t> bits_of(const YAML::Node& code) {
  std::vector<std::uint8_t> bits;
  collect(code, bits);
  return bits;
}

/// A code of a list: its cells alone, or a map of them and its id.
void add_entry(const YAML::Node& entry, const std::string& file, TagDictionary& dictionary) {
  if (!entry.IsMap()) return add(dictionary, bits_of(entry));
  const YAML::Node number = value(entry, {"id", "number", "index"}),
                   cells = value(entry, {"bits", "code", "cells", "data", "pattern"});
  const int id = number.IsDefined() && number.IsScalar() ? number.as<int>(-1) : -1;
  if (id < 0 || !cells.IsDefined())
    refuse_table(file,
                 "entry " + std::to_string(dictionary.codes.size() + 1) +
                     " of the list of markers has no id or no bits; expected {id: 7, bits: \"1010...\"} or the cells "
                     "alone");
  add(dictionary, bits_of(cells), id);
}

bool is_number(const std::string& text) {
  return !text.empty() && text.size() < 7 && text.find_first_not_of("0123456789") == std::string::npos;
}

/// {"0": ..., "7": ...}: whether every key is the number of a marker.
bool numbers_markers(const YAML::Node& root) {
  bool all = root.IsMap() && root.size() > 0;
  for (const auto& entry : root) all = all && is_number(entry.first.as<std::string>(""));
  return all;
}

bool is_square(size_t cells) {
  const auto size = static_cast<size_t>(std::lround(std::sqrt(static_cast<double>(cells))));
  return size >= 3 && size * size == cells;
}

}  // namespace

TagDictionary parse_dictionary_list(const std::string& text, const std::string& file) {
  static const std::regex code(R"(["']?([01 \t,]{9,})["']?[,;]?\s*)", std::regex::optimize);
  static const std::regex numbered(
      R"(\s*["']?(?:marker_?|id)?\s*(\d{1,6})["']?\s*[:=,;\s]\s*["']?([01]{9,100})["']?[,;]?\s*)",
      std::regex::icase | std::regex::optimize);
  static const std::regex holds_code("[01]{9}");
  TagDictionary plain, with_ids;
  bool all_numbered = true;
  int first_odd = 0, line_number = 0;
  std::istringstream lines(text);
  for (std::string line; std::getline(lines, line);) {
    ++line_number;
    std::smatch match;
    const bool only_bits = std::regex_match(line, match, code);
    std::vector<std::uint8_t> bits;
    if (only_bits) collect(YAML::Node(match[1].str()), bits);
    if (only_bits && bits.size() >= 9) add(plain, bits);
    if (std::regex_match(line, match, numbered) && is_square(static_cast<size_t>(match[2].length())))
      add(with_ids, bits_of(YAML::Node(match[2].str())), std::stoi(match[1]));
    else if (std::regex_search(line, holds_code))
      all_numbered = false;
    if (!only_bits && first_odd == 0 && std::regex_search(line, holds_code)) first_odd = line_number;
  }
  if (all_numbered && !with_ids.codes.empty()) return with_ids;
  if (first_odd > 0)
    refuse_table(file,
                 "line " + std::to_string(first_odd) +
                     " holds more than the cells of one marker; expected them alone in every line, or behind the id in "
                     "every line (7, 1010...)");
  return plain;
}

std::optional<TagDictionary> parse_dictionary_table(const YAML::Node& root, const std::string& file) {
  TagDictionary dictionary;
  if (root.IsSequence()) {
    for (const auto& code : root) add_entry(code, file, dictionary);
    return dictionary;
  }
  if (numbers_markers(root)) {
    for (const auto& entry : root) add(dictionary, bits_of(entry.second), entry.first.as<int>());
    return dictionary;
  }
  dictionary.size = stated_size(root);
  if (const YAML::Node name = value(root, {"name"}); name.IsDefined() && name.IsScalar())
    dictionary.name = name.as<std::string>();
  if (const YAML::Node border = value(root, {"markerborderbits"}); border.IsDefined())
    dictionary.border = border.as<int>(0);
  const YAML::Node bytes = matrix_of_bytes(root, file), numbers = value(root, {"codelist"}),
                   codes = value(root, {"markers", "codes"});
  if (bytes.IsDefined() && bytes.IsMap())
    add_bytes(bytes, file, dictionary);
  else if (numbers.IsDefined() && numbers.IsSequence())
    add_numbers(numbers, file, dictionary);
  else if (codes.IsDefined() && codes.IsSequence())
    for (const auto& code : codes) add_entry(code, file, dictionary);
  if (dictionary.codes.empty()) return std::nullopt;
  return dictionary;
}

}  // namespace plumbline::detect
