// What the built programs and plugins load, with all that that loads, against the table of NOTICE.md.
#include <gtest/gtest.h>

#include <array>
#include <cstdio>
#include <map>
#include <regex>
#include <set>

#include "test_support.hpp"

namespace test_licences {

namespace fs = std::filesystem;

struct Row {
  std::string licence, by;  ///< by: what loads it
};

/// The table of NOTICE.md: library -> licence.
std::map<std::string, Row> noticed() {
  std::map<std::string, Row> rows;
  const std::string text = plumbline::test::read_file(fs::path(plumbline::test::source_dir()) / "NOTICE.md");
  static const std::regex row("\\| (`[^|]*) \\| ([^|]*) \\| ([^|]*) \\|"), name("`([^`]+)`");
  for (std::sregex_iterator r(text.begin(), text.end(), row), end; r != end; ++r) {
    const std::string names = (*r)[1];
    for (std::sregex_iterator n(names.begin(), names.end(), name); n != end; ++n) rows[(*n)[1]] = {(*r)[2], (*r)[3]};
  }
  return rows;
}

/// Names, without versions, of all shared libraries that loading `file` brings in.
std::set<std::string> loaded_by(const fs::path& file) {
  std::set<std::string> names;
  FILE* listing = popen(("ldd '" + file.string() + "'").c_str(), "r");
  if (!listing) throw std::runtime_error("ldd cannot be started");
  std::array<char, 4096> line;
  static const std::regex library("^\\s*(?:\\S*/)?([^/\\s]+?)(?:\\.so[.0-9]*)?\\s+(=>|\\()");
  std::cmatch match;
  while (std::fgets(line.data(), static_cast<int>(line.size()), listing))
    if (std::regex_search(line.data(), match, library) && match[1] != "linux-vdso")
      names.insert(std::regex_replace(match[1].str(), std::regex("^(lib.*)-[0-9][.0-9]*$"), "$1"));
  if (pclose(listing) != 0) throw std::runtime_error("ldd failed on " + file.string());
  return names;
}

std::vector<fs::path> binaries() {
  std::vector<fs::path> files = {PLUMBLINE_PROGRAM, PLUMBLINE_ROBOTS};
  for (const auto& entry : fs::directory_iterator(PLUMBLINE_PLUGIN_FOLDER)) files.push_back(entry.path());
  return files;
}

bool is_gpl(const std::string& licence) {
  return licence.starts_with("GPL-") && licence.find("exception") == std::string::npos;
}

TEST(Licences, EverythingThatIsLoadedIsInTheNotice) {
  const auto rows = noticed();
  ASSERT_GT(rows.size(), 20u);
  for (const fs::path& file : binaries())
    for (const std::string& library : loaded_by(file))
      EXPECT_EQ(rows.count(library), 1u) << file.filename() << " loads " << library
                                         << ": add it to NOTICE.md with its licence, or link without it";
}

/// Plugins under MIT that linked Exiv2 and SuiteSparse could not be passed on as such.
TEST(Licences, OnlyTheAdjusterByCeresLoadsWhatIsUnderTheGpl) {
  const auto rows = noticed();
  std::size_t ceres = 0;
  for (const fs::path& file : binaries())
    for (const std::string& library : loaded_by(file)) {
      const auto row = rows.find(library);
      if (row == rows.end() || !is_gpl(row->second.licence) || library == "libjbig") continue;  // Debian's libtiff
      EXPECT_EQ(file.filename(), "plumbline_adjust_ceres.so") << library;
      ++ceres;
    }
  EXPECT_GT(ceres, 0u) << "this test sees nothing: plumbline_adjust_ceres.so loads SuiteSparse";
}

std::string output_of(const std::string& command) {
  FILE* stream = popen(command.c_str(), "r");
  std::string text;
  std::array<char, 4096> part;
  while (stream && std::fgets(part.data(), static_cast<int>(part.size()), stream)) text += part.data();
  if (stream) pclose(stream);
  return text;
}

TEST(Licences, TheProgramSaysWhatAPluginIsLinkedWith) {
  const std::string environment =
      std::string("PLUMBLINE_PLUGIN_PATH='") + PLUMBLINE_PLUGIN_FOLDER + "' '" + PLUMBLINE_PROGRAM + "' ";
  const std::string ceres = output_of(environment + "describe adjust.ceres 2>&1");
  EXPECT_NE(ceres.find("libcholmod"), std::string::npos) << ceres;
  EXPECT_NE(ceres.find("GPL-2.0-or-later"), std::string::npos) << ceres;
  const std::string schur = output_of(environment + "describe adjust.schur 2>&1");
  EXPECT_NE(schur.find("adjust.schur"), std::string::npos) << schur;
  EXPECT_EQ(schur.find("libcholmod"), std::string::npos) << schur;  // libjbig comes with Debian's libtiff, and is told
  EXPECT_NE(output_of(environment + "doctor 2>&1").find("is loaded by adjust_ceres"), std::string::npos);
}

}  // namespace test_licences
