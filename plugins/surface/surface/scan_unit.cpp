#include "scan_unit.hpp"

#include <algorithm>
#include <cmath>
#include <iterator>

namespace plumbline::surface {

std::string name_of_unit(double metres) {
  for (const Unit& unit : kUnits)
    if (std::abs(unit.metres / metres - 1) < 1e-9) return unit.name;
  return std::to_string(metres) + " m";
}

UnitOfFile unit_of(const cloud::CloudSummary& file, const std::string& wanted, const Context& context) {
  if (wanted == "from_file") {
    if (std::isfinite(file.unit)) return {file.unit, true};
    if (std::isfinite(file.unit_of_heights) && std::abs(file.unit_of_heights - 1) > 1e-9)
      throw std::runtime_error("the file says that its heights are in " + name_of_unit(file.unit_of_heights) +
                               ", and of its plan" +
                               (file.without_unit_of.empty() ? std::string() : " (" + file.without_unit_of + ")") +
                               " no unit that is known here; if both are in that unit, set 'unit' to it, else bring "
                               "both to metres");
    context.warn("the file does not say its unit" +
                 (file.without_unit_of.empty() ? "" : " (of " + file.without_unit_of + " the unit is not known here)") +
                 "; its coordinates are taken for metres ('unit' says another)");
    return {1, false};
  }
  const double asked =
      std::find_if(std::begin(kUnits), std::end(kUnits), [&](const Unit& u) { return wanted == u.name; })->metres;
  const double alike = file.either_foot ? 1e-5 : 1e-9;
  if (std::isfinite(file.unit) && std::abs(file.unit / asked - 1) > alike)
    throw std::runtime_error("'unit' is " + wanted + ", but the file says that its coordinates are in " +
                             name_of_unit(file.unit) + "; leave 'unit' out, or mend the file");
  if (std::isfinite(file.unit_of_heights) && std::abs(file.unit_of_heights / asked - 1) > 1e-5)
    throw std::runtime_error("'unit' is " + wanted + ", but the file says that its heights are in " +
                             name_of_unit(file.unit_of_heights) + "; bring plan and heights to one unit");
  return {asked, true};
}

}  // namespace plumbline::surface
