// Whole texts in what is spoken: lines, the comments of a YAML file, a finished page.
#pragma once

#include <string>

namespace plumbline::report {

/// Every line of a text; spaces that a line begins with stay.
std::string spoken_lines(const std::string& text);

/// A YAML file whose comments ("# ..." at the beginning of a line, or behind "   # ") are spoken; all else stays.
std::string spoken_comments(const std::string& yaml);

/// A page of a program of ours (well-formed, entities of xml_escaped()): texts between tags and in aria-label are
/// spoken, numbers alone get the decimal sign. What an element with translate="no" holds (a name, which may be a word
/// of the program, too), style and script stay. Lengths stay in mm: cells of tables do not say their unit.
std::string spoken_page(const std::string& html);

}  // namespace plumbline::report
