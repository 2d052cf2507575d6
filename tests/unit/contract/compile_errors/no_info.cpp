// error: a node says what it is
#include "artifacts/number.hpp"
#include "plumbline/node.hpp"

using namespace plumbline;

struct Wrong : Node {
  Out<Number> out{"number", "the number"};
  void run(Context&) override {}
};

PLUMBLINE_PLUGIN("test", "0.1.0", "MIT", Wrong)
