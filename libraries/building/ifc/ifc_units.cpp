#include "building/ifc/ifc_units.hpp"

#include <array>
#include <cmath>
#include <utility>

namespace plumbline::ifc {
namespace {

constexpr std::array<std::pair<std::string_view, int>, 16> kPrefixes{{{"EXA", 18},
                                                                      {"PETA", 15},
                                                                      {"TERA", 12},
                                                                      {"GIGA", 9},
                                                                      {"MEGA", 6},
                                                                      {"KILO", 3},
                                                                      {"HECTO", 2},
                                                                      {"DECA", 1},
                                                                      {"DECI", -1},
                                                                      {"CENTI", -2},
                                                                      {"MILLI", -3},
                                                                      {"MICRO", -6},
                                                                      {"NANO", -9},
                                                                      {"PICO", -12},
                                                                      {"FEMTO", -15},
                                                                      {"ATTO", -18}}};

/// The power of ten from one division or literal, so that MILLI is the double nearest to 0.001.
double prefix_factor(const Entity& unit) {
  const std::string prefix = unit.text("Prefix");
  if (prefix.empty()) return 1;
  for (const auto& [name, exponent] : kPrefixes)
    if (name == prefix) return exponent < 0 ? 1 / std::pow(10, -exponent) : std::pow(10, exponent);
  unit.fail("Prefix", "an SI prefix");
}

struct InSi {
  double factor = 1;
  std::string name;  ///< METRE, SQUARE_METRE, RADIAN, …
};

InSi in_si(const Model& model, std::uint64_t id, std::uint64_t referrer, int depth) {
  const Entity unit = model.entity(id, referrer);
  if (unit.keyword() == "IFCSIUNIT") return {prefix_factor(unit), unit.text("Name")};
  // A chain such as foot → inch → millimetre is legal; an endless one is not.
  if (depth > 8) unit.fail("Name", "a unit that leads to an SI unit");
  const Entity measure = model.entity(unit.reference("ConversionFactor"), id);
  InSi result = in_si(model, measure.reference("UnitComponent"), measure.id(), depth + 1);
  result.factor *= measure.number("ValueComponent");
  if (!(result.factor > 0) || !std::isfinite(result.factor)) measure.fail("ValueComponent", "a positive factor");
  return result;
}

}  // namespace

double unit_factor(const Model& model, std::uint64_t unit) {
  const InSi found = in_si(model, unit, 0, 0);
  if (found.name != "METRE" && found.name != "RADIAN")
    throw step::Error(model.file().where(model.file().find(unit)->begin) + ": #" + std::to_string(unit) +
                      " is a unit of " + found.name + ", expected METRE or RADIAN here");
  return found.factor;
}

Units read_units(const Model& model, const Entity& project, std::vector<std::string>& warnings) {
  Units units;
  bool length_found = false;
  std::vector<std::uint64_t> no_length;  // called one by exporters that mean something else
  if (const auto assignment = project.optional_reference("UnitsInContext")) {
    for (const std::uint64_t id : model.entity(*assignment, project.id()).references("Units")) {
      const std::string_view keyword = model.keyword(id);
      if (keyword != "IFCSIUNIT" && !keyword.starts_with("IFCCONVERSIONBASEDUNIT")) continue;
      const Entity unit = model.entity(id, *assignment);
      const std::string type = unit.text("UnitType");
      if (type == "PLANEANGLEUNIT") units.plane_angle = unit_factor(model, id);
      if (type != "LENGTHUNIT") continue;
      const auto [factor, name] = in_si(model, id, *assignment, 0);
      if (name != "METRE") {
        no_length.push_back(id);
        continue;
      }
      if (length_found && factor != units.length)
        unit.fail("UnitType", "one length unit, as an IfcUnitAssignment has (another stands before it)");
      units.length = factor;
      units.length_name = (keyword == "IFCSIUNIT" ? unit.text("Prefix") : "") + unit.text("Name");
      length_found = true;
    }
  }
  for (const std::uint64_t id : no_length) {
    if (!length_found) unit_factor(model, id);  // says what is wrong with it
    warnings.push_back("#" + std::to_string(id) + " calls itself a unit of length and is " +
                       in_si(model, id, 0, 0).name + "; it is not used");
  }
  if (!length_found) warnings.emplace_back("the project assigns no length unit; its lengths are taken as metres");
  return units;
}

}  // namespace plumbline::ifc
