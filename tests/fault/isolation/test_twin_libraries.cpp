// Two plugins with libraries of one name: a process has one of them only, and nobody computes with the other's unseen.
// Before the tests after which all nodes of their process run apart.
#include "isolated_run.hpp"

namespace plumbline::test {
namespace test_twin_libraries {

TEST_F(Isolation, ALibraryThatAnotherPluginBroughtIsRefused) {
  ASSERT_TRUE(registry_.load(PLUMBLINE_TWIN_1));
  ASSERT_TRUE(registry_.load(PLUMBLINE_TWIN_2));
  run("  one: {use: twin.1}\n");
  EXPECT_EQ(Json::parse(value("one")).at("value"), 1.0) << node("one").error;
  run("  two: {use: twin.2}\n");
  EXPECT_EQ(node("two").status, NodeStatus::failed) << value("two");
  EXPECT_TRUE(contains(node("two").error, "needs libtwin.so:")) << node("two").error;
  EXPECT_TRUE(contains(node("two").error, "which another plugin brought")) << node("two").error;
  run("  one: {use: twin.1}\n  two: {use: twin.2}\n", true);
  EXPECT_EQ(node("two").error, "") << "alone it has its own";
  EXPECT_EQ(Json::parse(value("two")).at("value"), 2.0);
}

}  // namespace test_twin_libraries
}  // namespace plumbline::test
