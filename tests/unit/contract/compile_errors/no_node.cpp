// error: a type that does not derive from plumbline::Node
#include "artifacts/number.hpp"
#include "plumbline/node.hpp"

using namespace plumbline;

struct Wrong {
  static constexpr Info info{"test.wrong", "", 1, "Is no node"};
};

PLUMBLINE_PLUGIN("test", "0.1.0", "MIT", Wrong)
