// What the simulator refuses to leave out without a word.
#include <gmock/gmock.h>

#include "node_harness.hpp"

namespace plumbline::test {
namespace test_nodes {

using testing::HasSubstr;

std::string refusal(const std::string& kind, const std::vector<std::pair<std::string, std::string>>& parameters) {
  NodeHarness site(kind);
  for (const auto& [name, value] : parameters) site.set(name, value);
  try {
    site.run();
  } catch (const NodeFailed& error) {
    return error.what();
  }
  return "";
}

TEST(SimulatorNodes, RefuseASizeBelowZeroThatIsNotThatOfOptics) {
  EXPECT_THAT(refusal("simulate.observations", {{"floors", "1"}, {"glare", "-0.5"}}),
              HasSubstr("glare is -0.500000: a size is 0 or more; -1 takes that of optics"));
  EXPECT_EQ(refusal("simulate.observations", {{"floors", "1"}, {"glare", "-1"}}), "");
}

TEST(SimulatorNodes, RefuseWhatOnlyRenderedPhotographsHave) {
  for (const auto& [name, size] : {std::pair("dirt", "3"), {"transfer_curve", "srgb"}, {"jpeg_quality", "50"}}) {
    EXPECT_THAT(refusal("simulate.observations", {{"floors", "1"}, {name, size}}),
                HasSubstr(std::string(name) + ": in rendered photographs only"));
    EXPECT_THAT(refusal("simulate.campaign", {{"floors", "1"}, {"photographs", "observed"}, {name, size}}),
                HasSubstr(std::string(name) + ": in rendered photographs only"));
  }
  // A usual size of everything is one word; what corners can have of it they have.
  EXPECT_EQ(refusal("simulate.observations", {{"floors", "1"}, {"optics", "real"}, {"plate_bend", "0.001"}}), "");
}

}  // namespace test_nodes
}  // namespace plumbline::test
