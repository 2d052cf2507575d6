// A site's folder as people have it: with the results of earlier runs in it, with files that nothing names, with what
// computers leave beside the photographs.
#include <algorithm>
#include <cctype>
#include <nlohmann/json.hpp>

#include "program.hpp"
#include "test_paths.hpp"

namespace plumbline::test {
namespace test_site_folder {

namespace fs = std::filesystem;

const std::string pipelines = std::string(plumbline::test::source_dir()) + "/pipelines/";

/// A small simulated site, made once; each test gets a copy of it in work/site.
class SiteFolder : public testing::Test {
 protected:
  static void SetUpTestSuite() {
    maker_ = std::make_unique<Program>(PLUMBLINE_PLUGIN_FOLDER);
    maker_->write("make.yaml",
                  "plumbline: 1\nvars: {seed: 2}\nnodes:\n  site: {use: simulate.campaign, with: {floors: 1, columns: "
                  "3, camera: quick_6mp, images_per_floor: 4}}\noutputs: {site: site.folder}\n");
    const Answer made = (*maker_)({"run", "make.yaml", "--out", "made"});
    ASSERT_EQ(made.code, 0) << made.err;
  }
  static void TearDownTestSuite() { maker_.reset(); }

  void SetUp() override {
    fs::copy(maker_->work() / "made/site", site(), fs::copy_options::recursive);
    for (const auto& entry : fs::recursive_directory_iterator(site()))
      fs::permissions(entry, fs::perms::owner_write, fs::perm_options::add);
  }
  fs::path site() const { return plumbline.work() / "site"; }
  void write(const std::string& name, const std::string& content) const {
    fs::create_directories((site() / name).parent_path());
    std::ofstream(site() / name, std::ios::binary) << content;
  }
  void append(const std::string& name, const std::string& content) const {
    std::ofstream(site() / name, std::ios::binary | std::ios::app) << content;
  }
  /// The program with `pipeline` of the shipped ones, in the site's folder.
  Answer in_site(const std::string& pipeline, std::vector<std::string> more) const {
    fs::create_directory(plumbline.work() / "elsewhere");
    more.insert(more.begin(), {"run", pipelines + pipeline + ".yaml", "folder=."});
    return plumbline.in(site(), more);
  }
  Answer process(const std::string& out, std::vector<std::string> more = {}) const {
    more.insert(more.begin(), {"run", pipelines + "site_campaign.yaml", "folder=site", "--out", out});
    return plumbline(more);
  }

