// Disagrees with the story plugin on the unit of a type, and on its fields.
#include "artifacts/number.hpp"
#include "plumbline/node.hpp"

namespace {

struct Millimetres : plumbline::Node {
  static constexpr plumbline::Info info{"fault.millimetres", "", 1, "A number of millimetres"};
  Out<plumbline::Number> out{"number", "the number"};
  void run(plumbline::Context&) override {
    plumbline::NumberT number;
    number.value = 3, number.range = 4;
    out.commit(number);
  }
};

}  // namespace

PLUMBLINE_PLUGIN("other_unit", "0.1.0", "MIT", Millimetres)
