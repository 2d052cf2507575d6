// Disagrees with the story plugin on the unit of a type.
#include "artifacts/number.hpp"
#include "plumbline/node.hpp"

namespace {

struct Millimetres : plumbline::Node {
  static constexpr plumbline::Info info{"fault.millimetres", "", 1, "A number of millimetres"};
  Out<plumbline::Number> out{"number", "the number"};
  void run(plumbline::Context&) override { out.commit(plumbline::NumberT{}); }
};

}  // namespace

PLUMBLINE_PLUGIN("other_unit", "0.1.0", "MIT", Millimetres)