  inline static std::unique_ptr<Program> maker_;
  const Program plumbline{PLUMBLINE_PLUGIN_FOLDER};
};

TEST_F(SiteFolder, HoldsItsOwnResultsAndStaysTheSame) {
  for (const std::string pipeline : {"site_campaign", "survey_campaign", "photo_campaign", "detect_images"}) {
    // Photographs without a calibration that they can hold, so photo_campaign may say that it must not be used (3).
    const Answer first = in_site(pipeline, {});
    ASSERT_TRUE(first.code == 0 || first.code == 3) << pipeline << "\n" << first.out << first.err;
    const Answer second = in_site(pipeline, {});
    EXPECT_EQ(second.code, first.code) << second.err;
    // read.tag_family looks at its file each time, because the host cannot know when that changed.
    const std::string anew =
        pipeline == "photo_campaign" || pipeline == "detect_images" ? ": 1 executed, " : ": 0 executed, ";
    EXPECT_TRUE(contains(second.out, anew)) << pipeline << "\n" << second.out;
    EXPECT_EQ(in_site(pipeline, {"--out", "."}).code, first.code) << "outputs among the files themselves";
    const Answer beside = in_site(pipeline, {"--out", "../beside"});
    EXPECT_EQ(beside.code, first.code) << beside.err;
    EXPECT_TRUE(contains(beside.out, anew)) << pipeline << "\n" << beside.out;
  }
}

TEST_F(SiteFolder, WhatIsNotReadIsNotProvedRead) {
  ASSERT_EQ(process("plain").code, 0);
  write("Protokoll.docx", "PK");
  const Answer answer = process("with_notes");
  ASSERT_EQ(answer.code, 0) << answer.err;
  EXPECT_EQ(read_file(plumbline.work() / "plain/as_built.ifc"),
            read_file(plumbline.work() / "with_notes/as_built.ifc"));
  EXPECT_TRUE(contains(answer.out, "Took part: 4 photographs, ")) << answer.out;
  EXPECT_TRUE(contains(answer.out, "In the folder and not read: Protokoll.docx.")) << answer.out;
  const std::string ifc = read_file(plumbline.work() / "with_notes/as_built.ifc");
  EXPECT_TRUE(contains(ifc, "'ImageCount',$,IFCINTEGER(4)") ||
              contains(ifc, "'ImageCount','Images that took part',IFCINTEGER(4)"))
      << ifc.substr(ifc.find("ImageCount"), 100);
  EXPECT_TRUE(contains(ifc, "images/F01-01.jpg "));
  EXPECT_TRUE(contains(ifc, "plates.csv "));
  EXPECT_FALSE(contains(ifc, "docx"));
  const std::string page = read_file(plumbline.work() / "with_notes/report.html");
  EXPECT_TRUE(contains(page, "file in the folder that was not read, with SHA-256"));
  EXPECT_TRUE(contains(page, "that the run read"));
}

/// A photograph of nothing: one of the site's, with all that its compression holds multiplied by zero.
std::string grey(std::string jpeg) {
  for (std::size_t at = 2; at + 4 < jpeg.size() && jpeg[at] == '\xFF' && jpeg[at + 1] != '\xDA';) {
    const std::size_t length =
        256 * static_cast<unsigned char>(jpeg[at + 2]) + static_cast<unsigned char>(jpeg[at + 3]);
    for (std::size_t table = at + 4; jpeg[at + 1] == '\xDB' && table < at + 2 + length; table += 65)
      std::fill_n(jpeg.begin() + static_cast<std::ptrdiff_t>(table) + 1, 64, '\0');
    at += 2 + length;
  }
  return jpeg;
}

/// The number that stands before the first of these words; -1: none.
long number_before(const std::string& text, const std::string& words) {
  const std::size_t end = text.find(words);
  if (end == std::string::npos) return -1;
  std::size_t at = end;
  while (at > 0 && std::isdigit(static_cast<unsigned char>(text[at - 1]))) --at;
  return at == end ? -1 : std::stol(text.substr(at, end - at));
}

/// The terminal said "12 of 13 photographs", the page and the IFC counted 13; readings that were excluded "took part",
/// and were not counted.
TEST_F(SiteFolder, WhatIsLeftOutTakesNoPart) {
  write("images/sky.jpg", grey(read_file(site() / "images/F01-04.jpg")));
  const Answer all = process("all", {"poses.with.on_too_few=skip"});
  ASSERT_TRUE(contains(all.out, "Took part: 4 of 5 photographs, ")) << all.out << all.err;
  EXPECT_FALSE(contains(all.out, "Left out of the readings")) << all.out;
  const long read = number_before(all.out, " readings, ");
  const std::string page = read_file(plumbline.work() / "all/report.html");
  EXPECT_TRUE(contains(page, "4 of 5 photographs, ")) << page.substr(page.find("Took part"), 200);
  EXPECT_TRUE(contains(page, "photograph, left out"));
  EXPECT_TRUE(contains(read_file(plumbline.work() / "all/as_built.ifc"), "'Images that took part',IFCINTEGER(4)"));

  const Answer fewer = process(
      "fewer", {"poses.with.on_too_few=skip", "language=de", "network.with.exclude=[point F01-C02-R1: knocked]"});
  EXPECT_TRUE(contains(fewer.out, "Von den Ablesungen ausgenommen: point F01-C02-R1: knocked."))
      << fewer.out << fewer.err;
  // The set-ups' readings are the same, but for those to the point: each is counted, faces and sets by themselves.
  EXPECT_EQ(number_before(fewer.out, " Ablesungen, "), read);
  const long used = number_before(fewer.out, " von " + std::to_string(read) + " Ablesungen, ");
  EXPECT_GT(used, read / 2) << fewer.out;
  EXPECT_LT(used, read) << fewer.out;
  EXPECT_EQ((read - used) % 3, 0) << "a direction, a zenith angle and a distance each";
  const std::string ifc = read_file(plumbline.work() / "fewer/as_built.ifc");
  EXPECT_TRUE(contains(ifc, "'Readings of the survey that took part',IFCINTEGER(" + std::to_string(used) + ")"));
  EXPECT_TRUE(contains(ifc, "'Readings that were read and left out',IFCINTEGER(" + std::to_string(read - used) + ")"));
  EXPECT_TRUE(contains(read_file(plumbline.work() / "fewer/summary.txt"),
                       std::to_string(used) + " von " + std::to_string(read) + " Ablesungen, "));
  const std::string german = read_file(plumbline.work() / "fewer/report.html");
  EXPECT_TRUE(contains(german, std::to_string(used) + " von " + std::to_string(read) + " Ablesungen, "));
  EXPECT_TRUE(contains(german, "Von den Ablesungen ausgenommen"));
  EXPECT_TRUE(contains(german, "Foto, nicht beteiligt"));
}

/// "1 to run, 23 more at most, 0 reused" was all that a plan knew of a photograph more, where the run reused five.
TEST_F(SiteFolder, PlanSaysWhatAPhotographMoreCosts) {
  fs::rename(site() / "images/F01-04.jpg", plumbline.work() / "later.jpg");
  ASSERT_EQ(process("out").code, 0);
  fs::rename(plumbline.work() / "later.jpg", site() / "images/F01-04.jpg");
  const std::vector<std::string> command = {"plan", pipelines + "site_campaign.yaml", "folder=site"};
  const Answer plan = plumbline(command);
  ASSERT_EQ(plan.code, 0) << plan.err;
  EXPECT_TRUE(contains(plan.out, "tags (detect.apriltag)")) << plan.out;
  EXPECT_TRUE(contains(plan.out, "1 of 4 items; ")) << plan.out;
  EXPECT_TRUE(contains(plan.out, "; 'site' and 'campaign' read the files for this plan")) << plan.out;
  const long sure = number_before(plan.out, " to run and "), reused = number_before(plan.out, " reused for certain; "),
             perhaps = number_before(plan.out, " run only if ");
  EXPECT_EQ(sure, 1) << plan.out;
  // Planned once more nothing has to be read.
  EXPECT_FALSE(contains(plumbline(command).out, "read the files")) << plan.out;
  const Answer run = process("out");
  ASSERT_EQ(run.code, 0) << run.err;
  EXPECT_EQ(number_before(run.out, " executed, "), sure + perhaps) << plan.out << run.out;
  EXPECT_EQ(number_before(run.out, " reused, "), reused) << plan.out << run.out;
  EXPECT_TRUE(contains(run.out, "1 of 4 items") || contains(run.err, "1 of 4")) << run.out << run.err;
  // What the run would refuse, the plan tells.
  append("campaign.yaml", "\ntoleranz: 5\n");
  const Answer refused = plumbline(command);
  EXPECT_EQ(refused.code, 1) << refused.out;
  EXPECT_TRUE(contains(refused.err, "unknown key 'toleranz'")) << refused.err;
}

TEST_F(SiteFolder, ForgottenEvidenceEndsTheRun) {
  fs::create_directory(site() / "images/nachtrag");
  fs::rename(site() / "images/F01-04.jpg", site() / "images/nachtrag/F01-04.jpg");
  fs::copy_file(site() / "images/F01-03.jpg", site() / "images/neu.JPG");
  fs::copy_file(site() / "survey/total_station.gsi", site() / "survey/dienstag.txt");
  const Answer refused = process("out");
  EXPECT_EQ(refused.code, 1);
  for (const char* word : {"2 photographs (images/nachtrag/F01-04.jpg, images/neu.JPG)",
                           "1 survey file (survey/dienstag.txt)", "that nothing names", "'images' and 'survey'",
                           "unused: [images/neu.JPG, images/nachtrag/F01-04.jpg, survey/dienstag.txt]"})
    EXPECT_TRUE(contains(refused.err, word)) << word << "\n" << refused.err;
  // Beside another mistake, too.
  const std::string sound = read_file(site() / "campaign.yaml");
  append("campaign.yaml", "\ntoleranz: 5\n");
  const Answer both = process("out");
  for (const char* word : {"unknown key 'toleranz'", "1 survey file (survey/dienstag.txt)"})
    EXPECT_TRUE(contains(both.err, word)) << word << "\n" << both.err;
  write("campaign.yaml", sound);
  append("campaign.yaml", "\nunused: [images/neu.JPG, \"images/nachtrag/**\", survey/dienstag.txt]\n");
  const Answer answer = process("out");
  EXPECT_TRUE(contains(answer.out, "Took part: 3 photographs, ")) << answer.out << answer.err;
  EXPECT_TRUE(
      contains(answer.out, "Set aside by 'unused': images/nachtrag/F01-04.jpg, images/neu.JPG, survey/dienstag.txt."))
      << answer.out;
  EXPECT_TRUE(contains(read_file(plumbline.work() / "out/as_built.ifc"), "UnusedSha256"));
  EXPECT_TRUE(contains(read_file(plumbline.work() / "out/report.html"), " in campaign.yaml, with SHA-256"));
}

/// A table of sightings with a mistake in its header was no survey file, and was left out without a word.
TEST_F(SiteFolder, SightingsWithAMistakeAreSightings) {
  write("survey/mittwoch.csv", "station,target,hz,v,sd\nS1,A,0.0,90.0,10.0\nS1,B,45.0,89.0,12.0\n");
  const Answer refused = process("out");
  EXPECT_EQ(refused.code, 1) << refused.out;
  EXPECT_TRUE(contains(refused.err, "1 survey file (survey/mittwoch.csv) that nothing names")) << refused.err;
}

TEST_F(SiteFolder, AMacsAndAWindowsFilesAreNoPhotographs) {
  for (const char* name : {"images/._F01-01.jpg", "images/Thumbs.db", ".DS_Store", "~$plates.csv"}) write(name, "\0\5");
  const Answer answer = process("out");
  EXPECT_EQ(answer.code, 0) << answer.err;
  EXPECT_TRUE(contains(answer.out, "Took part: 4 photographs, ")) << answer.out;
  EXPECT_TRUE(contains(answer.out, "In the folder and not read: ")) << answer.out;
}

TEST_F(SiteFolder, NamesAreTheSameHoweverTheirLettersAreEncoded) {
  fs::rename(site() / "plates.csv", site() /
                                        "Schilder Su\xCC\x88"
                                        "d.csv");  // u and a mark, as macOS zips it
  std::string yaml = read_file(site() / "campaign.yaml");
  yaml.replace(yaml.find("plates.csv"), 10,
               "Schilder S\xC3\xBC"
               "d.csv");
  write("campaign.yaml", yaml);
  EXPECT_EQ(process("out").code, 0);
}

TEST_F(SiteFolder, AllMistakesAreToldAtOnce) {
  std::string yaml = read_file(site() / "campaign.yaml");
  yaml.replace(yaml.find("design:"), 7, "desing:");
  write("campaign.yaml", yaml);
  std::string plates = read_file(site() / "plates.csv");
  plates.replace(plates.find("tag36h11,0,200"), 14, "tag36h11,0,zwei");
  plates.replace(plates.find("tag36h11,1,200"), 14, "tag36h11,0,200");
  write("plates.csv", plates);
  write("camera.yaml", "plumbline_camera: 1\n");
  append("survey/total_station.gsi", "*110003+000000000000000B 21.322+00000000123\n");
  const Answer answer = process("out");
  EXPECT_EQ(answer.code, 1);
  for (const char* word : {"unknown key 'desing', did you mean 'design'?", "column 'tag_size' holds 'zwei'",
                           "camera.yaml:1: the key 'id' is missing", "found '21.322+00000000123'"})
    EXPECT_TRUE(contains(answer.err, word)) << word << "\n" << answer.err;
}

/// One mistake of each file was told, and the next one when that was mended; the design when all else was.
TEST_F(SiteFolder, AllMistakesOfAFileAreToldAtOnce) {
  std::string control = read_file(site() / "control.csv");
  for (const char* id : {"G1,", "G3,"}) control.replace(control.find(id), 3, std::string(id) + "x");
  write("control.csv", control);
  for (const char* value : {"11", "12"})
    append("survey/total_station.gsi", "*110003+000000000000000B 21.322+000000001" + std::string(value) + "\n");
  std::string design = read_file(site() / "design.ifc");
  write("design.ifc", design.substr(0, design.size() / 2));
  write("images/F01-02.jpg", read_file(site() / "images/F01-02.jpg").substr(0, 20000));
  const Answer answer = plumbline({"campaign", "check", "site"});
  EXPECT_EQ(answer.code, 1);
  for (const char* word : {"control.csv:2: 'east' is 'x", "control.csv:4: 'east' is 'x", "found '21.322+00000000111'",
                           "found '21.322+00000000112'", "the design was copied in part",
                           "stops after 20000 bytes without its end mark; copy it again from the camera, or"})
    EXPECT_TRUE(contains(answer.err, word)) << word << "\n" << answer.err;
}

/// With a camera that cannot be read no photograph was looked at, the mapping was read after all else was whole, and
/// tags that no run looks for last of all: four rounds for one folder.
TEST_F(SiteFolder, AllMistakesAreToldAtOnceAlsoWithoutItsCamera) {
  write("camera.yaml", "plumbline_camera: 1\n");
  write("images/F01-02.jpg", read_file(site() / "images/F01-02.jpg").substr(0, 20000));
  write("names.csv", "Punkt;Bauteil\nF01;1\n");
  std::string plates = read_file(site() / "plates.csv");
  plates.replace(plates.find("tag36h11"), 8, "tag25h9");
  write("plates.csv", plates);
  append("campaign.yaml", "mapping: names.csv\nunused: [nix/*.jpg]\n");
  const Answer answer = plumbline({"campaign", "check", "site"});
  EXPECT_EQ(answer.code, 1);
  for (const char* word : {"camera.yaml:1: the key 'id' is missing", "stops after 20000 bytes without its end mark",
                           "names.csv:1: found no column 'point'", "the plate table has tags of tag25h9",
                           "(family=tag25h9)", "'unused' names 'nix/*.jpg', which fits nothing here"})
    EXPECT_TRUE(contains(answer.err, word)) << word << "\n" << answer.err;
}

/// Beside any other mistake they were told in a round of their own, when the design had been read.
TEST_F(SiteFolder, AnchorsThatNoFileHasAreToldBesideOtherMistakes) {
  write("camera.yaml", "plumbline_camera: 1\n");
  append("plates.csv", "F01-C99-R1,control,1,2,1,tag36h11,77,200,0,200,0,180,b\n");
  const Answer answer = plumbline({"campaign", "check", "site"});
  EXPECT_EQ(answer.code, 1);
  for (const char* word :
       {"camera.yaml:1: the key 'id' is missing", "have these anchors of the plate table: F01-C99-R1;"})
    EXPECT_TRUE(contains(answer.err, word)) << word << "\n" << answer.err;
}

TEST_F(SiteFolder, AnExcelTableIsRead) {
  std::istringstream lines(read_file(site() / "plates.csv"));
  std::string table, line;
  for (bool first = true; std::getline(lines, line); first = false) {
    std::replace(line.begin(), line.end(), ',', ';');
    table += line + (first ? ";Bemerkung;;" : ";Dübel neu;;") + "\r\n";
  }
  write("plates.csv", table + ";;;;;;;\r\n;;;;;;;\r\n");
  const Answer answer = process("out");
  EXPECT_EQ(answer.code, 0) << answer.err;
  EXPECT_TRUE(contains(answer.err, "the column 'bemerkung' is none of this table's, and is left out")) << answer.err;
}

/// One mistake is told once: of a campaign.yaml that cannot be read, or whose key for the control is misspelt, nobody
/// knows that the control was left out.
TEST_F(SiteFolder, ATableOfControlIsNotForgottenWhereTheFileThatNamesItHasAMistake) {
  const std::string sound = read_file(site() / "campaign.yaml"), forgotten = "looks like a table of known points";
  const std::size_t at = sound.find("control:");
  ASSERT_NE(at, std::string::npos);
  for (const std::string& yaml : {sound + "a: [1\n", "plumbline_campaign; 1" + sound.substr(sound.find("\n")),
                                  sound.substr(0, at) + "contrl:" + sound.substr(at + 8),
                                  sound.substr(0, at) + "Festpunkte:" + sound.substr(at + 8),
                                  sound.substr(0, at) + "control: gone.csv #" + sound.substr(at + 8)}) {
    write("campaign.yaml", yaml);
    const Answer checked = plumbline({"campaign", "check", "site"});
    EXPECT_EQ(checked.code, 1) << checked.out;
    EXPECT_TRUE(contains(checked.err, "campaign.yaml:")) << checked.err;
    EXPECT_FALSE(contains(checked.err, forgotten)) << checked.err;
  }
  fs::remove(site() / "campaign.yaml");
  const Answer checked = plumbline({"campaign", "check", "site"});
  EXPECT_TRUE(contains(checked.err, "campaign.yaml: this file is missing")) << checked.err;
  EXPECT_FALSE(contains(checked.err, forgotten)) << checked.err;
}

/// Known points that one wrong cell took out: "The folder is whole.", and a survey on its own coordinates, with anchors
/// 4 mm elsewhere.
TEST_F(SiteFolder, ATableOfControlIsNotTakenOutInSilence) {
  const std::string sound = read_file(site() / "control.csv");
  std::string wrong = sound;
  wrong.replace(wrong.find("\n", wrong.find("G1,")) - 3, 3, "x");
  for (const std::string& table : {wrong, "Projekt: Turm;;\n\n" + sound}) {
    write("control.csv", table);
    fs::remove(site() / "campaign.yaml");
    const Answer proposed = plumbline({"campaign", "init", "site"});
    EXPECT_TRUE(contains(proposed.out, "control: control.csv")) << proposed.out << proposed.err;
    const bool is_wrong = table == wrong;
    EXPECT_EQ(contains(proposed.out + proposed.err, "'sigma_height' is 'x'"), is_wrong) << proposed.out << proposed.err;
    EXPECT_EQ(plumbline({"campaign", "check", "site"}).code, is_wrong ? 1 : 0);
  }
  std::string yaml = read_file(site() / "campaign.yaml");
  yaml.erase(yaml.find("control: control.csv"),
             yaml.find("\n", yaml.find("control: control.csv")) + 1 - yaml.find("control: control.csv"));
  write("campaign.yaml", yaml);
  const Answer checked = plumbline({"campaign", "check", "site"});
  EXPECT_EQ(checked.code, 1) << checked.out;
  const std::string words = "control.csv looks like a table of known points, and nothing names it";
  EXPECT_TRUE(contains(checked.err, words)) << checked.err;
  EXPECT_TRUE(contains(process("out").err, words)) << "a run warns";
  write("campaign.yaml", yaml + "\nunused: control.csv\n");
  EXPECT_EQ(plumbline({"campaign", "check", "site"}).code, 0);
}

}  // namespace test_site_folder
}  // namespace plumbline::test
