// What a delivered file holds, as two runs are compared by it.
#include <gtest/gtest.h>

#include <string>

#include "runtime/record/file_content.hpp"

namespace plumbline::test {
namespace test_file_content {

using runtime::content_of_file;

std::string number(std::size_t value, int count) {
  std::string bytes;
  for (int i = 0; i < count; ++i) bytes += static_cast<char>(value >> 8 * i & 255U);
  return bytes;
}

/// A ZIP archive of one stored file without its directory, which is not looked at; `date` is what two archives of the
/// same content may differ by.
std::string archive(const std::string& name, const std::string& content, std::size_t date) {
  return std::string("PK\3\4", 4) + number(20, 2) + number(0, 4) + number(date, 4) + number(0, 4) +
         number(content.size(), 4) + number(content.size(), 4) + number(name.size(), 2) + number(0, 2) + name + content;
}

std::string workbook(const std::string& deviation, std::size_t date) {
  return archive("xl/worksheets/sheet1.xml",
                 "<sheetData><row r=\"1\"><c r=\"A1\" t=\"inlineStr\"><is><t>F01</t></is></c><c r=\"B1\" s=\"3\"><v>" +
                     deviation + "</v></c><c r=\"C1\"/></row></sheetData>",
                 date);
}

// Bytes were compared: a run at another time, or on another machine, differed in its workbook by nothing else.
TEST(FileContent, AWorkbookIsItsCells) {
  const auto content = content_of_file("deviations.xlsx", workbook("2.5", 1));
  const auto& sheet = content["xl/worksheets/sheet1.xml"];
  EXPECT_EQ(sheet["cells"].size(), 2u) << content.dump();
  EXPECT_EQ(sheet["cells"]["B1"], 2.5);
  EXPECT_NE(sheet["cells"]["A1"].dump().find("F01"), std::string::npos);
  EXPECT_EQ(content, content_of_file("deviations.xlsx", workbook("2.5", 2)));
  const auto other = content_of_file("deviations.xlsx", workbook("2.6", 1));
  EXPECT_NE(content, other);
  EXPECT_EQ(sheet["layout"], other["xl/worksheets/sheet1.xml"]["layout"]);
}

TEST(FileContent, AnArchiveThatIsDamagedOrCompressedIsItsBytes) {
  const std::string whole = archive("a.txt", "1.5\n", 1);
  EXPECT_TRUE(content_of_file("a.zip", whole).contains("a.txt"));
  std::string compressed = whole;
  compressed[8] = 8;
  for (const std::string& bytes : {whole.substr(0, whole.size() - 1), compressed})
    EXPECT_NE(content_of_file("a.zip", bytes).dump().find("SHA-256"), std::string::npos);
}

}  // namespace test_file_content
}  // namespace plumbline::test
