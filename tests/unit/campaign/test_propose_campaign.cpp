// A campaign.yaml for a folder as a German site hands it over: two cameras, Excel's tables, umlauts, a protocol.
#include <gtest/gtest.h>

#include "propose_campaign.hpp"
#include "test_support.hpp"

namespace plumbline::campaign {
namespace test_propose_campaign {

namespace fs = std::filesystem;

class Folder : public testing::Test {
 protected:
  void write(const std::string& name, const std::string& text) {
    fs::create_directories((folder_.path() / name).parent_path());
    std::ofstream(folder_.path() / name, std::ios::binary) << text;
    names_.push_back(name);
  }
  Proposal propose() const { return propose_campaign(folder_.path(), names_); }
  test::TemporaryFolder folder_;
  std::vector<std::string> names_;
};

std::string camera(const std::string& id, int width, int height) {
  return "plumbline_camera: 1\nid: " + id + "\nwidth: " + std::to_string(width) +
         "\nheight: " + std::to_string(height) +
         "\npixel_origin: centre\nparameters: {fx: 500, fy: 500, cx: 30, cy: 20}\n";
}

const std::string plates =
    "Anker;Rolle;Geschoss;Tag-Familie;Tag-Nr;Tag-Größe [mm];tag_x_mm;tag_y_mm;tag_z_mm;Azimut [deg];Bemerkung;;\r\n"
    "F01;Passpunkt;1;tag36h11;0;200,0;0;200;0;180;Dübel neu;;\r\n"
    "F02;Kontrollpunkt;1;tag36h11;1;200,0;0;200;0;180;;;\r\n;;;;;;;;;;;;\r\n";
const std::string control = "Punkt;Rechtswert;Hochwert;Höhe\r\nG1;10,5;20,25;3,1\r\n";
const std::string gsi =
    "*110001+00000000000000S1 84..10+0000000000010500 85..10+0000000000020250 86..10+0000000000003100 "
    "88..10+0000000000001500\n"
    "*110002+000000000000000A 21.322+0000000012345670 22.322+0000000009876540 31..00+0000000000012345\n";

TEST_F(Folder, RecognisesWhatLiesThere) {
  write("Vermessung/montag.gsi", gsi);
  write("Schilder Süd.csv", plates);
  write("Festpunkte.csv", control);
  write("Kamera.yaml", camera("x2d", 60, 40));
  write("Entwurf.ifc", "ISO-10303-21;\n");
  write("Protokoll.docx", "PK");
  const Proposal p = propose();
  for (const char* line : {"survey: Vermessung/montag.gsi", "plates: Schilder Süd.csv", "control: Festpunkte.csv",
                           "design: Entwurf.ifc", "# images: images/*.JPG   # MISSING"})
    EXPECT_NE(p.yaml.find(line), std::string::npos) << line << "\n" << p.yaml;
  EXPECT_EQ(p.yaml.find("Protokoll"), std::string::npos);
}

/// The job and the table that was exported of it, rounded to 0.1 mgon and 0.1 mm: both were proposed, and counted
/// twice.
TEST_F(Folder, ProposesOneOfTwoFilesWithTheSameReadings) {
  std::string job = "*410001+0000000000000021 42....+00000000000000S1 43....+0000000000000000 \n",
              table = "station,target,hz [gon],v [gon],sd [m]\n";
  const int hz[] = {3993547, 9649663, 3090131, 35398203}, v[] = {10381449, 10077209, 9807138, 10362462},
            sd[] = {2504538, 4123322, 4951908, 4393461};
  for (int i = 0; i < 4; ++i) {
    char line[160];
    std::snprintf(line, sizeof line, "*11%04d+00000000000000K%d 21.322+%016d 22.322+%016d 31..08+%016d \n", i + 2,
                  i + 1, hz[i], v[i], sd[i]);
    job += line;
    std::snprintf(line, sizeof line, "S1,K%d,%.4f,%.4f,%.4f\n", i + 1, hz[i] / 1e5, v[i] / 1e5, sd[i] / 1e5);
    table += line;
  }
  write("job.gsi", job);
  write("job.csv", table);
  const Proposal p = propose();
  EXPECT_NE(p.yaml.find("survey: job.gsi   #"), std::string::npos) << p.yaml;
  EXPECT_NE(p.yaml.find("# not proposed: job.csv"), std::string::npos) << p.yaml;
  ASSERT_FALSE(p.wrong.empty());
  EXPECT_TRUE(std::any_of(p.wrong.begin(), p.wrong.end(), [](const std::string& text) {
    return text.find("job.csv") != std::string::npos && text.find("job.gsi") != std::string::npos;
  }));
}

/// Header and end of a PNG of 60 x 40 pixels: all that is read of a photograph here.
const std::string photograph(
    "\x89\x50\x4e\x47\x0d\x0a\x1a\x0a\x00\x00\x00\x0d\x49\x48\x44\x52\x00\x00\x00\x3c\x00\x00\x00\x28\x08\x00\x00\x00"
    "\x00\x87\xd0\xc6\x23\x00\x00\x00\x00IEND\xae\x42\x60\x82",
    45);

std::string all_of(const std::vector<std::string>& lines) {
  std::string all;
  for (const std::string& line : lines) all += line + "\n";
  return all;
}

TEST_F(Folder, TwoBodiesOfOneModelAreToldApartByTheirFolders) {
  write("Kran/1.png", photograph), write("Kran/2.png", photograph), write("Boden/1.png", photograph);
  write("Kamera_Kran.yaml", camera("a", 60, 40)), write("cal-2.yaml", camera("x2d-boden", 60, 40));
  const Proposal p = propose();
  EXPECT_NE(p.yaml.find("  Kamera_Kran.yaml: \"Kran/*.png\"\n"), std::string::npos) << p.yaml;
  EXPECT_NE(p.yaml.find("  cal-2.yaml: Boden/1.png\n"), std::string::npos) << p.yaml;
  EXPECT_EQ(all_of(p.wrong).find("camera:"), std::string::npos) << all_of(p.wrong);
}

TEST_F(Folder, CalibrationsThatNothingTellsApartAreAQuestion) {
  write("Fotos/1.png", photograph), write("Fotos/2.png", photograph);
  write("a.yaml", camera("a", 60, 40)), write("b.yaml", camera("b", 60, 40)), write("c.yaml", camera("c", 80, 40));
  const std::string wrong = all_of(propose().wrong);
  EXPECT_NE(wrong.find("a.yaml and b.yaml both fit Fotos/1.png, Fotos/2.png; the first is taken"), std::string::npos)
      << wrong;
  EXPECT_NE(wrong.find("c.yaml is a calibration for none of the photographs"), std::string::npos) << wrong;
}

std::string refusal_of(const std::function<void()>& call) {
  try {
    call();
  } catch (const CampaignError& error) {
    return error.what();
  }
  return "";
}

/// "control - alt.csv" stands before "control.csv" in the alphabet, and was taken.
TEST_F(Folder, OfSeveralTablesTheOneThatIsCalledSoIsTakenOrNone) {
  write("control - alt.csv", control), write("control.csv", control);
  const Proposal named = propose();
  EXPECT_NE(named.yaml.find("\ncontrol: control.csv   #"), std::string::npos) << named.yaml;
  EXPECT_NE(all_of(named.wrong).find("control: control - alt.csv, control.csv could all be it; control.csv is taken"),
            std::string::npos)
      << all_of(named.wrong);
  write("design_a.ifc", "ISO-10303-21;\n"), write("design_b.ifc", "ISO-10303-21;\n");
  const Proposal open = propose();
  EXPECT_NE(open.yaml.find("\ndesign: [design_a.ifc, design_b.ifc]   #"), std::string::npos) << open.yaml;
  EXPECT_NE(all_of(open.wrong).find("could all be it; leave the right one there and no other"), std::string::npos);
  EXPECT_EQ(open.pipeline, "");
}

TEST_F(Folder, ADescriptionUnderAnotherNameIsToldAndNotPassedOver) {
  const std::string text = "# of the tower\nplumbline_campaign: 1\ncontrol: control.csv\n";
  for (const char* name : {"campaign.yml", "Campaign.yaml", "campaign.yaml.txt", "Turm.YAML"}) {
    write(name, text);
    EXPECT_EQ(refusal_of([&] { refuse_misnamed_campaign(folder_.path(), names_); }),
              folder_.path().string() + ": '" + name +
                  "' describes the folder under a name that nothing reads: rename it to campaign.yaml");
    names_.pop_back();
  }
  write("camera.yaml", camera("a", 60, 40)), write("notes.txt", "see plumbline_campaign: in the manual");
  write("old/campaign.yml", text);
  EXPECT_NO_THROW(refuse_misnamed_campaign(folder_.path(), names_));
  write("campaign.yml", text), write("campaign.yaml", text);
  EXPECT_NO_THROW(refuse_misnamed_campaign(folder_.path(), names_));
}

TEST_F(Folder, AFolderInPlaceOfItsFilesIsNoOutputOfARun) {
  write("images/a.png", photograph), write("control.csv", control);
  const std::string yaml = "plumbline_campaign: 1\nimages: images\ncontrol: control.csv\n";
  const std::string message =
      refusal_of([&] { parse_campaign(yaml, folder_.path() / "campaign.yaml", names_, CampaignUse::photographs); });
  EXPECT_NE(
      message.find("'images' names 'images', and that is a folder; name what is meant in it, such as images/*.jpg"),
      std::string::npos)
      << message;
}

TEST_F(Folder, GermanColumnsAndRolesOfPlatesAreRead) {
  const auto entries = parse_plates(plates, "Schilder.csv", CampaignUse::site, &names_);
  ASSERT_EQ(entries.size(), 2u);
  EXPECT_EQ(entries[0].role, "control");
  EXPECT_EQ(entries[1].role, "check") << "a Kontrollpunkt is one to judge by";
  EXPECT_EQ(entries[0].tag_size, 0.2);
  EXPECT_EQ(names_, std::vector<std::string>{
                        "Schilder.csv:1: the column 'bemerkung' is none of this table's, and is left out"});
}

TEST_F(Folder, SaysWhatIsMissingAndWhatCannotBeRead) {
  write("Schilder.ods", "PK"), write("Passpunkte.xlsx", "PK");
  const Proposal p = propose();
  std::string all;
  for (const std::string& line : p.wrong) all += line + "\n";
  for (const char* words :
       {"plates: no table says which tag hangs", "survey: no file with readings", "design: no IFC",
        "Schilder.ods: this format of spreadsheets is not read; save it as .xlsx, or its sheet as CSV",
        "Passpunkte.xlsx: this is no Excel workbook; is it protected by a password"})
    EXPECT_NE(all.find(words), std::string::npos) << words << "\n" << all;
}

TEST_F(Folder, WhatCannotBeReadIsNoCameraOfItsOwn) {
  for (const char* name : {"a.png", "b.png"}) write(name, photograph);
  write("c.png", "");
  write("camera.yaml", camera("x2d", 60, 40));
  const Proposal p = propose();
  EXPECT_NE(p.yaml.find("# unused: c.png   # cannot be read"), std::string::npos) << p.yaml;
  EXPECT_NE(p.yaml.find("images: \"*.png\""), std::string::npos) << p.yaml;
  for (const std::string& line : p.wrong) EXPECT_EQ(line.find("0 x 0"), std::string::npos) << line;
}

TEST_F(Folder, TagsThatWereMeasuredAlreadyAreRecognised) {
  write("observations.csv", "image,family,tag_id,x0_px,y0_px,x1_px,y1_px,x2_px,y2_px,x3_px,y3_px,sigma_px\n");
  write("camera.yaml", camera("x2d", 60, 40));
  const Proposal p = propose();
  for (const char* line : {"\nobservations: observations.csv", "\ncamera: camera.yaml"})
    EXPECT_NE(p.yaml.find(line), std::string::npos) << line << "\n" << p.yaml;
  EXPECT_NE(p.found.back().find("plumbline run site_observations"), std::string::npos) << p.found.back();
}

TEST_F(Folder, ReadingsAloneAreGoodForSomethingElse) {
  write("monday.gsi", gsi);
  EXPECT_NE(propose().found.back().find("plumbline run survey_campaign"), std::string::npos);
  write("plates.csv", plates);
  write("design.ifc", "ISO-10303-21;\n");
  EXPECT_NE(propose().found.back().find("plumbline run site_survey"), std::string::npos);
}

/// A name with the end of a line in it became a YAML that named another file.
TEST_F(Folder, NamesMayHoldWhatTheyLike) {
  const std::string name = "t\x1b[2J\nu\"\\ä.gsi";
  write(name, gsi);
  const CampaignDescription c = parse_campaign(propose().yaml, "campaign.yaml", names_, CampaignUse::survey);
  EXPECT_EQ(c.survey, std::vector<std::string>{name});
}

TEST_F(Folder, ADamagedTableIsToldWithItsLine) {
  write("plates.csv",
        "anchor,tag_id,role,floor,tag_family,tag_size_mm,tag_x_mm,tag_y_mm,tag_z_mm,facing_azimuth_deg\n"
        "A,x,control,1,tag36h11,200,0,0,0,180\n");
  const Proposal p = propose();
  EXPECT_NE(p.yaml.find("plates: plates.csv"), std::string::npos) << p.yaml;
  EXPECT_NE(p.wrong.front().find("plates.csv:2: column 'tag_id' holds 'x'"), std::string::npos) << p.wrong.front();
}

/// One cell that is no number took the whole table out: nothing was proposed, and the check found the folder whole.
TEST_F(Folder, ATableOfControlWithAMistakeIsStillOne) {
  const std::string header = "id,east_m,north_m,height_m,sigma_east_mm,sigma_north_mm,sigma_height_mm\n";
  write("survey/monday.gsi", gsi);
  write("points.csv", header + "G1,-2.9,-3.6,0.08,0.5,0.5,0.5\nG2,9.0,-3.4,0.08,0.5,0.5,x\n");
  const Proposal by_header = propose();
  EXPECT_NE(by_header.yaml.find("\ncontrol: points.csv   #"), std::string::npos) << by_header.yaml;
  EXPECT_NE(all_of(by_header.wrong).find("points.csv:3: 'sigma_height' is 'x', expected a number"), std::string::npos)
      << all_of(by_header.wrong);
  write("Festpunkte.csv", "id;east_m;north_m;height_m\nG1;5,12E+05;5,41E+06;0,08\nG2;5,12E+05;5,41E+06;0,08\n");
  const Proposal by_name = propose();
  EXPECT_NE(by_name.yaml.find("\ncontrol: Festpunkte.csv   #"), std::string::npos) << by_name.yaml;
  EXPECT_NE(all_of(by_name.wrong).find("Festpunkte.csv:2: 'east' is '5,12E+05', which a spreadsheet has shortened"),
            std::string::npos)
      << all_of(by_name.wrong);
}

TEST_F(Folder, TitlesMayStandAboveATable) {
  write("Schilder.csv", "Projekt Turm;;;;\r\nStand 05.05.2026;;;;\r\n\r\n" + plates);
  write("Festpunkte.csv", "Projekt: Turm;;\r\nBlatt;3\r\n\r\n" + control);
  const Proposal p = propose();
  for (const char* line : {"\nplates: Schilder.csv   #", "\ncontrol: Festpunkte.csv   #"})
    EXPECT_NE(p.yaml.find(line), std::string::npos) << line << "\n" << p.yaml << all_of(p.wrong);
  std::vector<std::string> warnings;
  const std::vector<ControlPoint> points =
      parse_control("Projekt: Turm;;\r\nBlatt;3\r\n\r\n" + control, "Festpunkte.csv", &warnings);
  ASSERT_EQ(points.size(), 1u);
  EXPECT_EQ(points[0].position, Eigen::Vector3d(10.5, 20.25, 3.1));
  EXPECT_NE(all_of(warnings).find("2 rows above the header are titles, and are left out"), std::string::npos)
      << all_of(warnings);
  // Values above a header are no title: nobody may lose a point.
  EXPECT_NE(refusal_of([&] { parse_control("G0;1,5;2,5;3,5\r\n" + control, "Festpunkte.csv"); }), "");
}

/// The date of the as-built model is nobody's guess: the line is there to be filled in.
TEST_F(Folder, HasALineForTheDateWhereNoFileSaysIt) {
  write("survey/monday.gsi", gsi);
  EXPECT_NE(propose().yaml.find("\n# date: 2026-05-12   # when it was measured"), std::string::npos) << propose().yaml;
}

TEST_F(Folder, SaysWhereNoKnownPointWasFound) {
  write("survey/monday.gsi", gsi);
  EXPECT_NE(propose().yaml.find("\n# control: control.csv   # no table of known points was found"), std::string::npos);
}

}  // namespace test_propose_campaign
}  // namespace plumbline::campaign
