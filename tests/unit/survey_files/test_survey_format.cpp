#include <gtest/gtest.h>

#include "base/text/text.hpp"
#include "survey/files/survey_format.hpp"
#include "survey_test_support.hpp"

namespace plumbline::survey {
namespace test_survey_format {

using namespace test_help;

struct Known {
  const char* file;
  SurveyFormat format;
};

constexpr Known kFixtures[] = {
    {"station_coordinates.gsi", SurveyFormat::gsi},
    {"code_block_cr_only.gsi", SurveyFormat::gsi},
    {"damaged.gsi", SurveyFormat::gsi},
    {"one_line_windows_1252.gsi", SurveyFormat::gsi},
    {"survey.landxml", SurveyFormat::landxml},
    {"leica.hexml.xml", SurveyFormat::landxml},
    {"job.jxl", SurveyFormat::jobxml},
    {"wide.sdr", SurveyFormat::sdr33},
    {"narrow.sdr", SurveyFormat::sdr33},
    {"carlson.rw5", SurveyFormat::rw5},
    {"network.gkf", SurveyFormat::gama_xml},
    {"krumm.dat", SurveyFormat::krumm},
    {"setup_coordinates.csv", SurveyFormat::setup_coordinates},
    {"points_penzd.csv", SurveyFormat::csv},
    {"points_no_header.txt", SurveyFormat::csv},
    {"sightings.csv", SurveyFormat::csv},
    {"level.gsi", SurveyFormat::gsi},
    {"elta.m5", SurveyFormat::zeiss},
    {"dini.m5", SurveyFormat::zeiss},
    {"nikon.raw", SurveyFormat::nikon},
    {"topcon.gts7", SurveyFormat::topcon_gts7},
    {"topcon.210", SurveyFormat::topcon_gts210},
    {"topcon_level.dat", SurveyFormat::topcon_level},
    {"sokkia_level.csv", SurveyFormat::topcon_level},
    {"geodimeter.job", SurveyFormat::geodimeter},
    {"leica.idx", SurveyFormat::idx},
    {"starnet.dat", SurveyFormat::starnet},
    {"dynaml.xml", SurveyFormat::dynaml},
};

TEST(SurveyFormat, IsFoundFromTheContentAlone) {
  for (const Known& known : kFixtures) {
    EXPECT_EQ(detect_survey_format(fixture(known.file), "unnamed"), known.format) << known.file;
    EXPECT_EQ(detect_survey_format(fixture(known.file), "misnamed.gsi"), known.format) << known.file;
  }
}

// A public job of STAR*NET has nothing but points and vectors.
TEST(SurveyFormat, StarNetWithVectorsAloneIsFound) {
  const std::string vectors =
      "C FRDN 7437047.544 2487601.211 117.930 ! ! !\nC GPS1 7438438.738 2488810.241 64.839\n.GPS WEIGHT COVARIANCE\n"
      "G0 'V1\nG1 FRDN-GPS1 1022.0 -760.5 853.1\nG2 1E-6 2E-6 2E-6\nG3 1E-7 1E-7 -1E-6\n";
  EXPECT_EQ(detect_survey_format(vectors, "job.txt"), SurveyFormat::starnet);
  EXPECT_EQ(detect_survey_format(".3D\nC A 0 0 0 ! ! !\nC B 10 0 0\nD A-B 10.001\n", "job.txt"), SurveyFormat::starnet);
  EXPECT_NE(detect_survey_format("C 1 100.0 200.0 3.0\nG2 110.0 200.0 3.0\nE 120.0 200.0 3.0\n", "points.txt"),
            SurveyFormat::starnet)
      << "points may be called so";
}

TEST(SurveyFormat, UnknownContentIsNoFormat) {
  for (const char* text : {"", "   \n", "Dear all,\nplease find attached\nthe report.\n", "<html><body/></html>",
                           "{\"a\": 1}", "<", "<!--", "<!DOCTYPE x [", "<?xml"})
    EXPECT_EQ(detect_survey_format(text, "unnamed"), std::nullopt) << text;
  EXPECT_EQ(detect_survey_format("<!DOCTYPE a [<!ENTITY b 'c'>]><!-- x --><n:LandXML/>", ""), SurveyFormat::landxml);
  EXPECT_EQ(detect_survey_format("<?xml version='1.0'?><gama-local xmlns='x'>", ""), SurveyFormat::gama_xml);
}

TEST(SurveyFormat, ReadsEveryFormatAndInUtf16Too) {
  for (const Known& known : kFixtures) {
    const std::string bytes = fixture(known.file);
    const SurveyObservations survey = read_survey(bytes, known.file);
    EXPECT_EQ(survey.files.at(0), known.file);
    const std::string utf8 = text::decode_text(bytes).text;
    bool ascii = true;
    std::string utf16 = "\xFE\xFF";
    for (const char c : utf8) {
      ascii = ascii && static_cast<unsigned char>(c) < 0x80;
      utf16 += {'\0', c};
    }
    if (ascii) {
      EXPECT_EQ(read_survey(utf16, known.file).observations.size(), survey.observations.size()) << known.file;
    }
  }
}

TEST(SurveyFormat, AFileOfNoFormatSaysWhatWasFoundAndWhatIsUnderstood) {
  const std::string text = error_of([] { read_survey("Dear all,\nplease find attached\n", "letter.txt"); });
  EXPECT_NE(text.find("letter.txt:1:1: found a file that begins with 'Dear all,'"), std::string::npos) << text;
  EXPECT_NE(text.find("Leica GSI-8 and GSI-16"), std::string::npos);
  EXPECT_NE(error_of([] { read_survey("", "e"); }).find("an empty file (0 bytes)"), std::string::npos);
}

/// Rows of an instrument that nobody knows look like points; columns of a table are not what is wrong with them.
TEST(SurveyFormat, AFileThatNoReaderNamesIsNotBlamedOnColumns) {
  const std::string tracker = "AT T1 1.500\nP1 12.30512 98.20411 14.503\nP2 311.0 101.2 9.1\nP3 200.0 99.2 9.1\n";
  ASSERT_EQ(detect_survey_format(tracker, "a.TRK"), SurveyFormat::csv) << "this test must be able to fail";
  const std::string text = error_of([&] { read_survey(tracker, "a.TRK"); });
  EXPECT_NE(text.find("a.TRK:1:1: found a file that is neither called like a format that is known nor looks like one"),
            std::string::npos)
      << text;
  EXPECT_NE(text.find("a plugin that reads *.trk"), std::string::npos) << text;
  EXPECT_NE(text.find("line 1: 'T1'"), std::string::npos) << text;
  EXPECT_EQ(text.find("column e"), std::string::npos) << text;
  // The same rows under a table's name are a table with a wrong row.
  EXPECT_EQ(read_survey(tracker, "a.txt").skipped.size(), 1u);
  // Taken for points it is said.
  const std::string points = "P1 12.30512 98.20411 14.503\nP2 311.0 101.2 9.1\nP3 200.0 99.2 9.1\n";
  const auto is_told = [](const SurveyObservations& survey) {
    return std::ranges::any_of(survey.warnings, [](const std::string& warning) {
      return warning.find("they are taken as points") != std::string::npos &&
             warning.find("*.trk") != std::string::npos;
    });
  };
  EXPECT_EQ(read_survey(points, "day.1/a.trk").points.size(), 3u);
  EXPECT_TRUE(is_told(read_survey(points, "day.1/a.trk")));
  for (const char* name : {"a.csv", "a.txt", "a.DAT", "day.1/a", "a"})
    EXPECT_FALSE(is_told(read_survey(points, name))) << name;
  EXPECT_FALSE(is_told(read_survey("id,E,N,H\nP1,12.3,98.2,14.5\n", "a.trk"))) << "its header says what it is";
}

TEST(SurveyFormat, RealFiles) {
  const std::pair<const char*, SurveyFormat> files[] = {
      {"survey/gsi/network_22_setups.GSI", SurveyFormat::gsi},
      {"survey/gsi/gurob_gsi16_dms.gsi", SurveyFormat::gsi},
      {"survey/landxml/landxml.xml", SurveyFormat::landxml},
      {"survey/rw5/Leica1200.rw5", SurveyFormat::rw5},
      {"survey/sdr33/20151125.sdr", SurveyFormat::sdr33},
      {"survey/BlankenbachWillert3D_Distance_fix.dat", SurveyFormat::krumm},
      {"survey/gama/local_3d.gkf", SurveyFormat::gama_xml},
      {"survey/gama/from-to-dh.gkf", SurveyFormat::gama_xml}};
  for (const auto& [file, format] : files) {
    PLUMBLINE_REQUIRE_DATA(file);
    EXPECT_EQ(detect_survey_format(test::read_file(test::data_file(file)), ""), format) << file;
  }
}

TEST(SurveyFormat, AnotherXmlIsNamedByItsRoot) {
  try {
    read_survey("<?xml version=\"1.0\"?>\n<SurveyProject type=\"Measurement File\"></SurveyProject>", "m.xml");
    ADD_FAILURE() << "was read";
  } catch (const SurveyReadError& error) {
    EXPECT_NE(error.found.find("SurveyProject"), std::string::npos) << error.what();
  }
}

}  // namespace test_survey_format
}  // namespace plumbline::survey
