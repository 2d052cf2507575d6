// What tests of designs share: a design out of bytes, an element by its name.
#pragma once

#include <stdexcept>
#include <string>

#include "building/ifc/design.hpp"

namespace plumbline::ifc {

inline Design read(const std::string& bytes, const AnchorRule& rule = {}) {
  return read_design(step::File(bytes, "t.ifc"), rule);
}

inline const Element& named(const Design& design, const std::string& name) {
  for (const Element& element : design.elements)
    if (element.name == name) return element;
  throw std::runtime_error("no element " + name);
}

}  // namespace plumbline::ifc
