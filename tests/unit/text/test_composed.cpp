#include <gtest/gtest.h>

#include "base/text/composed.hpp"

namespace plumbline::text {
namespace test_composed {

TEST(Composed, JoinsALetterAndItsMark) {
  EXPECT_EQ(composed("Su\u0308d"), "S\u00FCd");
  EXPECT_EQ(composed("S\u00FCd.csv"), "S\u00FCd.csv");
  EXPECT_EQ(composed("A\u030A, o\u0302\u0301"), "\u00C5, \u1ED1") << "two marks of one letter";
  EXPECT_EQ(composed("\u304B\u3099"), "\u304C");
  EXPECT_EQ(composed("\u1112\u1161\u11AB"), "\uD55C") << "Korean syllables are computed";
  EXPECT_EQ(composed("q\u0308"), "q\u0308") << "Unicode has no such letter";
  EXPECT_EQ(composed("\U0001F3D7u\u0308"), "\U0001F3D7\u00FC");
}

TEST(Composed, LeavesWhatIsNoUtf8) {
  for (const char* text : {"",
                           "S\xFC"
                           "d",
                           "u\xCC", "\xE3\x82", "\x88"})
    EXPECT_EQ(composed(text), text);
}

}  // namespace test_composed
}  // namespace plumbline::text
