// What the schema of an artifact says to people: its fields with units, frames and comments.
#pragma once

#include <string>
#include <vector>

#include "plumbline/plugin.h"

namespace plumbline::runtime {

struct FieldDoc {
  std::string name, type;   ///< "points", "[Point]"
  std::string unit, frame;  ///< as in the schema; may be empty
  std::string doc;
  bool required = false;
};
struct TableDoc {
  std::string name, doc;  ///< without its namespace
  std::vector<FieldDoc> fields;
};

/// The root table, then the tables and structs that it holds, in the order in which they are met.
std::vector<TableDoc> tables_of(const plumbline_type& type);

}  // namespace plumbline::runtime
