// Leica GSI-8 and GSI-16: lines of fixed-width words, the oldest and most common raw format of total stations.
// Layout of a word: two or three digits of word index, four of information (automatic index, input mode, unit), a sign,
// 8 or 16 characters of data, a blank. The reader keeps both faces as measured; sessions without a station name, words
// cut in half and text where digits belong cost the word concerned, not the file.
#pragma once

#include <string>
#include <string_view>
#include <vector>

#include "survey/model/survey_observations.hpp"

namespace plumbline::survey {

/// A code block that begins a set-up: word 41 holds `code`, `station_word` the station's name, `height_word` the
/// instrument height in units of `height_unit` metres.
struct GsiStationCode {
  std::string code = "21";
  int station_word = 42;
  int height_word = 43;
  double height_unit = 0.001;
};

/// What word 22 counts from; a GSI file does not record it.
enum class GsiVerticalReference { zenith, horizon, percent };

struct GsiOptions {
  std::vector<GsiStationCode> station_codes = {GsiStationCode{}};
  GsiVerticalReference vertical_reference = GsiVerticalReference::zenith;
  bool us_survey_foot = false;  ///< unit digits 1 and 7 mean US survey feet instead of international ones
};

/// Reads GSI. A set-up begins (a) at a block with station coordinates (84, 85, 86; name in 11, height in 88), (b) at a
/// code block of `options.station_codes`, (c) where word 16 names another station; observations before any of these go
/// to a free station with a made-up name. Word 31 holds ppm and prism constant already, as set in the instrument; what
/// words 51, 58, 59 say of them is kept in `corrections`. Target and instrument heights hold until changed. Files of
/// any line end (CR only, doubled too) and without line ends between blocks.
/// Throws SurveyReadError when the file has no usable block.
SurveyObservations read_gsi(std::string_view bytes, const std::string& file, const GsiOptions& options = {});

enum class GsiStationStart {
  code_block,          ///< 41 = 21, 42 = name, 43 = instrument height [mm]
  station_coordinates  ///< 11 = name, 84, 85, 86 and 88; stations without coordinates get a code block
};

struct GsiWriteOptions {
  GsiStationStart station_start = GsiStationStart::code_block;
  int distance_unit = 8;  ///< unit digit of lengths: 0 = 1 mm, 6 = 0.1 mm, 8 = 0.01 mm
};

/// GSI-16 text (CR LF) of all pointings of all set-ups, angles in gon to 1e-5. Coordinates of points are written as
/// blocks with 81, 82, 83 at the beginning. Characters outside ASCII become Windows-1252.
/// Throws std::runtime_error for what GSI cannot hold: names of more than 16 characters, two names that differ in
/// leading zeros only, observations without a set-up, kinds other than directions, zenith angles, distances and height
/// differences, more than one value of a kind in a pointing.
std::string write_gsi(const SurveyObservations& survey, const GsiWriteOptions& options = {});

}  // namespace plumbline::survey
