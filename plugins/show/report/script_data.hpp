// Data for the scripts of a page, as JSON that may stand inside a script element.
#pragma once

#include <Eigen/Core>
#include <string>
#include <vector>

namespace plumbline::report {

/// Plain decimals; null for what is not known or has more than fifty digits.
std::string script_number(double value, int decimals);
/// As many digits as give the same number back; 1e300 for infinity, null for what is not known.
std::string script_exact(double value);
/// A string that cannot end the script element: bytes beyond plain ASCII as Latin-1 escapes, which the script decodes
/// as UTF-8.
std::string script_text(const std::string& text);
/// What page.js and view.js say in the language and units spoken: their texts, the decimal sign, the unit of lengths.
std::string script_words();
/// The texts of theirs, in English.
const std::vector<std::string>& script_texts();
/// [x,y,z]
std::string script_vector(const Eigen::Vector3d& v, int decimals);

}  // namespace plumbline::report
