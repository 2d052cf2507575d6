// Dictionaries as tables in YAML or JSON that are not OpenCV's marker_0, marker_1, ...
#pragma once

#include <yaml-cpp/node/node.h>

#include <optional>
#include <string>

#include "detect/tag_dictionary.hpp"

namespace plumbline::detect {

/// - `bytesList`: OpenCV's matrix of bytes, four turns of each code, as FileStorage writes it; `markerSize` where there
///   is one;
/// - `codeList`: one number a code, in hexadecimal, the highest bit first, of `nBits` (js-aruco2);
/// - `markers` or `codes`: a list of codes, each a string of zeros and ones or rows of cells.
/// Nothing for any other map. Throws std::runtime_error that names `file`. Codes are not compared with each other.
std::optional<TagDictionary> parse_dictionary_table(const YAML::Node& root, const std::string& file);

}  // namespace plumbline::detect
