// "selection: name=length, name=length": the form of every rule that gives lengths to chosen elements (tolerances,
// mounting of plates, offsets of targets).
#pragma once

#include <string>
#include <string_view>
#include <vector>

#include "building/ifc/selection.hpp"

namespace plumbline::ifc {

/// What stands before the last colon and behind it; names and expressions before it may hold others. Throws
/// std::runtime_error that quotes `text` and `example`.
struct SelectionAndRest {
  Selection selection;
  std::string rest;
};
SelectionAndRest split_rule(const std::string& text, const std::string& example);

/// A length with its unit, mm or m [m]; nan if it is none.
double length_with_unit(std::string_view text);

struct NamedLength {
  std::string name;
  double metres = 0;  ///< finite; nan: what stands there is no length with its unit, mm or m
  std::string text;   ///< the part as it was written
};

struct LengthRule {
  Selection selection;
  std::vector<NamedLength> lengths;  ///< in their order
  std::string text;                  ///< the whole rule, without blanks at its ends
};

/// Throws likewise where there is no colon; what a name or a length may be is for the caller to say.
LengthRule parse_lengths(const std::string& text, const std::string& example);

}  // namespace plumbline::ifc
