// The unit of a cloud's coordinates: what its file says, or the user.
#pragma once

#include <string>

#include "plumbline/node.hpp"
#include "surface/cloud/cloud_file.hpp"

namespace plumbline::surface {

struct Unit {
  const char* name;
  double metres;
};
constexpr Unit kUnits[] = {{"m", 1}, {"cm", 0.01}, {"mm", 0.001}, {"ft", 0.3048}, {"us_ft", 1200.0 / 3937}};

std::string name_of_unit(double metres);

struct UnitOfFile {
  double metres = 1;
  bool stated = true;  ///< by the file or by the user
};

/// `wanted`: "from_file" or a name of kUnits. Warns where nobody says it. Throws std::runtime_error if what is asked
/// for and what the file says differ.
UnitOfFile unit_of(const cloud::CloudSummary& file, const std::string& wanted, const Context& context);

}  // namespace plumbline::surface
