// What the parameters of the nodes that read tables do beyond the readers themselves (tests/unit/survey_files).
#include <gtest/gtest.h>

#include <string>

#include "artifacts/file.hpp"
#include "node_harness.hpp"

namespace plumbline::test {
namespace test_table_reader_nodes {

/// The warnings of read.survey_csv of a table whose header names no unit of lengths.
std::string warned(const std::string& length_unit) {
  FileT file;
  file.name = "l.csv";
  const std::string text = "station,target,hz [gon],v [gon],sd,th\nS1,A,0,100,10,1.5\n";
  file.content.assign(text.begin(), text.end());
  NodeHarness node("read.survey_csv");
  node.input<File>("file", file);
  if (!length_unit.empty()) node.set("length_unit", length_unit);
  node.run();
  std::string all;
  for (const std::string& warning : node.warnings()) all += warning + "\n";
  return all;
}

/// Whoever says metres is not told that metres are taken.
TEST(TableReaderNodes, MetresThatAreSaidAreNotWarnedOf) {
  EXPECT_NE(warned("").find("names no unit for slope_distance and other lengths: m is taken"), std::string::npos);
  EXPECT_EQ(warned("m"), "");
}

}  // namespace test_table_reader_nodes
}  // namespace plumbline::test
