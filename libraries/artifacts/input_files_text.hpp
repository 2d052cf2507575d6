// What took part in a run, and what did not, in words: the same on the terminal and in every page.
#pragma once

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

/// "12 of 13 photographs, 840 readings, 19 files": photographs where there were any. `used_images`: how many of them
/// the result rests on; below 0: all.
inline std::string what_took_part(const InputFilesT& inputs, long used_images = -1) {
  std::string text;
  if (used_images >= 0 && used_images != inputs.images) text += std::to_string(used_images) + " of ";
  if (inputs.images > 0 || used_images >= 0) text += counted(inputs.images, "photograph", "photographs") + ", ";
  long read = 0;
  for (const auto& file : inputs.files) read += file->read;
  return text + counted(inputs.readings, "reading", "readings") + ", " + counted(read, "file", "files");
}

/// "Took part: 9 photographs, 412 readings, 15 files of the folder." and a line each for what of the readings was
/// excluded (SurveyNetwork.exclusions), what was set aside and what nobody named; lines end with a line end. Either may
/// be null.
inline std::string words_of_inputs(const InputFilesT* inputs, const InputFilesT* unread, long used_images = -1,
                                   const std::vector<std::string>& exclusions = {}) {
  std::string text;
  std::vector<std::string> set_aside, others;
  if (inputs) {
    text += "Took part: " + what_took_part(*inputs, used_images) + " of the folder.\n";
    for (const auto& file : inputs->files)
      if (!file->read) set_aside.push_back(file->path);
  }
  if (!exclusions.empty()) text += "Left out of the readings: " + few_names(exclusions) + ".\n";
  if (!set_aside.empty()) text += "Set aside by 'unused': " + few_names(set_aside) + ".\n";
  if (unread)
    for (const auto& file : unread->files) others.push_back(file->path);
  if (!others.empty()) text += "In the folder and not read: " + few_names(others) + ".\n";
  return text;
}

}  // namespace plumbline
