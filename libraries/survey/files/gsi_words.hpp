// GSI's lines cut into blocks and words, without meaning yet.
#pragma once

#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "base/text/text.hpp"

namespace plumbline::survey {

struct GsiWord {
  int index = 0;           ///< word index, e.g. 21
  std::string_view whole;  ///< the word as written
  std::string_view data;   ///< after the sign
  char unit = '.';         ///< last character of the information
  bool negative = false;   ///< sign
  std::size_t digits = 0;  ///< data characters the word should have: 8 or 16
  int column = 0;          ///< of its first character, from 1
  bool complete() const;   ///< all of `digits` characters are there
  /// Nobody measured or computed it: input mode 1 (keyed in), or none where the format leaves it open.
  bool keyed_in() const { return whole.size() > 4 && (whole[4] == '1' || whole[4] == '.'); }
  bool is_blank() const;          ///< nothing but dashes and zeros: the instrument had no value ("00000000000-----")
  std::string_view text() const;  ///< data without leading zeros and blanks; "0" if there is nothing but zeros
};

struct GsiBlock {
  int line = 0;
  std::vector<GsiWord> words;
  const GsiWord* find(int index) const;  ///< the first word of that index, or nullptr
};

/// Text of a line that is no word.
struct GsiNoise {
  int line = 0, column = 0;
  std::string_view text;
};

/// Blocks of one line, in order: usually one, more where line ends were lost. The views point into `line`.
std::vector<GsiBlock> gsi_blocks(const text::Line& line, std::vector<GsiNoise>& noise);

/// All data characters as one number; nullopt unless the word is complete and has digits only.
std::optional<long long> gsi_digits(const GsiWord& word);

/// A value, or what the word should have been.
struct GsiValue {
  double value = 0;
  const char* expected = nullptr;  ///< nullptr: value holds
};

/// [rad], with sign, by the word's unit digit: 2 gon and 3 degrees to 1e-5, 4 DDDMMSSs, 5 mil to 1e-4.
GsiValue gsi_angle(const GsiWord& word);
/// [m], with sign, by the word's unit digit: 0, 6, 8 are 1, 0.1 and 0.01 mm; 1, 7 thousandths and ten-thousandths of
/// `foot` metres.
GsiValue gsi_length(const GsiWord& word, double foot);

/// What the instrument had done to a distance before it wrote it, in words: its unit, and the ppm and prism constant
/// of the block's words 51, 58 and 59.
std::vector<std::string> gsi_distance_corrections(const GsiBlock& block, const GsiWord& distance, bool us_survey_foot);

}  // namespace plumbline::survey
