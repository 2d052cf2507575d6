// error: in place of float write double
#include "artifacts/number.hpp"
#include "plumbline/node.hpp"

using namespace plumbline;

struct Wrong : Node {
  static constexpr Info info{"test.wrong", "", 1, "A parameter of single precision"};
  Param<float> height{"height", 1.0f, "how high"};
  void run(Context&) override {}
};

PLUMBLINE_PLUGIN("test", "0.1.0", "MIT", Wrong)
