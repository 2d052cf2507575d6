#include "photo/detect/tag_dictionary.hpp"

#include <yaml-cpp/yaml.h>

#include <algorithm>
#include <array>
#include <bitset>
#include <cmath>
#include <map>
#include <opencv2/aruco/dictionary.hpp>
#include <regex>
#include <set>
#include <sstream>
#include <stdexcept>
#include <tuple>

#include "base/text/one_document.hpp"
#include "photo/detect/dictionary_sources.hpp"
#include "photo/detect/dictionary_tables.hpp"
#include "photo/detect/likeness.hpp"
#include "photo/detect/mip_36h12.hpp"

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

/// Cells of one code in one turn; 100 at most.
using Cells = std::bitset<100>;

Cells turned(const std::vector<std::uint8_t>& code, int size, int turn) {
  Cells result;
  for (int row = 0; row < size; ++row)
    for (int column = 0; column < size; ++column) {
      int r = row, c = column;
      for (int k = 0; k < turn; ++k) std::tie(r, c) = std::pair(c, size - 1 - r);
      result[r * size + c] = code[row * size + column] != 0;
    }
  return result;
}

struct Nearest {
  int distance = 0;
  size_t first = 0, second = 0;
};

/// The two codes that differ least in some turn; a code and itself in another turn count, too: it has no upright
/// position if they are alike.
Nearest nearest_codes(const TagDictionary& dictionary) {
  std::vector<Cells> upright;
  for (const auto& code : dictionary.codes) upright.push_back(turned(code, dictionary.size, 0));
  Nearest nearest{dictionary.size * dictionary.size + 1, 0, 0};
  for (size_t i = 0; i < upright.size(); ++i)
    for (int turn = 0; turn < 4; ++turn) {
      const Cells other = turned(dictionary.codes[i], dictionary.size, turn);
      for (size_t j = turn == 0 ? i + 1 : i; j < upright.size(); ++j) {
        const int d = static_cast<int>((other ^ upright[j]).count());
        if (d < nearest.distance) nearest = {d, i, j};
      }
    }
  return nearest;
}

[[noreturn]] void refuse(const std::string& file, const std::string& what) {
  throw std::runtime_error(
      file + ": " + what +
      ". A dictionary file holds nmarkers, markersize, maxCorrectionBits and marker_0, marker_1, "
      "... as strings of zeros and ones, as OpenCV writes it (YAML, JSON or XML); OpenCV's "
      "bytesList, the codeList of js-aruco2, the lists of the ArUco library and libapriltag's tag*.c are read, too");
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
  const Nearest nearest = nearest_codes(dictionary);
  const std::string first = "marker_" + std::to_string(dictionary.ids[nearest.first]);
  if (nearest.distance == 0)
    refuse(file, nearest.first == nearest.second
                     ? first + " looks the same after a turn, so its upright position cannot be told"
                     : first + " and marker_" + std::to_string(dictionary.ids[nearest.second]) +
                           " have the same cells up to a turn");
  const int safe = (nearest.distance - 1) / 2;
  dictionary.correctable_bits = stated_correction >= 0 ? std::min(stated_correction, safe) : safe;
}

/// Lines of codes, if it is nothing else.
TagDictionary parse_list(const std::string& text, const std::string& file) {
  TagDictionary dictionary = parse_dictionary_list(text, file);
  if (dictionary.codes.empty()) refuse(file, "no marker codes found");
  return dictionary;
}

