// Dictionaries as source text: the families of libapriltag and the arrays of OpenCV.
#pragma once

#include <string>

#include "photo/detect/tag_dictionary.hpp"

namespace plumbline::detect {

/// Whether the text is C, C++ or Java with codes in it.
bool is_dictionary_source(const std::string& text);

/// - libapriltag's family of its version 3 (codes in hexadecimal, the cell of every bit as bit_x and bit_y) and of its
///   earlier ones (`d` or `TagCodes(bits, ...)`: row by row from the top left, the highest bit first);
/// - an array `unsigned char NAME[][4][bytes]` of OpenCV: four turns of each code, the highest bit first.
/// Families with cells outside of a square of one black border cell are refused: detect.aruco does not find them.
/// Throws std::runtime_error that names `file`. Codes are not compared with each other.
TagDictionary parse_dictionary_source(const std::string& text, const std::string& file);

/// The cells of a code of OpenCV's bytes from `first` on, row by row from the top left; 1 is white.
std::vector<std::uint8_t> code_of_bytes(const std::vector<int>& bytes, size_t first, int size);

/// Cells a side of markers whose four turns have `per_turn` bytes each; 0 if the bytes are no turns of one another.
int size_of_bytes(const std::vector<int>& bytes, size_t per_turn);

}  // namespace plumbline::detect
