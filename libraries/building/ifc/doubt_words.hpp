// What speaks against a measurement, in words, the same for the page, IFC, BCF, JUnit and the loop.
#pragma once

#include <fmt/core.h>

#include <memory>
#include <string>
#include <vector>

#include "artifacts/deviation.hpp"

namespace plumbline::ifc {

/// "the survey", "the image block", "where the whole stands".
inline const char* name_of(MeasurementPart part) {
  if (part == MeasurementPart::datum) return "where the whole stands";
  return part == MeasurementPart::survey ? "the survey" : "the image block";
}

/// "the survey: station 3 contradicts itself"; of a misfit also how much larger the standard deviations are for it, and
/// what to run again with, as a sentence.
inline std::string in_words(const MeasurementDoubtT& doubt) {
  std::string text = std::string(name_of(doubt.part)) + ": " + doubt.reason;
  if (doubt.grade == DoubtGrade::doubt) {
    if (!doubt.mend.empty()) text += "; to decide it, run again with \"" + doubt.mend + "\" (" + doubt.mend_note + ")";
    if (doubt.mend.empty() && !doubt.mend_note.empty()) text += "; to decide it, " + doubt.mend_note;
    return text;
  }
  // Else the adjustment has made those larger that feel it, and says so itself.
  text +=
      doubt.factor > 1 ? fmt::format("; all standard deviations are {:.3g} times as large for it.", doubt.factor) : ".";
  if (doubt.mend.empty()) return text;
  text += " To mend it, run again with \"" + doubt.mend + "\"";
  return text + (doubt.mend_note.empty() ? "." : " (" + doubt.mend_note + ").");
}

inline std::vector<std::string> in_words(const std::vector<std::unique_ptr<MeasurementDoubtT>>& doubts) {
  std::vector<std::string> texts;
  for (const auto& doubt : doubts) texts.push_back(in_words(*doubt));
  return texts;
}

}  // namespace plumbline::ifc
