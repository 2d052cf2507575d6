// evaluate.surfaces: ports.
#pragma once

#include "artifacts/file.hpp"
#include "artifacts/surfaces.hpp"
#include "plumbline/node.hpp"

namespace plumbline::judgement {

struct EvaluateSurfaces : Node {
  static constexpr Info info{
      "evaluate.surfaces", "", 2,
      "Measured surfaces against the true ones: planes, bow, joints and steps, what is found and what is stated"};
  In<Surfaces> surfaces{"surfaces", frame("frame=?F"), "panels and joints as they were measured"};
  In<Surfaces> truth{"truth", frame("frame=?F"),
                     "as they are; a panel that has a reason why it is not measured is one that nobody can measure"};
  Out<File> table{"table", "one line a quantity of a panel and a place of a joint, CSV"};

  void run(Context& context) override;
};

}  // namespace plumbline::judgement