/// The elements of OpenCV's XML, as lines of YAML.
std::string yaml_of_xml(const std::string& text) {
  static const std::regex element(R"x(<(\w+)>\s*"?([^<>"]*)"?\s*</\1>)x");
  std::string result;
  for (std::sregex_iterator it(text.begin(), text.end(), element), end; it != end; ++it)
    result += (*it)[1].str() + ": \"" + (*it)[2].str() + "\"\n";
  return result;
}

/// The map that holds the markers: the root, or the only one in it that does.
YAML::Node markers_in(const YAML::Node& root, const std::string& file) {
  const auto holds = [](const YAML::Node& map) {
    for (const auto& entry : map)
      if (lower(entry.first.as<std::string>("")).rfind("marker_", 0) == 0) return true;
    return false;
  };
  if (holds(root)) return root;
  YAML::Node found = root;
  std::string names;
  int count = 0;
  for (const auto& entry : root)
    if (entry.second.IsMap() && holds(entry.second)) {
      found.reset(entry.second);
      names += (count++ > 0 ? ", " : "") + entry.first.as<std::string>("");
    }
  if (count > 1) refuse(file, "holds several dictionaries (" + names + "); put each in a file of its own");
  return found;
}

TagDictionary parse_yaml(const std::string& text, const std::string& file, int& correction) {
  std::string body = text.find("<opencv_storage>") != std::string::npos ? yaml_of_xml(text) : text;
  if (body.rfind("\xef\xbb\xbf", 0) == 0) body.erase(0, 3);
  if (body.rfind("%YAML", 0) == 0) body.erase(0, body.find('\n') == std::string::npos ? body.size() : body.find('\n'));
  if (body.find("codeList") != std::string::npos &&
      body.find('{') < body.rfind('}'))  // assigned to a name in JavaScript
    body = body.substr(body.find('{'), body.rfind('}') + 1 - body.find('{'));
  TagDictionary dictionary;
  YAML::Node root;
  try {
    root = text::load_one_document(body);
  } catch (const YAML::Exception& error) {
    refuse(file, "neither YAML nor JSON (line " + std::to_string(error.mark.line + 1) + ": " + error.msg + ")");
  }
  if (!root.IsMap() && !root.IsSequence()) return parse_list(text, file);
  if (auto table = parse_dictionary_table(root, file)) return *table;
  root = markers_in(root, file);
  int stated_markers = -1;
  std::map<int, std::vector<std::uint8_t>> codes;
  for (const auto& entry : root) {
    const std::string key = lower(entry.first.as<std::string>(""));
    if (key == "nmarkers") stated_markers = entry.second.as<int>(-1);
    if (key == "markersize") dictionary.size = entry.second.as<int>(0);
    if (key == "markerborderbits") dictionary.border = entry.second.as<int>(0);
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
  if (codes.empty()) return parse_list(text, file);
  for (auto& [id, code] : codes) {
    dictionary.ids.push_back(id);
    dictionary.codes.push_back(std::move(code));
  }
  if (stated_markers >= 0 && stated_markers != static_cast<int>(dictionary.codes.size()))
    refuse(file, "nmarkers is " + std::to_string(stated_markers) + ", but there are " +
                     std::to_string(dictionary.codes.size()) + " markers");
  return dictionary;
}

TagDictionary from_opencv(const cv::aruco::Dictionary& source, const std::string& name) {
  TagDictionary dictionary;
  dictionary.name = name;
  dictionary.size = source.markerSize;
  dictionary.correctable_bits = source.maxCorrectionBits;
  for (int id = 0; id < source.bytesList.rows; ++id) {
    const cv::Mat bits =
        cv::aruco::Dictionary::getBitsFromByteList(source.bytesList.rowRange(id, id + 1), source.markerSize);
    dictionary.ids.push_back(id);
    dictionary.codes.emplace_back(bits.begin<std::uint8_t>(), bits.end<std::uint8_t>());
  }
  return dictionary;
}

/// The default of the ArUco library since its version 3.
TagDictionary mip_36h12_dictionary() {
  TagDictionary dictionary;
  dictionary.name = "ARUCO_MIP_36h12", dictionary.size = 6, dictionary.correctable_bits = 5;
  for (const std::uint64_t value : mip_36h12) {
    dictionary.ids.push_back(static_cast<int>(dictionary.codes.size()));
    std::vector<std::uint8_t>& code = dictionary.codes.emplace_back();
    for (int bit = 35; bit >= 0; --bit) code.push_back(static_cast<std::uint8_t>(value >> bit & 1));
  }
  return dictionary;
}

/// Find-GCP's own: what OpenCV's generator makes of 32 markers of 3 x 3 cells with its first seed.
TagDictionary find_gcp_dictionary() { return from_opencv(*cv::aruco::generateCustomDictionary(32, 3), "DICT_3X3_32"); }

}  // namespace

std::string builtin_dictionary_names() {
  std::string names;
  for (const Builtin& builtin : builtins) names += (names.empty() ? "" : ", ") + std::string(builtin.name);
  return names + ", ARUCO_MIP_36h12, DICT_3X3_32 (of Find-GCP)";
}

int take_border(std::string& name) {
  if (name.size() < 3 || lower(name.substr(name.size() - 2)) != "b2") return 1;
  name.resize(name.size() - 2);
  return 2;
}

TagDictionary builtin_dictionary(const std::string& name) {
  if (std::string base = name; take_border(base) == 2) {
    TagDictionary dictionary = builtin_dictionary(base);
    dictionary.name += "b2", dictionary.border = 2;
    return dictionary;
  }
  for (const Builtin& builtin : builtins) {
    if (canonical(name) != canonical(builtin.name)) continue;
    TagDictionary dictionary = from_opencv(*cv::aruco::getPredefinedDictionary(builtin.number), builtin.name);
    dictionary.turned = std::string(builtin.name).rfind("tag", 0) == 0;
    return dictionary;
  }
  if (canonical(name) == "3x3_32") return find_gcp_dictionary();
  if (canonical(name).ends_with("mip_36h12")) return mip_36h12_dictionary();
  throw std::runtime_error("unknown tag family '" + name + "': it is neither a file nor one of " +
                           builtin_dictionary_names());
}

TagDictionary parse_dictionary(const std::string& text, const std::string& file) {
  if (text.find('\0') != std::string::npos || text.rfind("\x93NUMPY", 0) == 0)
    refuse(file, "is a binary file (NumPy, MATLAB, an image or a drawing), not text");
  int correction = -1;
  TagDictionary dictionary =
      is_dictionary_source(text) ? parse_dictionary_source(text, file) : parse_yaml(text, file, correction);
  if (dictionary.size == 0)
    dictionary.size = static_cast<int>(std::lround(std::sqrt(static_cast<double>(dictionary.codes.front().size()))));
  if (dictionary.size < 3 || dictionary.size > 10)
    refuse(file, "markersize is " + std::to_string(dictionary.size) + ", expected 3 to 10 cells a side");
  std::set<int> ids;
  for (const int id : dictionary.ids)
    if (!ids.insert(id).second) refuse(file, "the id " + std::to_string(id) + " occurs twice");
  const size_t cells = static_cast<size_t>(dictionary.size) * dictionary.size;
  for (size_t i = 0; i < dictionary.codes.size(); ++i)
    if (dictionary.codes[i].size() != cells)
      refuse(file, "marker_" + std::to_string(dictionary.ids[i]) + " has " +
                       std::to_string(dictionary.codes[i].size()) + " cells, expected " + std::to_string(cells) +
                       " (markersize " + std::to_string(dictionary.size) + ")");
  if (dictionary.border < 1 || dictionary.border > 2)
    refuse(file, "markerBorderBits is " + std::to_string(dictionary.border) + ", expected a border of 1 or 2 cells");
  check_codes(dictionary, file, correction);
  if (dictionary.name.empty()) dictionary.name = file.substr(file.find_last_of('/') + 1);
  return dictionary;
}

int smallest_distance(const TagDictionary& dictionary) { return nearest_codes(dictionary).distance; }

std::string weakness_of(const TagDictionary& dictionary) {
  const int n = dictionary.size;
  std::string words;
  constexpr double kCorrected = 0.6;  // share of the correctable bits that detect.aruco corrects
  const double chance = chance_of_code(dictionary.codes.size(), static_cast<size_t>(n * n),
                                       static_cast<int>(kCorrected * dictionary.correctable_bits));
  if (chance >= kWeakChance) {
    std::ostringstream text;
    text.precision(2);
    text
        << dictionary.codes.size() << " codes of " << n << " x " << n
        << " cells, whose smallest distance in any turn is " << smallest_distance(dictionary)
        << ": a dark square of the scene is read as one of them with a chance of " << 100 * chance
        << " %, and a photograph holds about 10 such squares, one of 24 megapixels 300. What does not look like the "
           "drawing of its tag is left out (border, quiet zone, cells), a square of another dictionary that looks like "
           "one is not. A dictionary of more cells or fewer codes is safer";
    words = text.str();
  }
  bool bordered = n > 4;
  for (const auto& code : dictionary.codes)
    for (int k = 0; k < n && bordered; ++k)
      for (const int at : {k, (n - 1) * n + k, k * n, k * n + n - 1}) bordered &= code[at] == 0;
  if (bordered)
    words += (words.empty() ? "" : ". ") +
             std::string(
                 "the outer cells of all markers are black: if they are the border, leave them out of the file "
                 "(a border of one black cell is understood, markerBorderBits: 2 makes it two)");
  return words;
}

}  // namespace plumbline::detect
