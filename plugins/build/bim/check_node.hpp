// bim.check: does an IFC file keep the rules.
#pragma once

#include "artifacts/file.hpp"
#include "plumbline/node.hpp"

namespace plumbline::ifc {

struct CheckIfc : Node {
  static constexpr Info info{
      "bim.check", "", 1,
      "Checks an IFC file: EXPRESS rules and buildingSMART's rule families about roots, sets, placements"};
  In<File> file{"file", "the IFC file"};
  Optional<File> design_file{"design_file", "the file it was made from: then only what was added is checked"};
  Param<bool> strict{"strict", false, "an error if a rule is broken"};
  Out<File> report{"report", "check.txt: rule, instance, what was found"};

  void run(Context& context) override;
};

}  // namespace plumbline::ifc
