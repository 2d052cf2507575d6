#include <fstream>

#include "base/text/whole_file.hpp"
#include "base/text/words.hpp"
#include "plumbline/failure.hpp"
#include "test_support.hpp"

namespace plumbline::test {
namespace test_words {

TEST(Words, AListIsCutWhereItSaysHowManyAreLeft) {
  EXPECT_EQ(text::join({}), "");
  EXPECT_EQ(text::join({"a", "b"}), "a, b");
  EXPECT_EQ(text::join({"a", "b"}, 2), "a, b");
  EXPECT_EQ(text::join({"a", "b", "c", "d"}, 2), "a, b and 2 more");
}

TEST(Words, AnEnumerationHasAnAndBeforeItsLast) {
  EXPECT_EQ(text::enumerate({"a"}), "a");
  EXPECT_EQ(text::enumerate({"a", "b"}), "a and b");
  EXPECT_EQ(text::enumerate({"a", "b", "c"}), "a, b and c");
  EXPECT_EQ(text::enumerate({"a", "b", "c"}, " or ", "; "), "a; b or c");
}

TEST(Words, ALengthHasNoMinusBeforeZero) {
  EXPECT_EQ(text::millimetres(0.0123), "12.3 mm");
  EXPECT_EQ(text::millimetres(-0.00001), "0.0 mm");
  EXPECT_EQ(text::millimetres(-0.00123, 2), "-1.23 mm");
}

TEST(WholeFile, AllBytesOrTheReasonWhyNot) {
  const TemporaryFolder folder;
  const std::string bytes("a\0b\r\n", 5);
  std::ofstream(folder.path() / "f", std::ios::binary) << bytes;
  EXPECT_EQ(text::read_whole(folder.path() / "f"), bytes);
  for (const auto& [name, reason] : {std::pair{"missing", "No such file"}, std::pair{".", "Is a directory"}}) try {
      text::read_whole(folder.path() / name);
      ADD_FAILURE() << name;
    } catch (const BadInput& error) {
      const std::string what = error.what();
      EXPECT_NE(what.find(name), std::string::npos) << what;
      EXPECT_NE(what.find(reason), std::string::npos) << what;
    }
}

}  // namespace test_words
}  // namespace plumbline::test
