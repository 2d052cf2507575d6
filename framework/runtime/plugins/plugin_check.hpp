// Whether the table that a plugin returns is one: nothing null, every struct of its size, every name once, every port's
// type brought along with a sound schema, every default within its bounds, every role kept.
#pragma once

#include <string>

#include "plumbline/plugin.h"
#include "runtime/plugins/roles.hpp"

namespace plumbline::runtime {

/// Why a plugin of that ABI cannot be loaded here; "" if it can.
std::string abi_problem(uint32_t major, uint32_t minor);

/// The first thing that is wrong with the table, where, and what to do; "" if nothing is. It reads what the table
/// points to, so an address that is wild and not null ends the process: call it where that may happen.
std::string check_table(const plumbline_plugin_table* table, const Roles& roles);

/// The type of a port as the plugin itself was built with it; nullptr if it does not bring it.
const plumbline_type* type_of_port(const plumbline_plugin_table& table, const plumbline_port& port);

}  // namespace plumbline::runtime
