// Variants of the small building for tests of designs.
#pragma once

#include <string>

#include "small_building.hpp"

namespace plumbline::test {

/// An anchor #510 whose shape has the items #520 (and #521), with further instances.
inline std::string with_anchor(const std::string& instances, const std::string& items = "#520") {
  return small_building("IFC4", instances + "#508=IFCSHAPEREPRESENTATION(#22,'Body','Any',(" + items +
                                    "));#509=IFCPRODUCTDEFINITIONSHAPE($,$,(#508));"
                                    "#510=IFCDISCRETEACCESSORY('0cvctVUKr0kugbFTf53O9L',#5,'Odd',$,$,#35,#509,$,$);");
}

}  // namespace plumbline::test
