// Offers a node that the story plugin has already.
#include "artifacts/number.hpp"
#include "plumbline/node.hpp"

namespace {

struct Constant : plumbline::Node {
  static constexpr plumbline::Info info{"story.constant", "", 1, "Another node of this name"};
  Out<plumbline::Number> out{"number", "the number"};
  void run(plumbline::Context&) override { out.commit(plumbline::NumberT{}); }
};

}  // namespace

PLUMBLINE_PLUGIN("duplicate", "0.1.0", "MIT", Constant)
