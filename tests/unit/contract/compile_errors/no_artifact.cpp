// error: a port carries an artifact
#include "artifacts/number.hpp"
#include "plumbline/node.hpp"

using namespace plumbline;

struct Mine {};
struct Wrong : Node {
  static constexpr Info info{"test.wrong", "", 1, "A port of a type without a schema"};
  In<Mine> in{"in", "what"};
  void run(Context&) override {}
};

PLUMBLINE_PLUGIN("test", "0.1.0", "MIT", Wrong)
