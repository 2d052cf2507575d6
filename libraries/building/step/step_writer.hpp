// Text of ISO 10303-21 arguments, for programs that write IFC. Every function returns the argument as it stands in the
// file; `instance` joins them to a line. Numbers are written with the shortest digits that read back to the same bits,
// so a file is the same on every machine.
//
//   out += step::instance(7, "IFCCARTESIANPOINT", {step::list({step::real(0), step::real(1.5)})});   //
//   #7=IFCCARTESIANPOINT((0.,1.5));
#pragma once

#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

namespace plumbline::step {

/// A real with the point that Part 21 demands: 5 → "5.", 1e-7 → "1.E-7". Throws std::invalid_argument for nan and
/// infinity: the format has neither.
std::string real(double value);
/// A real rounded to `decimals` digits after the point, trailing zeros dropped: for measured values, where 17 digits
/// are noise.
std::string real_rounded(double value, int decimals);
std::string integer(std::int64_t value);
/// A quoted string from UTF-8: quotes and solidi doubled, everything outside printable ASCII as \X2\ or \X4\.
/// Bytes that are not UTF-8 are taken as ISO 8859-1.
std::string text(std::string_view utf8);
std::string enumeration(std::string_view name);                         ///< PASS → ".PASS."
std::string boolean(bool value);                                        ///< ".T." or ".F."
std::string reference(std::uint64_t id);                                ///< 7 → "#7"
std::string list(const std::vector<std::string>& items);                ///< "(a,b)"
std::string typed(std::string_view keyword, const std::string& value);  ///< IFCLABEL, "'x'" → "IFCLABEL('x')"
inline constexpr const char* null = "$";                                ///< an optional attribute that is not given
inline constexpr const char* derived = "*";                             ///< an attribute that a subtype derives

/// One line of the DATA section without a line end: "#7=KEYWORD(a,b);".
std::string instance(std::uint64_t id, std::string_view keyword, const std::vector<std::string>& arguments);

}  // namespace plumbline::step
