// Dictionaries as tables in YAML or JSON that are not OpenCV's marker_0, marker_1, ...
#pragma once

#include <yaml-cpp/node/node.h>

#include <optional>
#include <string>

#include "photo/detect/tag_dictionary.hpp"

namespace plumbline::detect {

/// - `bytesList`: OpenCV's matrix of bytes, four turns of each code, as FileStorage writes it; `markerSize` where there
///   is one;
/// - `codeList`: one number a code, in hexadecimal, the highest bit first, of `nBits` (js-aruco2);
/// - `markers` or `codes`, or no key: a list of codes, each a string of zeros and ones, rows of cells, or a map of one
/// of
///   these and its `id`;
/// - a map of them whose keys are the ids.
/// Nothing for any other map. Throws std::runtime_error that names `file`. Codes are not compared with each other.
std::optional<TagDictionary> parse_dictionary_table(const YAML::Node& root, const std::string& file);

/// One code a line, as the ArUco library (version 3) has it below name and number of bits, or its id and the code.
/// Without codes if there are none; throws std::runtime_error that names `file` where a line holds something else
/// beside a code.
TagDictionary parse_dictionary_list(const std::string& text, const std::string& file);

}  // namespace plumbline::detect
