#include "detect/tag_dictionary.hpp"

#include <yaml-cpp/yaml.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <opencv2/aruco/dictionary.hpp>
#include <sstream>
#include <stdexcept>

namespace plumbline::detect {
namespace {

struct Builtin {
  const char* name;
  int number;
};

constexpr std::array<Builtin, 21> builtins = {{
    {"DICT_4X4_50", cv::aruco::DICT_4X4_50},
    {"DICT_4X4_100", cv::aruco::DICT_4X4_100},
    {"DICT_4X4_250", cv::aruco::DICT_4X4_250},
    {"DICT_4X4_1000", cv::aruco::DICT_4X4_1000},
    {"DICT_5X5_50", cv::aruco::DICT_5X5_50},
    {"DICT_5X5_100", cv::aruco::DICT_5X5_100},
    {"DICT_5X5_250", cv::aruco::DICT_5X5_250},
    {"DICT_5X5_1000", cv::aruco::DICT_5X5_1000},
    {"DICT_6X6_50", cv::aruco::DICT_6X6_50},
    {"DICT_6X6_100", cv::aruco::DICT_6X6_100},
    {"DICT_6X6_250", cv::aruco::DICT_6X6_250},
    {"DICT_6X6_1000", cv::aruco::DICT_6X6_1000},
    {"DICT_7X7_50", cv::aruco::DICT_7X7_50},
    {"DICT_7X7_100", cv::aruco::DICT_7X7_100},
    {"DICT_7X7_250", cv::aruco::DICT_7X7_250},
    {"DICT_7X7_1000", cv::aruco::DICT_7X7_1000},
    {"DICT_ARUCO_ORIGINAL", cv::aruco::DICT_ARUCO_ORIGINAL},
    {"tag16h5", cv::aruco::DICT_APRILTAG_16h5},
    {"tag25h9", cv::aruco::DICT_APRILTAG_25h9},
    {"tag36h10", cv::aruco::DICT_APRILTAG_36h10},
    {"tag36h11", cv::aruco::DICT_APRILTAG_36h11},
}};

std::string lower(std::string text) {
  std::transform(text.begin(), text.end(), text.begin(), [](unsigned char c) { return std::tolower(c); });
  return text;
}

/// "dict_6x6_1000", "6x6_1000" and "DICT_APRILTAG_36h11" in one form.
std::string canonical(const std::string& name) {
  std::string text = lower(name);
  for (const std::string prefix : {"cv::aruco::", "aruco.", "dict_"})
    if (text.rfind(prefix, 0) == 0) text.erase(0, prefix.size());
  if (text.rfind("apriltag_", 0) == 0) text.replace(0, 9, "tag");
  return text;
}

/// Cells after a quarter turn.
std::vector<std::uint8_t> turned(const std::vector<std::uint8_t>& code, int size) {
  std::vector<std::uint8_t> result(code.size());
  for (int row = 0; row < size; ++row)
    for (int column = 0; column < size; ++column)
      result[static_cast<size_t>(column * size + size - 1 - row)] = code[static_cast<size_t>(row * size + column)];
  return result;
}

int distance(const std::vector<std::uint8_t>& a, const std::vector<std::uint8_t>& b) {
  int different = 0;
  for (size_t i = 0; i < a.size(); ++i) different += a[i] != b[i];
  return different;
}

[[noreturn]] void refuse(const std::string& file, const std::string& what) {
  throw std::runtime_error(file + ": " + what +
                           ". A dictionary file holds nmarkers, markersize, maxCorrectionBits and marker_0, marker_1, "
                           "... as strings of zeros and ones, as OpenCV writes it");
}

std::vector<std::uint8_t> bits_of(const std::string& text) {
  std::vector<std::uint8_t> bits;
  for (const char c : text)
    if (c == '0' || c == '1') bits.push_back(static_cast<std::uint8_t>(c - '0'));
  return bits;
}

/// Two codes that look alike in some turn would be taken for each other; the smallest distance also limits what can be
/// corrected.
void check_codes(TagDictionary& dictionary, const std::string& file, int stated_correction) {
  int smallest = dictionary.size * dictionary.size;
  for (size_t i = 0; i < dictionary.codes.size(); ++i) {
    std::vector<std::uint8_t> other = dictionary.codes[i];
    for (int turn = 0; turn < 4; ++turn) {
      // A code that is like itself in another turn has no upright position.
      for (size_t j = turn == 0 ? i + 1 : i; j < dictionary.codes.size(); ++j) {
        const int d = distance(other, dictionary.codes[j]);
        if (d == 0)
          refuse(file, i == j ? "marker_" + std::to_string(dictionary.ids[i]) +
                                    " looks the same after a turn, so its upright position cannot be told"
                              : "marker_" + std::to_string(dictionary.ids[i]) + " and marker_" +
                                    std::to_string(dictionary.ids[j]) + " have the same cells up to a turn");
        smallest = std::min(smallest, d);
      }
      other = turned(other, dictionary.size);
    }
  }
  const int safe = (smallest - 1) / 2;
  dictionary.correctable_bits = stated_correction >= 0 ? std::min(stated_correction, safe) : safe;
}

/// name / nbits / one code a line, as the ArUco library (version 3) has it.
TagDictionary parse_aruco_list(const std::string& text, const std::string& file) {
  TagDictionary dictionary;
  std::istringstream lines(text);
  for (std::string line; std::getline(lines, line);) {
    const std::vector<std::uint8_t> bits = bits_of(line);
    const bool only_bits = line.find_first_not_of("01 \t\r,") == std::string::npos;
    if (!only_bits || bits.size() < 9) continue;
    dictionary.ids.push_back(static_cast<int>(dictionary.codes.size()));
    dictionary.codes.push_back(bits);
  }
  if (dictionary.codes.empty()) refuse(file, "no marker codes found");
  return dictionary;
}

TagDictionary parse_yaml(const std::string& text, const std::string& file, int& correction) {
  std::string body = text;
  if (body.rfind("%YAML", 0) == 0) body.erase(0, body.find('\n') == std::string::npos ? body.size() : body.find('\n'));
  TagDictionary dictionary;
  YAML::Node root;
  try {
    root = YAML::Load(body);
  } catch (const YAML::Exception& error) {
    refuse(file, "neither YAML nor JSON (line " + std::to_string(error.mark.line + 1) + ": " + error.msg + ")");
  }
  if (!root.IsMap()) return parse_aruco_list(text, file);
  int stated_markers = -1;
  std::map<int, std::vector<std::uint8_t>> codes;
  for (const auto& entry : root) {
    const std::string key = lower(entry.first.as<std::string>(""));
    if (key == "nmarkers") stated_markers = entry.second.as<int>(-1);
    if (key == "markersize") dictionary.size = entry.second.as<int>(0);
    if (key == "maxcorrectionbits") correction = entry.second.as<int>(-1);
    if (key == "name" && entry.second.IsScalar()) dictionary.name = entry.second.as<std::string>("");
    if (key.rfind("marker_", 0) != 0) continue;
    std::string bits;
    if (entry.second.IsScalar())
      bits = entry.second.as<std::string>();
    else
      for (const auto& row : entry.second) {
        if (row.IsScalar()) bits += row.as<std::string>();
        for (const auto& cell : row) bits += cell.as<std::string>("");
      }
    int id = -1;
    std::istringstream(key.substr(7)) >> id;
    if (id < 0) refuse(file, "'" + key + "' has no number");
    if (!codes.emplace(id, bits_of(bits)).second) refuse(file, "'" + key + "' occurs twice");
  }
  if (codes.empty()) return parse_aruco_list(text, file);
  for (auto& [id, code] : codes) {
    dictionary.ids.push_back(id);
    dictionary.codes.push_back(std::move(code));
  }
  if (stated_markers >= 0 && stated_markers != static_cast<int>(dictionary.codes.size()))
    refuse(file, "nmarkers is " + std::to_string(stated_markers) + ", but there are " +
                     std::to_string(dictionary.codes.size()) + " markers");
  return dictionary;
}

}  // namespace

std::string builtin_dictionary_names() {
  std::string names;
  for (const Builtin& builtin : builtins) names += (names.empty() ? "" : ", ") + std::string(builtin.name);
  return names;
}

TagDictionary builtin_dictionary(const std::string& name) {
  for (const Builtin& builtin : builtins) {
    if (canonical(name) != canonical(builtin.name)) continue;
    const auto source = cv::aruco::getPredefinedDictionary(builtin.number);
    TagDictionary dictionary;
    dictionary.name = builtin.name;
    dictionary.size = source->markerSize;
    dictionary.correctable_bits = source->maxCorrectionBits;
    dictionary.turned = std::string(builtin.name).rfind("tag", 0) == 0;
    for (int id = 0; id < source->bytesList.rows; ++id) {
      const cv::Mat bits =
          cv::aruco::Dictionary::getBitsFromByteList(source->bytesList.rowRange(id, id + 1), source->markerSize);
      dictionary.ids.push_back(id);
      dictionary.codes.emplace_back(bits.begin<std::uint8_t>(), bits.end<std::uint8_t>());
    }
    return dictionary;
  }
  throw std::runtime_error("unknown tag family '" + name + "': it is neither a file nor one of " +
                           builtin_dictionary_names());
}

TagDictionary parse_dictionary(const std::string& text, const std::string& file) {
  int correction = -1;
  TagDictionary dictionary = parse_yaml(text, file, correction);
  if (dictionary.size == 0)
    dictionary.size = static_cast<int>(std::lround(std::sqrt(static_cast<double>(dictionary.codes.front().size()))));
  if (dictionary.size < 3 || dictionary.size > 10)
    refuse(file, "markersize is " + std::to_string(dictionary.size) + ", expected 3 to 10 cells a side");
  const size_t cells = static_cast<size_t>(dictionary.size) * static_cast<size_t>(dictionary.size);
  for (size_t i = 0; i < dictionary.codes.size(); ++i)
    if (dictionary.codes[i].size() != cells)
      refuse(file, "marker_" + std::to_string(dictionary.ids[i]) + " has " +
                       std::to_string(dictionary.codes[i].size()) + " cells, expected " + std::to_string(cells) +
                       " (markersize " + std::to_string(dictionary.size) + ")");
  check_codes(dictionary, file, correction);
  if (dictionary.name.empty()) dictionary.name = file.substr(file.find_last_of('/') + 1);
  return dictionary;
}

}  // namespace plumbline::detect
