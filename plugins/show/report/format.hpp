// Numbers and counts as a reader wants them: in the units and with the decimal sign that are spoken (language.hpp), a
// real minus sign, an en dash for what is not known. Inches have two digits more than millimetres: 0.01 in are 0.25 mm.
#pragma once

#include <string>

namespace plumbline::report {

inline constexpr const char* unknown = "\u2013";

/// Fixed decimals with U+2212 as minus; "–" when not finite. Never "−0.00".
std::string fixed(double value, int decimals);
/// The same with a plus sign for positive values.
std::string signed_fixed(double value, int decimals);

/// Lengths: what is written "mm" behind them is named by the units spoken.
std::string mm(double metres, int decimals = 2);         ///< "0.42", without the unit
std::string signed_mm(double metres, int decimals = 2);  ///< "+0.42"
std::string mm_unit(double metres, int decimals = 2);    ///< "0.42 mm", with a no-break space
/// " (3/32)" where inches are spoken, to the nearest 1/32 as rules and shims have it; else empty.
std::string in_fractions(double metres);
/// What is to be set: "2.5 mm", "0.098 in (3/32)"; without a sign.
std::string to_set(double metres);
/// The length in the units spoken, for scales of drawings.
double in_units(double metres);
/// Decimals with which rounding keeps a value on its side of the limit: `decimals`, and three more at most.
int decimals_beside(double value, double limit, int decimals);
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
