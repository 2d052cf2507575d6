// A plugin that hangs on a library of a name that another plugin's library has, too.
#include "artifacts/number.hpp"
#include "plumbline/node.hpp"

extern "C" double twin_value();

namespace {

struct Twin : plumbline::Node {
  static constexpr plumbline::Info info{PLUMBLINE_TWIN_KIND, "", 1, "What its library says"};
  Out<plumbline::Number> out{"number", "the number"};
  void run(plumbline::Context&) override {
    plumbline::NumberT number;
    number.value = twin_value();
    out.commit(number);
  }
};

}  // namespace

PLUMBLINE_PLUGIN("twin", "0.1.0", "MIT", Twin)
