// Units of length as headers of clouds call them.
#pragma once

#include <limits>
#include <string_view>

namespace plumbline::cloud {

/// Feet of which nobody says whether they are international or those of US surveys.
inline bool says_feet(std::string_view unit) { return unit == "ft" || unit == "feet" || unit == "foot"; }

/// Metres in one unit, by its name in small letters; nan: none that is known.
inline double unit_named(std::string_view unit) {
  if (unit == "m" || unit == "metre" || unit == "metres" || unit == "meter" || unit == "meters") return 1;
  if (unit == "mm" || unit == "millimetres" || unit == "millimeters") return 0.001;
  if (unit == "cm") return 0.01;
  if (says_feet(unit)) return 0.3048;
  if (unit == "us_ft" || unit == "us-ft" || unit == "ftus") return 1200.0 / 3937;
  return std::numeric_limits<double>::quiet_NaN();
}

}  // namespace plumbline::cloud
