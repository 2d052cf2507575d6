// Dictionaries of square markers: the codes of their cells, from OpenCV's built-in sets or from a file.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

namespace plumbline::detect {

/// Codes of a family of square markers with a black border around size × size cells.
struct TagDictionary {
  std::string name;
  int size = 0;                                  ///< data cells a side
  int correctable_bits = 0;                      ///< at most this many wrong cells are corrected
  std::vector<int> ids;                          ///< of `codes`
  std::vector<std::vector<std::uint8_t>> codes;  ///< size² cells each, row by row from the top left, 1 is white
  /// Cells are drawn as libapriltag does it: OpenCV's copy of these families is turned by half a turn.
  bool turned = false;
  int border = 1;  ///< black cells around those of the code: one, or two as on Kalibr's grids
};

/// Takes the ending off "tag36h11b2": the border's cells, 1 without an ending.
int take_border(std::string& name);

/// "DICT_4X4_50" … "DICT_7X7_1000", "DICT_ARUCO_ORIGINAL" and the AprilTag families as
/// "tag36h11" or "DICT_APRILTAG_36h11"; case does not matter and "DICT_" may be left out; "b2" at the end: with a
/// border of two cells. Throws std::runtime_error that lists what is known.
TagDictionary builtin_dictionary(const std::string& name);

/// Names that builtin_dictionary() takes, separated by commas.
std::string builtin_dictionary_names();

/// A custom dictionary: as OpenCV writes it (YAML, JSON or XML: nmarkers, markersize, maxCorrectionBits, marker_0 …,
/// each a string of zeros and ones, 1 is white; also under a name of its own), as the ArUco library does (name, nbits,
/// one string of bits a line), or as source text (dictionary_sources.hpp).
/// Throws std::runtime_error that names `file`, what was found and what was expected.
TagDictionary parse_dictionary(const std::string& text, const std::string& file);

/// Smallest number of cells that two codes differ in, over all pairs and turns; also a code and itself in another turn.
int smallest_distance(const TagDictionary& dictionary);

/// What is doubtful about a dictionary, in words; empty where nothing is.
std::string weakness_of(const TagDictionary& dictionary);

}  // namespace plumbline::detect
