// Designs in an archive: what Info-ZIP and Python write, our own, and what is none.
#include <gtest/gtest.h>
#include <zlib.h>

#include <cstdlib>
#include <filesystem>
#include <fstream>

#include "building/step/step.hpp"
#include "building/step/zip_reader.hpp"
#include "building/step/zip_writer.hpp"
#include "small_building.hpp"
#include "test_support.hpp"

namespace plumbline {
namespace test_zip_reader {

std::string message_of(const std::string& archive) {
  try {
    step::unzip_ifc(archive);
  } catch (const std::runtime_error& error) {
    return error.what();
  }
  return "";
}

std::string archive_of(const std::vector<std::string>& names, const std::string& content = "ISO-10303-21;") {
  step::ZipWriter writer;
  for (const std::string& name : names) writer.add(name, content);
  return writer.finish();
}

/// Deflated by another program (Python's zipfile), with folders and what macOS adds.
TEST(ZipReader, ReadsWhatOtherProgramsPack) {
  const auto folder = std::filesystem::temp_directory_path() / "plumbline_zip_reader";
  std::filesystem::create_directories(folder);
  const std::string design = test::small_building("IFC4");
  std::ofstream(folder / "design.ifc", std::ios::binary) << design;
  const std::string script =
      "import zipfile,sys; z=zipfile.ZipFile('d.ifczip','w',zipfile.ZIP_DEFLATED); z.writestr('model/','');"
      "z.write('design.ifc','model/Straße.IFC'); z.writestr('__MACOSX/model/._x.ifc','x'); z.comment=b'PK sent by us'; "
      "z.close()";
  const std::string command = "cd " + folder.string() + " && /usr/bin/python3 -c \"" + script + "\"";
  ASSERT_EQ(std::system(command.c_str()), 0);
  const std::string archive = test::read_file(folder / "d.ifczip");
  ASSERT_LT(archive.size(), design.size() / 2);
  EXPECT_EQ(step::unzip_ifc(archive).content, design);
  EXPECT_EQ(step::unzip_ifc(archive).name, "model/Straße.IFC");
  // Through all ways in, the model is that of the archive.
  const step::File plain(design, "d.ifc");
  const step::File mapped = step::File::read((folder / "d.ifczip").string(), "d.ifczip");
  for (const step::File* file : {&mapped}) {
    EXPECT_EQ(file->bytes(), plain.bytes());
    EXPECT_EQ(file->instances().size(), plain.instances().size());
  }
  EXPECT_EQ(step::File::view(archive, "v").bytes(), plain.bytes());
  EXPECT_EQ(step::File(archive, "o").largest_id(), plain.largest_id());
  std::filesystem::remove_all(folder);
}

TEST(ZipReader, RefusesInWordsWhatIsNoSingleModel) {
  EXPECT_EQ(step::unzip_ifc(archive_of({"a.ifc", "readme.txt"})).content, "ISO-10303-21;");
  EXPECT_NE(message_of(archive_of({"a.ifc", "b.ifc"})).find("several models (a.ifc, b.ifc)"), std::string::npos);
  EXPECT_EQ(step::unzip_ifc(archive_of({"a.ifcxml", "readme.txt"})).name, "a.ifcxml");
  EXPECT_EQ(step::unzip_ifc(archive_of({"a.ifcxml", "a.ifc"})).name, "a.ifc");
  EXPECT_NE(message_of(archive_of({"plan.dwg"})).find("no file that ends in .ifc or .ifcxml, but plan.dwg"),
            std::string::npos);
  EXPECT_NE(message_of(archive_of({})).find("no file that ends in .ifc"), std::string::npos);
  std::string wrong = archive_of({"a.ifc"});
  wrong[40] = 'X';  // in the content
  EXPECT_NE(message_of(wrong).find("checksum of a.ifc is wrong"), std::string::npos);
  std::string locked = archive_of({"a.ifc"});
  locked[locked.rfind("PK\x01\x02") + 8] |= 1;
  EXPECT_NE(message_of(locked).find("encrypted"), std::string::npos);
}

/// Cut anywhere, or with any byte changed, it is read or refused, and never more than it holds.
TEST(ZipReader, EveryDamageIsReadOrNamed) {
  const std::string whole = archive_of({"a.ifc", "b.txt"});
  for (std::size_t cut = 0; cut < whole.size(); ++cut) EXPECT_NE(message_of(whole.substr(0, cut)), "") << cut;
  for (std::size_t at = 0; at < whole.size(); ++at)
    for (const int change : {1, 0x80, 0xff}) {
      std::string damaged = whole;
      damaged[at] = static_cast<char>(damaged[at] ^ change);
      message_of(damaged);
    }
  std::string bomb = archive_of({"a.ifc"});
  const std::size_t directory = bomb.rfind("PK\x01\x02");
  bomb[directory + 27] = 0x40;  // a gigabyte
  EXPECT_NE(message_of(bomb).find("holds a.ifc with 1073"), std::string::npos);
}

}  // namespace test_zip_reader
}  // namespace plumbline
