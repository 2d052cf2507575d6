// error: in place of const char* std::string
#include "artifacts/number.hpp"
#include "plumbline/node.hpp"

using namespace plumbline;

struct Wrong : Node {
  static constexpr Info info{"test.wrong", "", 1, "A text as a pointer"};
  Param<const char*> name{"name", "x", "which"};
  void run(Context&) override {}
};

PLUMBLINE_PLUGIN("test", "0.1.0", "MIT", Wrong)
