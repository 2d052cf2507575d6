// Numbers and counts as a reader wants them: millimetres, a real minus sign, an en dash for what is not known.
#pragma once

#include <string>

namespace plumbline::report {

inline constexpr const char* unknown = "\u2013";

/// Fixed decimals with U+2212 as minus; "–" when not finite. Never "−0.00".
std::string fixed(double value, int decimals);
/// The same with a plus sign for positive values.
std::string signed_fixed(double value, int decimals);

std::string mm(double metres, int decimals = 2);         ///< "0.42", without the unit
std::string signed_mm(double metres, int decimals = 2);  ///< "+0.42"
std::string mm_unit(double metres, int decimals = 2);    ///< "0.42 mm", with a no-break space
/// "+0.42 ± 0.10" in mm; without the second part when it is not known.
std::string mm_with_u(double metres, double u, int decimals = 2);
/// A tolerance without needless zeros: "5 mm", "2.5 mm".
std::string tolerance(double metres);
/// "91.7 %"; "100 %" and "0 %" only when exact.
std::string percent(double fraction, int decimals = 1);
/// p-value or probability: "0.021", "< 0.001".
std::string probability(double p);
/// "1 anchor", "3 anchors".
std::string count(long n, const std::string& singular, const std::string& plural);

/// Coordinate of a drawing: at most two decimals, a plain minus.
std::string px(double value);

}  // namespace plumbline::report
