// Layouts out as CSV and DXF, staked points back in.
#include <gtest/gtest.h>
#include <unistd.h>

#include <cstdio>
#include <filesystem>
#include <fstream>
#include <nlohmann/json.hpp>
#include <set>

#include "loop/job/job.hpp"
#include "loop/job/layout_files.hpp"
#include "released.hpp"
#include "released_far_off.hpp"
#include "test_support.hpp"

namespace plumbline::loop {
namespace test_layout_files {

using test::ReleasedFarOff;

TEST(LayoutFiles, AreReadBackAsTheyWereWritten) {
  const ReleasedFarOff r;
  const auto points = layout_points(make_job(r.plan, r.state, 0, "", ""));
  ASSERT_FALSE(points.empty());
  for (const LayoutFormat format : {LayoutFormat::hilti, LayoutFormat::trimble, LayoutFormat::leica}) {
    const ActualsT back = read_staked(layout_csv(points, format), format, "staked.csv");
    ASSERT_EQ(back.items.size(), points.size());
    EXPECT_TRUE(back.refused.empty());
    for (std::size_t i = 0; i < points.size(); ++i) {
      EXPECT_EQ(back.items[i]->item, points[i].name);
      EXPECT_LT((back.items[i]->measured - points[i].position).cwiseAbs().maxCoeff(), 5.1e-5);
    }
  }
}

/// A tool stakes whatever is in its file: a bracket that waits or stands already would be set once more.
TEST(LayoutFiles, HoldWhatTheJobSetsAndNothingElse) {
  ReleasedFarOff r;
  const auto named = [](const std::vector<LayoutPoint>& points) {
    std::set<std::string> names;
    for (const LayoutPoint& point : points) names.insert(point.name);
    return names;
  };
  std::string waits, stands;
  for (auto& item : r.state.items) {
    if (item->kind != "bracket" || item->status != ItemStatus::released) continue;
    if (waits.empty())
      waits = item->id, item->status = ItemStatus::planned;
    else if (stands.empty())
      stands = item->id, item->status = ItemStatus::verified;
  }
  ASSERT_FALSE(stands.empty());
  const Job job = make_job(r.plan, r.state, 0, "", "");
  std::set<std::string> of_job;
  for (const JobItem& item : job.items) of_job.insert(item.id);
  const auto points = layout_points(job);
  ASSERT_FALSE(points.empty());
  EXPECT_EQ(named(points), of_job);
  EXPECT_LT(points.size(), r.plan.brackets.size());
  EXPECT_FALSE(named(points).contains(waits) || named(points).contains(stands));
  for (std::size_t i = 0; i < points.size(); ++i)
    EXPECT_LT((points[i].position - job.items[i].target - job.origin).norm(), 1e-9) << "the place that the job says";
  const std::string dxf = layout_dxf(r.plan, job, {});
  EXPECT_EQ(dxf.find("\n" + waits + "\n"), std::string::npos);
  EXPECT_EQ(dxf.find("\n" + stands + "\n"), std::string::npos);
  EXPECT_NE(dxf.find("\n" + points[0].name + "\n"), std::string::npos);
  // Of two floors the upper one's turn has not come.
  std::size_t outlines = 0;
  for (std::size_t at = 0; (at = dxf.find("POLYLINE", at)) != std::string::npos; ++at) ++outlines;
  EXPECT_EQ(outlines, 2u);
  EXPECT_TRUE(layout_points(make_job(r.plan, r.state, 2, "", "")).empty());
}

TEST(LayoutFiles, AHeadSaysWhichColumnIsWhat) {
  const auto place = [](const std::string& text, LayoutFormat format) {
    const ActualsT back = read_staked(text, format, "staked.csv");
    return back.items.size() == 1 ? back.items[0]->measured : Eigen::Vector3d::Zero().eval();
  };
  const Eigen::Vector3d p(401.25, 77.5, 12.125);
  EXPECT_EQ(place("A;401,25;77,5;12,125\n", LayoutFormat::hilti), p);
  EXPECT_EQ(place("A,77.5,401.25,12.125,GO\n", LayoutFormat::trimble), p);
  EXPECT_EQ(place("Name,Easting,Northing,Elev\nA,401.25,77.5,12.125\n", LayoutFormat::trimble), p);
  EXPECT_EQ(place("PtID;Code;N [m];E [m];Höhe\nA;x;77.5;401.25;12.125\n", LayoutFormat::hilti), p);
  // What X and Y are nobody says: the tool's own order counts.
  EXPECT_EQ(place("PtID,X,Y,Z\nA,401.25,77.5,12.125\n", LayoutFormat::leica), p);
  EXPECT_EQ(read_staked("PtID,E,N,H,Timestamp\nA,1,2,3,2026-05-02T08:00:00Z\n", LayoutFormat::leica, "s").items[0]->at,
            "2026-05-02T08:00:00Z");
  EXPECT_THROW(read_staked("PtID;E [mm];N [mm];H [mm]\nA;1;2;3\n", LayoutFormat::hilti, "s"), std::runtime_error);
  EXPECT_THROW(read_staked("Name,Northing (usft),Easting (usft),Elev (usft)\n", LayoutFormat::trimble, "s"),
               std::runtime_error);
  // "Ortho" is no name of a height that is known: then north and east would be taken for each other.
  EXPECT_THROW(read_staked("PtID;N;E;Ortho\nA;77.5;401.25;12.125\n", LayoutFormat::hilti, "s"), std::runtime_error);
  EXPECT_EQ(place("PtID;E;N;Ortho\nA;401.25;77.5;12.125\n", LayoutFormat::hilti), p);
}

TEST(LayoutFiles, ColumnsThatNobodyReadsAreNamed) {
  const auto ignored = [](const std::string& text) {
    const ActualsT back = read_staked(text, LayoutFormat::hilti, "s.csv");
    EXPECT_EQ(back.items.size(), 1U);
    std::string words;
    for (const std::string& line : back.ignored) words += line + "\n";
    return words;
  };
  EXPECT_EQ(ignored("PtID;E;N;H;Code;Timestamp\nA;1;2;3;x;\n"), "");
  EXPECT_EQ(ignored("A;1;2;3\n"), "");
  EXPECT_EQ(ignored("PtID;E;N;H;Remark;Setting\nA;1;2;3;bolt stuck;0.004\n"),
            "s.csv: 'Remark' and 'Setting' are not read\n");
  EXPECT_NE(ignored("PtID;Grid E;Grid N;Grid H\nA;1;2;3\n")
                .find("what its column 'Grid E' is nobody knows here; it is taken for the easting"),
            std::string::npos);
  // Where it was to be and where it is: the first would be an echo of the design.
  EXPECT_THROW(ignored("PtID;E;N;H;East;North;Height\nA;1;2;3;4;5;6\n"), std::runtime_error);
}

/// Machine control exports put comments before their head: easting and northing were exchanged then.
TEST(LayoutFiles, AHeadMayStandBehindComments) {
  const std::string begin = "# Export, Trimble compatible CSV\n# Format: Name,Easting,Northing,Elevation,Code\n",
                    date = "# Points: 1\n\n",
                    points = "Name,Easting,Northing,Elevation,Code,Description\nA,401.25,77.5,12.125,GO,\n\n# End\n";
  const ActualsT back = read_staked(begin + "# Units: metres\n" + date + points, LayoutFormat::trimble, "staked.csv");
  ASSERT_EQ(back.items.size(), 1u);
  EXPECT_TRUE(back.refused.empty());
  EXPECT_EQ(back.items[0]->measured, Eigen::Vector3d(401.25, 77.5, 12.125));
  EXPECT_EQ(read_staked("# Topcon\nPoint ID,E,N,EL,Code\nA,1,2,3,\n", LayoutFormat::trimble, "s").items.at(0)->measured,
            Eigen::Vector3d(1, 2, 3));
  try {
    read_staked(begin + "# Units: US survey feet\n" + date + points, LayoutFormat::trimble, "staked.csv");
    ADD_FAILURE() << "feet are taken for metres";
  } catch (const std::runtime_error& error) {
    EXPECT_NE(std::string(error.what()).find("staked.csv:3: its units are 'us survey feet'"), std::string::npos)
        << error.what();
  }
}

TEST(LayoutFiles, UnitsAreReadHoweverACommentSaysThem) {
  const auto read = [](const std::string& comment) {
    return read_staked("# " + comment + "\nName,Easting,Northing,Elevation,Code\nA,1,2,3,GO\n", LayoutFormat::trimble,
                       "staked.csv")
        .items.size();
  };
  for (const char* metres : {"Units: [m]", "Units = metres", "units (m)", "Total station unit: TS16", "community: x",
                             "coordinates in units of meters"})
    EXPECT_EQ(read(metres), 1u) << metres;
  for (const char* others :
       {"Units = feet", "units feet", "Units [ft]", "Coordinate units: US survey feet", "unit mm", "Units: cubits"})
    EXPECT_THROW(read(others), std::runtime_error) << others;
  EXPECT_EQ(read(std::string(1000000, 'x') + " units: feet"), 1u) << "a line of any length is read";
}

TEST(LayoutFiles, AFirstPointThatCannotBeReadIsNoHead) {
  const ActualsT back = read_staked("A;401.25;77.5;\nB;401.25;77.5;12.125\n", LayoutFormat::hilti, "staked.csv");
  ASSERT_EQ(back.items.size(), 1u);
  EXPECT_EQ(back.refused, std::vector<std::string>{"staked.csv:1: the coordinates of 'A' are no numbers"});
}

TEST(LayoutFiles, WhatIsNoPointIsRefusedWithItsLine) {
  const ActualsT back = read_staked("PtID;E;N;H\nF01-C01-R1;1.0;2.0;3.0\nx;1;2\ny;a;b;c\nF01-C01-R1;1;2;3\n",
                                    LayoutFormat::hilti, "staked.csv");
  EXPECT_EQ(back.items.size(), 1u);
  EXPECT_EQ(back.refused,
            (std::vector<std::string>{"staked.csv:3: found 3 columns, expected a name and three coordinates",
                                      "staked.csv:4: the coordinates of 'y' are no numbers",
                                      "staked.csv:5: 'F01-C01-R1' stands in line 2 too, 0.0 mm from here; line 2 is "
                                      "taken, they say the same"}));
}

/// Which of two rows is the correction nobody can tell but by a date.
TEST(LayoutFiles, OfAPointThatWasStakedTwiceTheLastCountsOrNone) {
  const auto read = [](const std::string& rows) {
    return read_staked("PtID;E;N;H;Timestamp\n" + rows, LayoutFormat::hilti, "s.csv");
  };
  const std::string first = "A;3.0119;0;1;2026-05-05T07:00:00Z\n", second = "A;3.0019;0;1;2026-05-05T09:00:00+02:00\n",
                    third = "A;3.0020;0;1;2026-05-05T08:00:00Z\n", other = "B;1;2;3;2026-05-05T07:00:00Z\n";
  for (const std::string& rows : {first + other + third, third + first + other}) {
    const ActualsT back = read(rows);
    ASSERT_EQ(back.items.size(), 2u);
    const ActualT& a = *back.items[back.items[0]->item == "A" ? 0 : 1];
    EXPECT_EQ(a.measured.x(), 3.0020) << rows;
    ASSERT_EQ(back.refused.size(), 1u);
    EXPECT_NE(back.refused[0].find("9.9 mm from here; line " + a.source.substr(6) + " is taken, the last by its date"),
              std::string::npos)
        << back.refused[0];
  }
  for (const std::string& rows :
       {first + second + other, std::string("A;3.0119;0;1\nA;3.0019;0;1\nB;1;2;3\n"),
        std::string("A;3.0119;0;1;2026-05-05T07:00:00Z\nA;3.0019;0;1;05.05.2026 09:00\nB;1;2;3\n")}) {
    const ActualsT back = read(rows);
    ASSERT_EQ(back.items.size(), 1u) << rows;
    EXPECT_EQ(back.items[0]->item, "B");
    EXPECT_EQ(back.refused, std::vector<std::string>{"s.csv:3: 'A' stands in line 2 too, 10.0 mm from here; no date "
                                                     "says which is the last one, and none is taken: keep that row "
                                                     "alone"});
  }
}

/// Layout tools write where a point was to be beside where it is.
TEST(LayoutFiles, WhereAPointWasToBeIsNotWhereItIs) {
  const Eigen::Vector3d staked(401.25, 77.5, 12.125);
  const auto read = [](const std::string& head, const std::string& row) {
    return read_staked(head + "\nA;" + row + "\n", LayoutFormat::hilti, "s.csv");
  };
  for (const char* head : {"PtID;Design E;Design N;Design H;Staked E;Staked N;Staked H",
                           "PtID;E;N;H;E staked;N staked;H staked", "PtID;E_soll;N_soll;H_soll;E_ist;N_ist;H_ist [m]",
                           "Name;Design Easting;Design Northing;Design Elevation;As-staked Easting;As-staked "
                           "Northing;As-staked Elevation"}) {
    const ActualsT back = read(head, "1;2;3;401.25;77.5;12.125");
    ASSERT_EQ(back.items.size(), 1u) << head;
    EXPECT_EQ(back.items[0]->measured, staked) << head;
    EXPECT_EQ(back.ignored.size(), 1u) << head;
  }
  EXPECT_EQ(
      read("PtID;Design E;Design N;Design H;E;N;H;dE;Delta N", "1;2;3;401.25;77.5;12.125;0;0").items.at(0)->measured,
      staked);
  const auto fault = [&](const std::string& head) {
    try {
      read(head, "1;2;3;4;5;6");
    } catch (const std::runtime_error& error) {
      return std::string(error.what());
    }
    return std::string();
  };
  EXPECT_NE(fault("PtID;Design E;Design N;Design H").find("names where points were to be, and not where they were"),
            std::string::npos);
  EXPECT_NE(fault("PtID;E;N;H;Staked E;Staked N").find("names some coordinates of where they were staked"),
            std::string::npos);
  EXPECT_NE(fault("PtID;Grid E;Grid N;Grid H;Local E;Local N;Local H").find("'Grid E' and 'Local E' say the same"),
            std::string::npos);
  EXPECT_EQ(fault("PtID;E;N;H;Target Height;Instrument Height"), "");
}

TEST(LayoutFiles, ANameWithASeparatorIsRefused) {
  EXPECT_THROW(layout_csv({{"a;b", {0, 0, 0}, "GO"}}, LayoutFormat::hilti), std::runtime_error);
}

TEST(LayoutFiles, TheDrawingHasALayerForEachGate) {
  const ReleasedFarOff r;
  const std::string dxf = layout_dxf(r.plan, make_job(r.plan, r.state, 0, "", ""), {{"CP1", {1, 2, 3}, "control"}});
  for (const char* layer : {"BRACKET_GO", "PANEL_GO", "CONTROL"})
    EXPECT_NE(dxf.find(layer), std::string::npos) << layer;
  EXPECT_NE(dxf.find("AC1009"), std::string::npos);
}

/// What a command prints; empty if it fails.
std::string printed(const std::string& command) {
  std::string text;
  std::FILE* pipe = popen(command.c_str(), "r");
  char buffer[4096];
  for (std::size_t n; pipe && (n = std::fread(buffer, 1, sizeof buffer, pipe)) > 0;) text.append(buffer, n);
  return pipe && pclose(pipe) == 0 ? text : std::string();
}

/// GDAL's reader of DXF, which is none of ours: layers, places to a tenth of a millimetre, closed outlines.
TEST(LayoutFiles, AnotherProgramOpensTheDrawing) {
  if (printed("ogrinfo --version 2> /dev/null").empty()) GTEST_SKIP() << "ogrinfo (gdal-bin) is not installed";
  const ReleasedFarOff r;
  const std::string path =
      (std::filesystem::temp_directory_path() / ("plumbline_layout_" + std::to_string(getpid()) + ".dxf")).string();
  std::ofstream(path) << layout_dxf(r.plan, make_job(r.plan, r.state, 0, "", ""),
                                    {{"CP1", {350001.1234, 5800002.5678, 103.9}, "control"}});
  const std::string told = printed("ogrinfo -al '" + path + "' 2>&1");
  std::filesystem::remove(path);
  EXPECT_NE(told.find("Layer (String) = CONTROL"), std::string::npos) << told;
  EXPECT_NE(told.find("POINT Z (350001.1234 5800002.5678 103.9)"), std::string::npos) << told;
  std::size_t panels = 0, brackets = 0;
  for (std::size_t at = 0; (at = told.find("Layer (String) = PANEL_GO", at)) != std::string::npos; ++at) ++panels;
  for (std::size_t at = 0; (at = told.find("Layer (String) = BRACKET_GO", at)) != std::string::npos; ++at) ++brackets;
  EXPECT_EQ(panels, 2U) << told;  // of the lower floor
  EXPECT_GE(brackets, layout_points(make_job(r.plan, r.state, 0, "", "")).size()) << told;
  // Four corners and the first again.
  const auto line = told.find("LINESTRING Z (");
  ASSERT_NE(line, std::string::npos) << told;
  const std::string outline = told.substr(line, told.find(')', line) - line);
  EXPECT_EQ(std::count(outline.begin(), outline.end(), ','), 4) << outline;
}

/// A reader in another language that audits what it opens; CAD programs look at layers as it does.
TEST(LayoutFiles, EzdxfFindsTheLayersAndNothingToMend) {
  if (printed("/usr/bin/python3 -c 'import ezdxf; print(1)' 2> /dev/null").empty())
    GTEST_SKIP() << "ezdxf (python3-ezdxf) is not installed";
  const ReleasedFarOff r;
  const Job job = make_job(r.plan, r.state, 0, "", "");
  const std::string path =
      (std::filesystem::temp_directory_path() / ("plumbline_ezdxf_" + std::to_string(getpid()) + ".dxf")).string();
  std::ofstream(path) << layout_dxf(r.plan, job, {{"CP1", {350001.1234, 5800002.5678, 103.9}, "control"}});
  const std::string told =
      printed("/usr/bin/python3 -c \"import ezdxf, sys\nd = ezdxf.readfile('" + path + "')\na = d.audit()\n" +
              "print(d.dxfversion, len(a.errors), len(a.fixes))\n"
              "print(*sorted(l.dxf.name for l in d.layers if l.dxf.name not in ('0', 'Defpoints')))\n"
              "for e in d.modelspace():\n"
              "  if e.dxftype() == 'POINT': print(e.dxf.layer, *e.dxf.location)\n"
              "  if e.dxftype() == 'POLYLINE': print(e.dxf.layer, e.is_3d_polyline, e.is_closed, len(e))\n\"");
  std::filesystem::remove(path);
  EXPECT_EQ(told.find("AC1009 0 0\nBRACKET_GO CONTROL PANEL_GO\n"), 0u) << told;
  EXPECT_NE(told.find("\nCONTROL 350001.1234 5800002.5678 103.9\n"), std::string::npos) << told;
  EXPECT_NE(told.find("\nPANEL_GO True True 4\n"), std::string::npos) << told;
  std::size_t brackets = 0;
  for (std::size_t at = 0; (at = told.find("\nBRACKET_GO ", at)) != std::string::npos; ++at) ++brackets;
  EXPECT_EQ(brackets, layout_points(job).size() + 1) << told;  // and in the list of layers
}

}  // namespace test_layout_files
}  // namespace plumbline::loop
