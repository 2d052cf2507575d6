#include <gtest/gtest.h>

#include <cmath>

#include "base/text/text.hpp"
#include "base/text/xml_text.hpp"

namespace plumbline::text {
namespace test_text {

using namespace std::string_view_literals;

// A no-break space behind a name made another point of it, and a known point held nothing.
TEST(Text, BlanksThatNobodySeesAreNoPartOfAName) {
  for (const char* name : {"K1", " K1\t", "\xC2\xA0K1", "K1\xC2\xA0 ", "K1\xE2\x80\xAF", "\xE2\x80\x8BK1\xEF\xBB\xBF"})
    EXPECT_EQ(text::trim(name), "K1");
  EXPECT_EQ(text::trim("Stra\xC3\x9F"), "Stra\xC3\x9F") << "a letter whose last byte is none of theirs";
  EXPECT_EQ(text::trim("\xC3\xA0"), "\xC3\xA0");
  EXPECT_EQ(text::trim(" \xC2\xA0 "), "");
}

TEST(Text, DecodesCommonEncodings) {
  EXPECT_EQ(decode_text("\xEF\xBB\xBFPfosten").text, "Pfosten");
  EXPECT_EQ(decode_text("K\xC3\xA4se").encoding, Encoding::utf8);
  EXPECT_EQ(decode_text("K\xE4se 5\x80").text, "K\xC3\xA4se 5\xE2\x82\xAC");
  EXPECT_EQ(decode_text("\xFF\xFEK\0\xE4\0"sv).text, "K\xC3\xA4");
  EXPECT_EQ(decode_text("\xFE\xFF\0K\0\xE4"sv).text, "K\xC3\xA4");
  EXPECT_EQ(decode_text("<\0?\0x\0m\0l\0"sv).text, "<?xml");
  EXPECT_EQ(decode_text("\0<\0?\0x\0m\0l"sv).encoding, Encoding::utf16_big_endian);
  EXPECT_EQ(decode_text("\xFF\xFE\x3D\xD8\x00\xDE"sv).text, "\xF0\x9F\x98\x80");
  EXPECT_EQ(decode_text("\xFF\xFE\x00\xD8"sv).text, "\xEF\xBF\xBD") << "a lone surrogate";
  EXPECT_EQ(decode_text("\xFF\xFEx"sv).text, "") << "half a character";
}

TEST(Text, ControlCharactersBecomePrintable) { EXPECT_EQ(decode_text("A\0B\x01 C\t\r\n\x1A"sv).text, "A B? C\t\r\n "); }

TEST(XmlText, IsWellFormedWhateverComes) {
  EXPECT_EQ(text::xml_escaped("a<b>&\"c'\""), "a&lt;b&gt;&amp;&quot;c&#39;&quot;");
  EXPECT_EQ(text::xml_escaped("M\xC3\xBC"
                              "hle"),
            "M\xC3\xBC"
            "hle");
  EXPECT_EQ(text::xml_escaped("M\xFC"
                              "hle\x01"),
            "M\uFFFDhle ")
      << "a byte that is no UTF-8, and a control character";
  EXPECT_EQ(text::xml_escaped("cut \xE2\x82"), "cut \uFFFD\uFFFD");
  EXPECT_EQ(text::xml_escaped("\xC0\xAF"), "\uFFFD\uFFFD") << "overlong";
  EXPECT_EQ(text::xml_escaped("\xED\xA0\x80"), "\uFFFD\uFFFD\uFFFD") << "a surrogate";
}

TEST(Text, InvalidUtf8IsWindows1252) {
  for (const auto bytes : {"\xC0\x80"sv, "\xED\xA0\x80"sv, "\xF4\x90\x80\x80"sv, "\xE2\x82"sv})
    EXPECT_EQ(decode_text(bytes).encoding, Encoding::windows_1252);
}

TEST(Text, EncodesWindows1252) {
  EXPECT_EQ(encode_windows_1252("K\xC3\xA4se 5\xE2\x82\xAC"), "K\xE4se 5\x80");
  EXPECT_EQ(encode_windows_1252("\xD0\x96"), std::nullopt);
}

TEST(Text, SplitsLinesOfAnyEnd) {
  const auto lines = split_lines("a\r\nb\rc\nd\r\r\re");
  ASSERT_EQ(lines.size(), 7u);
  EXPECT_EQ(lines[3].text, "d");
  EXPECT_EQ(lines[6].text, "e");
  EXPECT_EQ(lines[6].number, 7);
  EXPECT_TRUE(split_lines("").empty());
}

TEST(Text, NumbersAreFiniteOrNothing) {
  EXPECT_EQ(parse_number(" +1.5e3 "), 1500.0);
  EXPECT_EQ(parse_number("-12,25", ','), -12.25);
  for (const char* none : {"", "nan", "NaN", "inf", "-inf", "1e999", "0x10", "1.2.3", "1,5", "--1", "+-1", "1 2", "."})
    EXPECT_EQ(parse_number(none), std::nullopt) << none;
  EXPECT_EQ(parse_number(std::string(1000, '1')), std::nullopt);
  EXPECT_EQ(parse_integer("99999999999999999999"), std::nullopt);
  EXPECT_EQ(parse_integer("+0042"), 42);
  EXPECT_EQ(parse_integer("4.2"), std::nullopt);
}

TEST(Text, CharactersOfALine) {
  const CharacterLine line("a\xC3\xA4z");
  EXPECT_EQ(line.size(), 3u);
  EXPECT_EQ(line.at(2), 'z');
  EXPECT_EQ(line.part(1, 1), "\xC3\xA4");
  EXPECT_EQ(line.part(5, 2), "");
}

TEST(Text, FormatsNumbers) {
  EXPECT_EQ(format_fixed(-0.0004, 3), "0.000");
  EXPECT_EQ(format_fixed(-1.0005, 2), "-1.00");
  EXPECT_EQ(format_shortest(0.1), "0.1");
  EXPECT_EQ(quoted("ab\tcd", 3), "'ab?...'");
}

}  // namespace test_text
}  // namespace plumbline::text
