// What took part in a run, and what did not, in words: the same on the terminal and in every page.
#pragma once

#include <algorithm>
#include <string>
#include <vector>

#include "artifacts/input_files.hpp"
#include "artifacts/survey_observations.hpp"

namespace plumbline {

/// "9 photographs", "1 photograph".
inline std::string counted(long n, const std::string& one, const std::string& many) {
  return std::to_string(n) + " " + (n == 1 ? one : many);
}

/// Measured values of a survey: what is known of coordinates is none.
inline long readings_of(const SurveyObservationsT& survey) {
  std::size_t n = survey.observations.size() + survey.local_coordinates.size();
  for (const auto& group : survey.vectors) n += group->from.size();
  return static_cast<long>(n);
}

/// The names of up to `most` files, and how many more there are.
inline std::string few_names(const std::vector<std::string>& names, std::size_t most = 6) {
  std::string text;
  for (std::size_t i = 0; i < names.size() && i < most; ++i) text += (i ? ", " : "") + names[i];
  return names.size() > most ? text + " and " + std::to_string(names.size() - most) + " more" : text;
}

/// How much of what was read the result rests on.
struct UsedInputs {
  long images = -1;                     ///< below 0: all
  long readings_left_out = 0;           ///< SurveyNetwork.readings_left_out
  std::vector<std::string> exclusions;  ///< SurveyNetwork.exclusions
};

/// Of an optional input of a node, an adjusted survey network; `images`: how many photographs the result rests on.
UsedInputs used_of(const auto& network, long images = -1) {
  UsedInputs used{images, 0, {}};
  if (!network) return used;
  used.readings_left_out = network->readings_left_out();
  if (network->exclusions())
    for (const auto* text : *network->exclusions()) used.exclusions.push_back(text->str());
  return used;
}

/// Photographs of an optional input of a node, an adjusted block; below 0 where there is none.
long used_images(const auto& block) {
  return block && block->images() ? static_cast<long>(block->images()->size()) : -1;
}

/// "805 of 840 readings"; "840 readings" where none was left out.
inline std::string counted_readings(long all, long left_out) {
  const std::string of = counted(all, "reading", "readings");
  return left_out > 0 ? std::to_string(std::max(0L, all - left_out)) + " of " + of : of;
}

/// "12 of 13 photographs, 805 of 840 readings, 19 files": photographs where there were any.
inline std::string what_took_part(const InputFilesT& inputs, const UsedInputs& used = {}) {
  std::string text;
  if (used.images >= 0 && used.images != inputs.images) text += std::to_string(used.images) + " of ";
  if (inputs.images > 0 || used.images >= 0) text += counted(inputs.images, "photograph", "photographs") + ", ";
  long read = 0;
  for (const auto& file : inputs.files) read += file->read;
  return text + counted_readings(inputs.readings, used.readings_left_out) + ", " + counted(read, "file", "files");
}

/// "Took part: 9 photographs, 412 readings, 15 files of the folder." and a line each for what of the readings was
/// excluded, what was set aside and what nobody named; lines end with a line end. Either may be null.
inline std::string words_of_inputs(const InputFilesT* inputs, const InputFilesT* unread, const UsedInputs& used = {}) {
  std::string text;
  std::vector<std::string> set_aside, others;
  if (inputs) {
    text += "Took part: " + what_took_part(*inputs, used) + " of the folder.\n";
    for (const auto& file : inputs->files)
      if (!file->read) set_aside.push_back(file->path);
  }
  if (!used.exclusions.empty()) text += "Left out of the readings: " + few_names(used.exclusions) + ".\n";
  if (!set_aside.empty()) text += "Set aside by 'unused': " + few_names(set_aside) + ".\n";
  if (unread)
    for (const auto& file : unread->files) others.push_back(file->path);
  if (!others.empty()) text += "In the folder and not read: " + few_names(others) + ".\n";
  return text;
}

}  // namespace plumbline
