// ok
#include "artifacts/number.hpp"
#include "plumbline/node.hpp"

using namespace plumbline;

struct Counts : Node {
  static constexpr Info info{"test.counts", "", 1, "Parameters of every integer type"};
  Param<int> some{"some", 3, between(-5, 10), "how many"};
  Param<unsigned> more{"more", 3u, "how many"};
  Param<int16_t> few{"few", int16_t{3}, "how many"};
  Param<size_t> size{"size", size_t{3}, "how many"};
  Param<std::vector<int>> list{"list", {1, 2}, "how many"};
  Param<std::vector<bool>> flags{"flags", {true, false}, "which"};
  Out<Number> out{"number", "the number"};
  void run(Context&) override { out.commit(NumberT{}); }
};

PLUMBLINE_PLUGIN("test", "0.1.0", "MIT", Counts)
