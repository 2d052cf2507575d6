#include "detect/dictionary_tables.hpp"

#include <yaml-cpp/yaml.h>

#include <algorithm>
#include <cctype>
#include <cmath>
#include <stdexcept>

#include "detect/dictionary_sources.hpp"

namespace plumbline::detect {
namespace {

[[noreturn]] void refuse(const std::string& file, const std::string& what) {
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
    refuse(file, "holds several matrices (" + names[0] + ", " + names[1] + "); call the one of the codes bytesList");
  return names.empty() ? YAML::Node(YAML::NodeType::Undefined) : root[names[0]];
}

int stated_size(const YAML::Node& root) {
  if (const YAML::Node size = value(root, {"markersize", "marker_size"}); size.IsDefined()) return size.as<int>(0);
  const YAML::Node bits = value(root, {"nbits"});
  return bits.IsDefined() ? static_cast<int>(std::lround(std::sqrt(std::max(0, bits.as<int>(0))))) : 0;
}

void add(TagDictionary& dictionary, std::vector<std::uint8_t> code) {
  dictionary.ids.push_back(static_cast<int>(dictionary.codes.size()));
  dictionary.codes.push_back(std::move(code));
}

void add_bytes(const YAML::Node& matrix, const std::string& file, TagDictionary& dictionary) {
  std::vector<int> bytes;
  for (const auto& byte : matrix["data"]) bytes.push_back(byte.as<int>(-1));
  const size_t rows = static_cast<size_t>(std::max(0, matrix["rows"].as<int>(0)));
  const bool even = rows > 0 && !bytes.empty() && bytes.size() % (4 * rows) == 0;
  if (!even || *std::min_element(bytes.begin(), bytes.end()) < 0 || *std::max_element(bytes.begin(), bytes.end()) > 255)
    refuse(file, "bytesList has " + std::to_string(rows) + " rows and " + std::to_string(bytes.size()) +
                     " values; expected bytes, four turns of each code in a row, as OpenCV writes it");
  const size_t per_turn = bytes.size() / (4 * rows);
  if (dictionary.size == 0) dictionary.size = size_of_bytes(bytes, per_turn);
  if (dictionary.size < 3 || (static_cast<size_t>(dictionary.size * dictionary.size) + 7) / 8 != per_turn)
    refuse(file, "bytesList has " + std::to_string(per_turn) + " bytes a code, which is no marker of " +
                     std::to_string(dictionary.size) + " x " + std::to_string(dictionary.size) + " cells (markerSize)");
  for (size_t row = 0; row < rows; ++row) add(dictionary, code_of_bytes(bytes, 4 * per_turn * row, dictionary.size));
}

void add_numbers(const YAML::Node& list, const std::string& file, TagDictionary& dictionary) {
  const int cells = dictionary.size * dictionary.size;
  if (cells < 9 || cells > 64)
    refuse(file, "nBits is missing or not the square of 3 to 8: how many cells the numbers of codeList are");
  for (const auto& number : list) {
    const std::string text = number.as<std::string>("");
    size_t end = 0;
    std::uint64_t code = 0;
    try {
      code = std::stoull(text, &end, 0);
    } catch (const std::exception&) {
    }
    if (end == 0 || end != text.size() || (cells < 64 && code >> cells != 0))
      refuse(file, "'" + text + "' in codeList is no number of " + std::to_string(cells) + " bits");
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

}  // namespace

std::optional<TagDictionary> parse_dictionary_table(const YAML::Node& root, const std::string& file) {
  TagDictionary dictionary;
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
    for (const auto& code : codes) {
      std::vector<std::uint8_t> bits;
      collect(code, bits);
      add(dictionary, std::move(bits));
    }
  if (dictionary.codes.empty()) return std::nullopt;
  return dictionary;
}

}  // namespace plumbline::detect
