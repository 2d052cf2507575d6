// Dictionaries as source text: the families of libapriltag and the arrays of OpenCV.
#pragma once

#include <string>

#include "detect/tag_dictionary.hpp"

namespace plumbline::detect {

/// Whether the text is C, C++ or Java with codes in it.
bool is_dictionary_source(const std::string& text);

/// - libapriltag's family of its version 3 (codes in hexadecimal, the cell of every bit as bit_x and bit_y) and of its
///   earlier ones (`d` or `TagCodes(bits, ...)`: row by row from the top left, the highest bit first);
/// - an array `unsigned char NAME[][4][bytes]` of OpenCV: four turns of each code, the highest bit first.
/// Families with cells outside of a square of one black border cell are refused: detect.aruco does not find them.
/// Throws std::runtime_error that names `file`. Codes are not compared with each other.
TagDictionary parse_dictionary_source(const std::string& text, const std::string& file);

}  // namespace plumbline::detect
