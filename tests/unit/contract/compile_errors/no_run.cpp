// error: a node overrides
#include "artifacts/number.hpp"
#include "plumbline/node.hpp"

using namespace plumbline;

struct Wrong : Node {
  static constexpr Info info{"test.wrong", "", 1, "Does nothing at all"};
  Out<Number> out{"number", "the number"};
};

PLUMBLINE_PLUGIN("test", "0.1.0", "MIT", Wrong)
