#include <gtest/gtest.h>

#include "base/text/csv_table.hpp"
#include "survey/files/survey_csv.hpp"
#include "survey_test_support.hpp"

namespace plumbline::survey {
namespace test_survey_csv {

using namespace test_help;
using enum ObservationKind;

TEST(CsvTable, DetectsDelimiterAndDecimalSeparator) {
  const auto dialect = [](const char* text) { return text::read_csv(text, {}).dialect(); };
  EXPECT_EQ(dialect("1,2.5,3.5\n"), "delimiter ',', decimal separator '.'");
  EXPECT_EQ(dialect("P1;2,5;3,5\n"), "delimiter ';', decimal separator ','");
  EXPECT_EQ(dialect("P1 2,5 3,5\n"), "delimiter blank, decimal separator ','");
  EXPECT_EQ(dialect("P1\t2.5\t3\n"), "delimiter tab, decimal separator '.'");
  EXPECT_EQ(dialect("P1, 2.5, 3.25\n"), "delimiter ',', decimal separator '.'");
  EXPECT_EQ(dialect("P1;1;2\nP2;1,5;2\n"), "delimiter ';', decimal separator ','");
}

TEST(CsvTable, QuotesAndColumns) {
  const auto table = text::read_csv("a,\"b,\"\"c\",  d\n", {});
  ASSERT_EQ(table.rows.size(), 1u);
  ASSERT_EQ(table.rows[0].cells.size(), 3u);
  EXPECT_EQ(table.rows[0].cells[1].text, "b,\"c");
  EXPECT_EQ(table.rows[0].cells[2].column, 13);
  for (const char* name : {"=1+1", "+A", "-1-1", "-A", "@x", "'=x", "''+y", "=a,b"}) {
    const std::string field = text::csv_field(name);
    EXPECT_NE(std::string("=+-@").find(field[field[0] == '"']), 0u) << field;
    EXPECT_EQ(field[field[0] == '"'], '\'') << field << ": a spreadsheet must not take it for a formula";
    const auto back = text::read_csv("id,e\n" + field + ",1\n", {{"id", "id"}, {"e", "e"}});
    ASSERT_EQ(back.rows.size(), 1u);
    EXPECT_EQ(back.rows[0].cells[0].text, name) << "and reads back as it was";
  }
  EXPECT_EQ(text::csv_field("O'Neill"), "O'Neill");
  for (const char* number : {"-1", "+2.5", "-1e-3"}) EXPECT_EQ(text::csv_field(number), number);
  EXPECT_EQ(text::csv_field("b,\"c"), "\"b,\"\"c\"");
}

TEST(SurveyCsv, ReadsPointsWithDecimalCommaAndLatin1) {
  const auto survey = read_survey_csv(fixture("points_penzd.csv"), "p.csv");
  EXPECT_EQ(point(survey, "A-1").coordinates, Eigen::Vector3d(1000.125, 2000.5, 10.25));
  EXPECT_EQ(point(survey, "A-2").code, "Plat;te");
  EXPECT_TRUE(std::isnan(point(survey, "A-5").coordinates[2]));
  EXPECT_EQ(survey.points.size(), 3u);
  EXPECT_TRUE(skipped(survey, 4, 5, "a number in column e (delimiter ';', decimal separator ',')"));
  EXPECT_TRUE(skipped(survey, 5, 8, "a number"));
  EXPECT_TRUE(skipped(survey, 7, 19, "above zero")) << "a standard deviation of zero is a mistake";
  ASSERT_EQ(survey.coordinates.size(), 2u);
  EXPECT_TRUE(survey.coordinates[0].is_control);
  ASSERT_EQ(survey.coordinates[0].components.size(), 1u) << "only the height has a standard deviation";
  EXPECT_EQ(survey.coordinates[0].components[0].axis, 2);
  EXPECT_DOUBLE_EQ(survey.coordinates[0].covariance(0, 0), 0.8e-3 * 0.8e-3);
}

TEST(SurveyCsv, GermanHeightsAndColumnsThatNobodyKnows) {
  const auto survey = read_survey_csv(
      "Standpunkt;Zielpunkt;Hz [gon];Zenitdistanz [gon];Schr\xC3\xA4gstrecke [m];Instrumentenh\xC3\xB6he [m];"
      "Zielh\xC3\xB6he [m];Wetter\r\nS1;A;0,0000;100,1234;12,3456;1,500;1,600;Sonne\r\n",
      "de.csv");
  ASSERT_EQ(survey.set_ups.size(), 1u);
  EXPECT_DOUBLE_EQ(survey.set_ups[0].instrument_height, 1.5);
  EXPECT_DOUBLE_EQ(survey.observations[0].target_height, 1.6);
  ASSERT_EQ(survey.warnings.size(), 1u) << "a column that is left out might be a height";
  EXPECT_NE(survey.warnings[0].find("'wetter'"), std::string::npos) << survey.warnings[0];
}

// A known name that a table of sightings has no use for was passed over: the pole of 1.5 m in a column 'h' was none,
// and every point 1.5 m too high.
TEST(SurveyCsv, SightingsHaveNoColumnThatIsPassedOverInSilence) {
  const auto read = [](const std::string& text) { return read_survey_csv(text, "s.csv"); };
  const auto refused = [&](const std::string& text) { return error_of([&] { read(text); }); };
  EXPECT_NE(
      refused("station,target,hz [gon],v [gon],sd [m],h\nS1,A,0,100,10,1.5\n").find("'h' in a table of sightings"),
      std::string::npos);
  EXPECT_NE(refused("station;target;hz [gon];z;s\nS1;A;0;100;10\n").find("target height or a zenith angle"),
            std::string::npos);
  EXPECT_NE(refused("station,target,azimuth [gon],v [gon],sd\nS1,A,0,100,10\n").find("directions of the circle"),
            std::string::npos);
  // Coordinates that the instrument computed, and a height of the point beside the pole's, are no readings.
  const auto computed =
      read("station,target,hz [gon],v [gon],sd [m],th,e,n,h,sigma [mm],nr,set\nS1,A,0,100,10,1.5,1,2,3,2,7,1\n");
  EXPECT_DOUBLE_EQ(computed.observations[0].target_height, 1.5);
  ASSERT_EQ(computed.warnings.size(), 1u);
  EXPECT_EQ(
      computed.warnings[0],
      "columns that a table of sightings does not use are left out: 'e', 'n', 'h', 'sigma'; how accurate readings "
      "are is that of the instrument's profile");
  EXPECT_NO_THROW(read("station,target,hz [gon],v [gon],sd,th,h\nS1,A,0,100,10,1.5,3\n"));
}

/// A degree in German, a gon in French: taken for gon, a point of 50 m away stood 15 m too high.
TEST(SurveyCsv, GradIsWhatTheReadingsSay) {
  const auto read = [](const std::string& rows) {
    return read_survey_csv("Standpunkt;Zielpunkt;Hz [Grad];V [Grad];Schr\u00e4gstrecke [m]\n" + rows, "g.csv");
  };
  EXPECT_NE(
      error_of([&] { read("S1;P1;0,0;90,0;100,0\nS1;P2;45,5;89,0;50,0\n"); }).find("angles in 'Grad', a degree in"),
      std::string::npos);
  const auto gon = read("S1;P1;399,5;100,0;100,0\nS1;P2;45,5;99,0;50,0\n");
  EXPECT_NEAR(value(gon, 1, zenith_angle), 99 * kGon, 1e-12);
  EXPECT_EQ(gon.warnings.at(0).find("'Grad' of direction, zenith is a degree in German and a gon in French: gon is"),
            0u)
      << gon.warnings[0];
}

TEST(SurveyCsv, ATableThatNamesNoUnitOfLengthsIsTold) {
  const auto warned = [](const std::string& header) {
    const auto s = read_survey_csv(header + "\nS1,A,0,100,10,1.5\n", "l.csv");
    return !s.warnings.empty() &&
           s.warnings[0].find("no unit for slope_distance and other lengths: m is") != std::string::npos;
  };
  EXPECT_TRUE(warned("station,target,hz [gon],v [gon],sd,th"));
  EXPECT_FALSE(warned("station,target,hz [gon],v [gon],sd [m],th")) << "one column says it";
  SurveyCsvOptions options;
  options.length_unit = "ft";
  const auto told = read_survey_csv("station,target,hz [gon],v [gon],sd,th\nS1,A,0,100,10,1.5\n", "l.csv", options);
  EXPECT_TRUE(told.warnings.empty()) << told.warnings[0];
  EXPECT_NEAR(value(told, 0, slope_distance), 3.048, 1e-12);
}

TEST(SurveyCsv, AHeightThatOtherRowsHaveIsNotZero) {
  const auto read = [](const std::string& text) { return read_survey_csv(text, "s.csv"); };
  const auto refused = [&](const std::string& text) { return error_of([&] { read(text); }); };
  const std::string head = "station,target,hz [gon],v [gon],sd [m],ih,th\n";
  const std::string gap = refused(head + "S1,K1,0,100,10,1.55,1.5\nS1,A,10,100,10,1.55,\nS1,B,20,100,10,1.55,\n");
  EXPECT_NE(gap.find("s.csv:3:1: found no 'th' of 'A' and 1 more in a column that has it in 1 of 3 rows"),
            std::string::npos)
      << gap;
  EXPECT_NE(refused(head + "S1,A,0,100,10,1.55,0\nS2,A,10,100,10,,0\n").find("no 'ih' at 'S2'"), std::string::npos);
  EXPECT_NE(refused(head + "S1,A,0,100,10,,0\nS1,B,10,100,10,1.55,0\n").find("no 'ih' at 'S1'"), std::string::npos);
  // The first row of a set-up says it for all; a direction alone has no height; a column that is empty is none.
  EXPECT_DOUBLE_EQ(read(head + "S1,A,0,100,10,1.55,0\nS1,B,10,100,10,,0\n").set_ups[0].instrument_height, 1.55);
  EXPECT_EQ(read(head + "S1,A,0,100,10,1.55,1.5\nS1,B,10,,,,\n").observations.size(), 4u);
  const auto empty = read(head + "S1,A,0,100,10,0,\nS1,B,10,100,10,0,\n");
  EXPECT_EQ(empty.observations.size(), 6u);
  ASSERT_EQ(empty.warnings.size(), 1u) << "said, for 0 m is an assumption";
  EXPECT_EQ(empty.warnings[0],
            "the column 'th' is empty in all rows: heights of 0 m are assumed; fill it where they were not");
}

// A word of a distance that does not say which was left out with a warning, and the job went on with angles alone.
TEST(SurveyCsv, ReadingsUnderNamesThatDoNotSayWhichAreRefused) {
  const auto read = [](const std::string& text) { return read_survey_csv(text, "s.csv"); };
  const std::string error =
      error_of([&] { read("Standpunkt;Zielpunkt;Hz [gon];V [gon];Strecke\nS1;A;0,0000;100,0000;12,3456\n"); });
  EXPECT_NE(error.find("'strecke' in a table of sightings"), std::string::npos) << error;
  EXPECT_NE(error.find("slope_distance"), std::string::npos) << error;
  EXPECT_NO_THROW(read("station,target,hz [gon],v [gon],sd,distance\nS1,A,0,100,10.01,10\n"));
  EXPECT_EQ(read("station,target,hz [gon],v [gon],distancia inclinada,pole height\nS1,A,0,100,10.01,1.5\n")
                .observations[2]
                .target_height,
            1.5);
}

// Thousands with a comma beside whole numbers: 1,000 was a metre.
TEST(SurveyCsv, ThousandsAreNotTakenForDecimals) {
  const auto read = [](const std::string& text) { return read_survey_csv(text, "p.csv"); };
  const std::string error = error_of([&] { read("id;E;N;H\nK1;1,000;2,000;100\nK2;1,060;2,005;101\n"); });
  EXPECT_NE(error.find("decimals or thousands"), std::string::npos) << error;
  EXPECT_EQ(point(read("id;E;N;H\nK1;1,000;2,000;100,5\n"), "K1").coordinates, Eigen::Vector3d(1, 2, 100.5));
  EXPECT_EQ(point(read("id;E;N;H\nK1;1,000;2,000;0,250\n"), "K1").coordinates, Eigen::Vector3d(1, 2, 0.25));
  EXPECT_TRUE(read("id;E;N;H\nK1;1,000;2,000;0,250\n").warnings.empty());
  const auto untold = read("id;E;N;H\nK1;1,000;2,000;3,000\n");
  ASSERT_EQ(untold.warnings.size(), 1u);
  EXPECT_NE(untold.warnings[0].find("'1,000' are read with ',' as the decimal separator"), std::string::npos);
}

// Gauss-Krueger: Y is the easting. Read the other way round, two control points and a total station stay "sound".
TEST(SurveyCsv, XAndYAreTheAxesThatTheTableMeans) {
  const auto read = [](const std::string& text) { return read_survey_csv(text, "k.csv"); };
  const auto refused = [&](const std::string& text) { return error_of([&] { read(text); }); };
  for (const char* table : {"Punktnr;Y;X;H\nK1;4500000,000;5300050,000;500,300\n",   // magnitudes and names agree
                            "id,y,x,z\nK1,4500000.000,5300050.000,500.300\n",        // magnitudes alone
                            "Punkt;X;Y;Z\nK1;5300050,000;4500000,000;500,300\n"}) {  // whatever the order
    const auto survey = read(table);
    EXPECT_EQ(point(survey, "K1").coordinates, Eigen::Vector3d(4500000, 5300050, 500.3)) << table;
    ASSERT_EQ(survey.warnings.size(), 1u);
    EXPECT_NE(survey.warnings[0].find("Y = east and X = north"), std::string::npos) << survey.warnings[0];
  }
  const auto local = read("Punktnr;Y;X;H\xC3\xB6he;sigma_y [mm];sigma_x [mm];sigma_z [mm]\nK1;10,5;20,5;3,5;1;2;3\n");
  EXPECT_EQ(point(local, "K1").coordinates, Eigen::Vector3d(10.5, 20.5, 3.5)) << "German names alone";
  ASSERT_EQ(local.coordinates.size(), 1u);
  EXPECT_DOUBLE_EQ(local.coordinates[0].covariance(0, 0), 1e-6) << "sigma_y is that of the easting";
  EXPECT_DOUBLE_EQ(local.coordinates[0].covariance(1, 1), 4e-6);
  const auto english = read("id,x,y,z\nA,1,2,3\n");
  EXPECT_EQ(point(english, "A").coordinates, Eigen::Vector3d(1, 2, 3));
  ASSERT_EQ(english.warnings.size(), 1u) << "a choice is never silent";
  EXPECT_NE(english.warnings[0].find("X = east and Y = north"), std::string::npos) << english.warnings[0];
  EXPECT_EQ(point(read("id,x,y,z\nA,691000,5335000,520\n"), "A").coordinates[0], 691000) << "UTM";
  EXPECT_EQ(point(read("id,x,y,z\nA,2600000,1200000,520\n"), "A").coordinates[0], 2600000) << "LV95";
  for (const char* table : {"id,x,y,z\nK1,5300050,4500000,500\n", "id,x,y,z\nA,5335000,691000,520\n",
                            "Punktnr;Y;X;H\nK1;5300050;4500000;500\n", "Punkt;X;Y;Z\nA;1;2;3\n", "id,y,x,z\nA,1,2,3\n"})
    EXPECT_NE(refused(table).find("E and N, or Rechtswert and Hochwert"), std::string::npos) << table;
}

TEST(SurveyCsv, AStandardDeviationIsANumberAboveZero) {
  for (const char* sigma : {"-1", "0", "nan", "NaN", "inf", "abc", "-0.5"}) {
    const auto survey = read_survey_csv(
        "id,e,n,h,sigma_e_mm,sigma_n_mm,sigma_h_mm\nA,1,2,3,1,1,1\nG1,4,5,6," + std::string(sigma) + ",1,1\n", "k.csv");
    EXPECT_EQ(survey.coordinates.size(), 1u) << sigma;
    ASSERT_EQ(survey.skipped.size(), 1u) << sigma;
    EXPECT_EQ(survey.skipped[0].source.line, 3);
    EXPECT_EQ(survey.skipped[0].found, "'" + std::string(sigma) + "'");
  }
}

TEST(SurveyCsv, SpreadsheetsSepLineIsNoHeader) {
  const auto survey = read_survey_csv("sep=;\r\nid;e;n;h\r\nA;1,5;2,0;3,0\r\n", "sep.csv");
  EXPECT_EQ(point(survey, "A").coordinates, Eigen::Vector3d(1.5, 2, 3));
  EXPECT_TRUE(survey.warnings.empty());
  EXPECT_TRUE(survey.skipped.empty());
}

TEST(SurveyCsv, TableWithoutHeaderIsPenzdWithAWarningOrAsTold) {
  const auto survey = read_survey_csv(fixture("points_no_header.txt"), "p.txt");
  EXPECT_EQ(point(survey, "P1").coordinates, Eigen::Vector3d(1000.125, 2000.5, 10.25));
  EXPECT_EQ(point(survey, "P1").description, "PLATE");
  EXPECT_EQ(survey.skipped.size(), 1u) << "'nan' is no number";
  ASSERT_EQ(survey.warnings.size(), 1u);
  const auto swapped = read_survey_csv(fixture("points_no_header.txt"), "p.txt", {.columns = "PNEZC"});
  EXPECT_EQ(point(swapped, "P1").coordinates, Eigen::Vector3d(2000.5, 1000.125, 10.25));
  EXPECT_EQ(point(swapped, "P1").code, "PLATE");
  EXPECT_TRUE(swapped.warnings.empty());
  const auto named =
      read_survey_csv("S1 A 100 100 12,5\n", "s.txt", {.columns = "station,target,hz,v,sd", .angle_unit = "gon"});
  EXPECT_DOUBLE_EQ(value(named, 0, slope_distance), 12.5);
  EXPECT_NE(error_of([] { read_survey_csv("P 1 2", "p.txt", {.columns = "PQ"}); }).find("'Q'"), std::string::npos);
}

/// Ninety gon taken for ninety degrees is a point 15 m too high. The readings tell, or nobody does.
TEST(SurveyCsv, AnglesWithoutAUnitAreToldByTheReadingsOrRefused) {
  const std::string header = "from,to,hz,v,sd\n";
  const auto unit_of = [&](const std::string& rows) -> std::string {
    try {
      const auto s = read_survey_csv(header + rows, "u.csv");
      return s.warnings.at(0);
    } catch (const SurveyReadError& error) {
      return error.what();
    }
  };
  const auto is = [&](const std::string& rows, const std::string& unit) {
    const std::string said = unit_of(rows);
    EXPECT_NE(said.find(unit + " is taken"), std::string::npos) << rows << said;
  };
  const auto refused = [&](const std::string& rows) {
    const std::string said = unit_of(rows);
    EXPECT_NE(said.find("found angles without a unit (direction, zenith)"), std::string::npos) << rows << said;
  };
  refused("S1,P1,0.0000,90.0000,100.000\nS1,P2,45.3000,89.0000,50.000\n");
  is("S1,P1,0.0000,99.0000,100.000\nS1,P2,395.3000,98.0000,50.000\n", "gon");
  is("S1,P1,10.0010,85.0020,100.000\nS1,P1,210.0000,315.0000,100.000\n", "gon");
  is("S1,P1,10.0010,85.7320,100.000\nS1,P1,190.0000,274.2680,100.000\n", "deg");
  is("S1,P1,10.0010,85.4359,100.000\nS1,P1,190.0000,274.1601,100.000\n", "dms");
  is("A,B,220.6938,89.4271,100.005\nB,A,172.8768,90.5729,100.005\n", "deg");
  is("A,B,220.6938,99.4271,100.005\nB,A,172.8768,100.5729,100.005\n", "gon");
  // 60 + 120 closes in decimal degrees and in degrees, minutes, seconds: in whole degrees that is the same.
  refused("A,B,20.3000,60.0000,100.005\nB,A,172.0000,120.0000,100.005\n");
  is("A,B,20.0000,60.0000,100.005\nB,A,172.0000,120.0000,100.005\n", "deg");
  is("S1,A,90,95,20\nS1,A,270,265,20\nS1,B,120,92,30\nS1,B,300,268,30\n", "deg");
  // Heights of instrument and target without a distance: reciprocal angles need not close.
  const std::string heights = "from,to,v,ih,th\nA,B,89,1.5,0\nB,A,91,1.5,0\n";
  EXPECT_NE(error_of([&] { read_survey_csv(heights, "u.csv"); }).find("angles without a unit"), std::string::npos);
  EXPECT_NEAR(value(read_survey_csv(header + "S1,P1,0,90,100\n", "u.csv", {.angle_unit = "deg"}), 0, zenith_angle),
              90 * kDegree, 1e-15);
}

TEST(SurveyCsv, DegreesMinutesAndSecondsMayStandApart) {
  for (const std::string angle : {"45-30-36", "45:30:36", "45\u00B030'36\"\"", "45-30-36.0"}) {
    const std::string quoted = angle.find('"') == std::string::npos ? angle : "\"" + angle + "\"";
    for (const std::string header : {"hz_dms,v_dms", "hz,v"}) {
      const auto s = read_survey_csv("from,to," + header + ",sd\nA,B," + quoted + ",90-00-00,100\n", "d.csv");
      EXPECT_NEAR(value(s, 0, direction), 45.51 * kDegree, 1e-12) << angle << header;
      EXPECT_NEAR(value(s, 0, zenith_angle), 90 * kDegree, 1e-12);
    }
  }
  EXPECT_EQ(read_survey_csv("from,to,hz_dms,sd\nA,B,45-61-36,100\nA,C,1-0-0,10\n", "d.csv").skipped.size(), 1u);
}

/// The spreadsheet has thrown the digits away: 10 km is no coordinate, and two points would become one.
TEST(SurveyCsv, ANumberThatASpreadsheetRoundedIsRefused) {
  const auto s =
      read_survey_csv("id;E;N;H\nA;5,12E+05;5,41E+06;100,5\nB;512000,25;5410000,5;1,005E+02\nC;1;2;3\n", "r.csv");
  EXPECT_TRUE(skipped(s, 2, 3, "a spreadsheet rounded this value"));
  EXPECT_TRUE(skipped(s, 3, 23, "a spreadsheet rounded this value"));
  EXPECT_TRUE(s.coordinates.empty());
  const auto whole = read_survey_csv("id;E;N;H\nA;5,1234567E+05;5,40000E1;1,5e-1\nB;1;2;3\n", "r.csv");
  EXPECT_EQ(point(whole, "A").coordinates, Eigen::Vector3d(512345.67, 54, 0.15)) << whole.skipped.size();
}

/// A field book that nobody here reads has commas and numbers too; as points it would be nonsense without a word.
TEST(SurveyCsv, OtherTextsWithNumbersAreNoPoints) {
  std::string book, list = "id,e,n\n";
  for (int i = 0; i < 12; ++i) {
    book += "F,P" + std::to_string(i) + ",17857,6528,42.97\nB,DEFAULT,------,0.0\n";
    list += "SS," + std::to_string(10 * i) + "," + std::to_string(20 * i) + "\n";
  }
  try {
    read_survey_csv(book, "0407A2.mes");
    ADD_FAILURE() << "was read";
  } catch (const SurveyReadError& error) {
    EXPECT_NE(error.found.find("24 of 24 rows that are no points"), std::string::npos) << error.what();
  }
  try {
    read_survey_csv(list, "raw.csv");
    ADD_FAILURE() << "was read";
  } catch (const SurveyReadError& error) {
    EXPECT_NE(error.found.find("11 of 12 rows with a name that a row before has at another place"), std::string::npos)
        << error.what();
  }
  std::string titled = "Job 7\nmeasured in May\n";
  for (int i = 0; i < 12; ++i) titled += "P" + std::to_string(i) + ",1,2,3\n";
  EXPECT_EQ(read_survey_csv(titled, "p.csv").points.size(), 12u) << "two lines of title are told, not refused";
}

/// Tables as others publish them: read as name, E, N, H they give numbers that look right.
TEST(SurveyCsv, TablesWhoseColumnsAreOthersAreRefused) {
  const auto message = [](const char* text) { return error_of([&] { read_survey_csv(text, "p.csv"); }); };
  const char* zone = "1770,56,386930.017,7327717.501\nBDMR,55,753485.014,7176122.976\n";
  EXPECT_NE(message(zone).find("p.csv:1:1: found a height of 7327717.501 m"), std::string::npos) << message(zone);
  EXPECT_NE(message("STR1,-4467103.2,2683039.5,-3666948.8\n").find("geocentric"), std::string::npos);
  EXPECT_NE(message("id;E;N;H\nA;1200;3400;403486\nB;1300;3400;403268\n").find("in millimetres"), std::string::npos);
  const char* no_names = "650544.828 237514.298 104.215\n650552.086 237521.011 104.129\n";
  EXPECT_NE(message(no_names).find("numbers where the names should be ('650544.828')"), std::string::npos);
  const char* degrees = "1770,-24.093248960,151.531318800\nBDMR,-25.303769190,149.311921510\n";
  EXPECT_NE(message(degrees).find("latitudes and longitudes"), std::string::npos);
  EXPECT_NE(message("point name,latitude,longitude\nt1,34.40,-119.87\n").find("latitudes and longitudes"),
            std::string::npos);
  // What is named is taken at its word.
  SurveyCsvOptions named;
  named.columns = "PENZD";
  EXPECT_EQ(read_survey_csv(no_names, "p.csv", named).points.size(), 2u);
  EXPECT_EQ(read_survey_csv("1.1,12.5,3.25,7.0\n1.2,14.5,3.25,7.0\n", "p.csv").points.size(), 2u) << "floor.number";
  EXPECT_EQ(read_survey_csv("A,12.512,3.251\nB,14.512,3.250\n", "p.csv").points.size(), 2u) << "a plan in millimetres";
}

TEST(SurveyCsv, HeadersInOtherLanguages) {
  for (const char* header : {"Matricule;Est;Nord;Altitude", "Punto;Este;Norte;Cota", "Nome;Est;Nord;Quota"}) {
    const auto s = read_survey_csv(std::string(header) + "\nA1;102,500;203,250;12,125\n", "p.csv");
    ASSERT_EQ(s.points.size(), 1u) << header;
    EXPECT_EQ(s.points[0].id, "A1");
    EXPECT_EQ(s.points[0].coordinates, Eigen::Vector3d(102.5, 203.25, 12.125)) << header;
  }
  const auto s =
      read_survey_csv("# Id, X, Y, Z, sigmaX, sigmaY, sigmaZ\n1, 89.1, 180.0, 148.2, 0.005, 0.006, 0.007\n", "p.csv");
  ASSERT_EQ(s.coordinates.size(), 1u);
  EXPECT_NEAR(s.coordinates[0].covariance(1, 1), 0.006 * 0.006, 1e-15);
}

TEST(SurveyCsv, ABlankSeparatesNothingWhereEveryRowHasTabs) {
  const auto s = read_survey_csv("Point ID\tEast\tNorth\tElev\nPier 1\t1\t2\t3\nPier 2\t4\t5\t6\n", "p.txt");
  EXPECT_EQ(point(s, "Pier 2").coordinates, Eigen::Vector3d(4, 5, 6));
}

TEST(SurveyCsv, ReadsSightingsWithUnitsInTheHeader) {
  const auto survey = read_survey_csv(fixture("sightings.csv"), "s.csv");
  ASSERT_EQ(survey.set_ups.size(), 2u);
  EXPECT_DOUBLE_EQ(value(survey, 0, direction), 45.5 * kDegree);
  EXPECT_DOUBLE_EQ(value(survey, 0, slope_distance), 12.345);
  EXPECT_EQ(observation(survey, 1, zenith_angle).face, 2);
  EXPECT_DOUBLE_EQ(observation(survey, 2, direction).instrument_height, 1.55);
  EXPECT_TRUE(skipped(survey, 5, 13, "not negative"));
  EXPECT_TRUE(skipped(survey, 6, 24, "face 1 or 2"));
  EXPECT_DOUBLE_EQ(value(survey, 3, slope_distance), 5.0);
}

TEST(SurveyCsv, ReadsCoordinatesOfEachSetUpWithCovariance) {
  ASSERT_TRUE(has_setup_coordinates_header(fixture("setup_coordinates.csv")));
  EXPECT_FALSE(has_setup_coordinates_header(fixture("points_penzd.csv")));
  EXPECT_FALSE(has_setup_coordinates_header(fixture("sightings.csv")));
  const auto survey = read_setup_coordinates(fixture("setup_coordinates.csv"), "c.csv");
  ASSERT_EQ(survey.local_coordinates.size(), 2u);
  const LocalCoordinate& first = survey.local_coordinates[0];
  EXPECT_EQ(first.position, Eigen::Vector3d(1.5, 12.25, 0.5));
  EXPECT_DOUBLE_EQ(first.covariance(1, 0), 2e-7);
  EXPECT_DOUBLE_EQ(first.target_height, 0.1);
  EXPECT_TRUE(skipped(survey, 3, 21, "positive definite"));
  EXPECT_TRUE(std::isnan(survey.local_coordinates[1].covariance(0, 0)));
  EXPECT_EQ(survey.set_ups[1].station, "S2");
  EXPECT_TRUE(skipped(survey, 5, 1, "x, y and z") || skipped(survey, 5, 6, "x, y and z"));
}

TEST(SurveyCsv, UnknownUnitsAndTablesAreErrors) {
  EXPECT_NE(error_of([] {
              read_survey_csv("station,target,hz [parsec]\nA,B,1\n", "u.csv");
            }).find("u.csv:1:1: found the unit 'parsec'"),
            std::string::npos);
  EXPECT_NE(error_of([] { read_survey_csv("hello\n", "u.csv"); }).find("formats understood"), std::string::npos);
  EXPECT_NE(error_of([] { read_survey_csv("", "u.csv"); }).find("u.csv"), std::string::npos);
  EXPECT_NE(error_of([] { read_setup_coordinates("a,b\n1,2\n", "u.csv"); }).find("set_up"), std::string::npos);
}

TEST(SurveyCsvWriter, AnySurveyReadsBackTheSame) {
  for (unsigned long long seed = 1; seed <= 20; ++seed) {
    SurveyObservations survey = random_survey(seed);
    survey.observations[3].sigma = 1e-5;
    survey.observations[4].corrections = {"ppm 12", "prism constant -34.4 mm"};
    survey.points[0].roles = {CoordinateRole::fixed, CoordinateRole::constrained, CoordinateRole::unused};
    survey.points[1].description = "quoted \"text\", with; all";
    CoordinateGroup control;
    control.components = {{survey.points[0].id, 2}};
    control.values = Eigen::VectorXd::Constant(1, 12.5);
    control.covariance = Eigen::MatrixXd::Constant(1, 1, 1e-6);
    control.is_control = true;
    survey.coordinates.push_back(control);
    LocalCoordinate local;
    local.set_up = 1;
    local.point = survey.points[4].id;
    local.position = {1, 2, 3};
    local.covariance = Eigen::Matrix3d::Identity() * 1e-6;
    survey.local_coordinates.push_back(local);
    const std::string text = write_survey_csv(survey);
    const auto again = read_survey_csv(text, "again.csv");
    EXPECT_TRUE(again.skipped.empty()) << again.skipped.front().expected << again.skipped.front().found;
    for (std::size_t i = 0; i < survey.observations.size(); ++i)
      survey.observations[i].set_number = again.observations.at(i).set_number;
    expect_same(survey, again, 1e-13);
    EXPECT_NEAR(again.observations[3].sigma, 1e-5, 1e-18);
    EXPECT_EQ(again.observations[4].corrections, survey.observations[4].corrections);
    ASSERT_EQ(again.points.size(), survey.points.size());
    for (std::size_t i = 0; i < survey.points.size(); ++i) {
      EXPECT_EQ(again.points[i].id, survey.points[i].id);
      EXPECT_EQ(again.points[i].roles, survey.points[i].roles);
      EXPECT_EQ(again.points[i].description, survey.points[i].description);
      for (int axis = 0; axis < 3; ++axis)
        EXPECT_TRUE(again.points[i].coordinates[axis] == survey.points[i].coordinates[axis] ||
                    std::isnan(survey.points[i].coordinates[axis]));
    }
    ASSERT_EQ(again.coordinates.size(), 1u);
    EXPECT_EQ(again.coordinates[0].components[0].axis, 2);
    EXPECT_EQ(again.coordinates[0].covariance, control.covariance);
    ASSERT_EQ(again.local_coordinates.size(), 1u);
    EXPECT_EQ(again.local_coordinates[0].covariance, local.covariance);
    EXPECT_EQ(again.local_coordinates[0].set_up, 1);
  }
}

TEST(SurveyCsv, ANameThatBeginsLikeACommentIsAskedFor) {
  const auto survey =
      read_survey_csv("id,E,N,H\n#A1,1,2,3\n# A2,1,2,3\n%A3,4,5,6\n//A4,7,8,9\n\"#A5\",1,1,1\nA6,2,2,2\n", "p.csv");
  ASSERT_EQ(survey.skipped.size(), 3u) << "a blank behind the mark makes a comment";
  EXPECT_TRUE(skipped(survey, 2, 1, "put it in quotes"));
  EXPECT_TRUE(skipped(survey, 4, 1, "put it in quotes"));
  EXPECT_TRUE(skipped(survey, 5, 1, "put it in quotes"));
  EXPECT_EQ(survey.points.size(), 2u);
  EXPECT_EQ(survey.points[0].id, "#A5");
}

}  // namespace test_survey_csv
}  // namespace plumbline::survey
