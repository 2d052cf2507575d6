#include <gtest/gtest.h>

#include "show/report/anchor_names.hpp"

namespace plumbline::report {
namespace test_anchor_names {

AccuracyT anchors(const std::vector<std::tuple<std::string, int, int>>& rows) {
  AccuracyT accuracy;
  for (const auto& [id, floor, column] : rows) {
    auto anchor = std::make_unique<AnchorAccuracyT>();
    anchor->id = id, anchor->floor = floor, anchor->column = column;
    accuracy.anchors.push_back(std::move(anchor));
  }
  return accuracy;
}

using Names = std::map<int, std::string>;

TEST(AnchorNames, AFloorsPartIsSaidOnce) {
  EXPECT_EQ(
      common_prefixes(anchors({{"F01-C01-R1", 1, 1}, {"F01-K1", 1, 2}, {"F02-K1", 2, 2}, {"x", 0, 0}, {"y", 0, 0}})),
      (Names{{1, "F01-"}}));
}

TEST(AnchorNames, AColumnIsCalledWhatItsAnchorsShare) {
  const AccuracyT accuracy = anchors({{"F01-C01-R1", 1, 1},
                                      {"F01-C01-R2", 1, 1},
                                      {"F02-C01-R1", 2, 1},
                                      {"F01-K1", 1, 5},
                                      {"F02-K1", 2, 5},
                                      {"F01-A", 1, 6},
                                      {"F02-B", 2, 6},
                                      {"F01-Z", 1, 0}});
  EXPECT_EQ(column_names(accuracy), (Names{{1, "C01"}, {5, "K1"}, {6, "column 6"}}));
}

TEST(AnchorNames, LongOnesAreCutToTheEndInWhichTheyDiffer) {
  EXPECT_EQ(end_of("F01-C01-R1-X"), "F01-C01-R1-X");
  EXPECT_EQ(end_of("Anchor:HTA 38/17:1043775"), "\u20261043775");
  EXPECT_EQ(end_of("Befestigung S\u00fcd-12"), "\u2026S\u00fcd-12");
  EXPECT_EQ(end_of("Befestigung S\u00fc-12345"), "\u2026-12345");  // not the second half of a letter
}

TEST(AnchorNames, NamesWithoutAnySystem) {
  EXPECT_EQ(column_names(anchors({{"12", 1, 1}, {"47", 2, 1}, {"13", 1, 2}, {"48", 2, 2}})),
            (Names{{1, "column 1"}, {2, "column 2"}}));
}

}  // namespace test_anchor_names
}  // namespace plumbline::report
