// photo_campaign on simulated photographs: several cameras in one block, and what is said of photographs, calibrations
// and tables that do not belong together.
#include <nlohmann/json.hpp>

#include "program.hpp"
#include "test_paths.hpp"

namespace plumbline::test {
namespace test_photo_campaign {

namespace fs = std::filesystem;

/// A floor photographed by two cameras, in site/left and site/right; the survey is the same whoever photographs.
class PhotoCampaign : public testing::Test {
 protected:
  static void SetUpTestSuite() {
    made = new Program{PLUMBLINE_PLUGIN_FOLDER};
    made->write("make.yaml",
                "plumbline: 1\nvars: {camera: quick_6mp}\nnodes:\n  site: {use: simulate.campaign, with: {floors: 1, "
                "columns: 3, images_per_floor: 4, camera: \"${camera}\"}}\noutputs: {site: site.folder}\n");
    for (const char* camera : {"quick_6mp", "demo_24mp"}) {
      const Answer answer = (*made)({"run", "make.yaml", std::string("camera=") + camera, "--out", camera});
      ASSERT_EQ(answer.code, 0) << answer.err;
    }
  }
  static void TearDownTestSuite() { delete std::exchange(made, nullptr); }

  void SetUp() override {
    fs::create_directories(site() / "survey");
    fs::copy(simulated("quick_6mp") / "survey", site() / "survey");
    for (const char* table : {"control.csv", "plates.csv"})
      fs::copy_file(simulated("quick_6mp") / table, site() / table);
    photographs("quick_6mp", "left/");
  }
  void TearDown() override { fs::remove_all(site()); }

  static fs::path simulated(const std::string& camera) { return made->work() / camera / "site"; }
  static fs::path site() { return made->work() / "photos"; }
  /// Copies the photographs of a camera; `before` stands before their names.
  static void photographs(const std::string& camera, const std::string& before) {
    for (const auto& entry : fs::directory_iterator(simulated(camera) / "images")) {
      const fs::path to = site() / (before + entry.path().filename().string());
      fs::create_directories(to.parent_path());
      fs::copy_file(entry.path(), to);
      fs::permissions(to, fs::perms::owner_write, fs::perm_options::add);
    }
  }
  static void write(const std::string& name, const std::string& text) {
    fs::remove(site() / name);
    std::ofstream(site() / name, std::ios::binary) << text;
  }
  static std::string calibration(const std::string& camera) { return read_file(simulated(camera) / "camera.yaml"); }
  /// As one of several cameras of a file.
  static std::string under(const std::string& name, const std::string& yaml) {
    std::istringstream lines(yaml);
    std::string text = name + ":\n";
    for (std::string line; std::getline(lines, line);) text += "  " + line + "\n";
    return text;
  }
  /// The EXIF model of a photograph becomes one of the same length.
  static void take_with(const std::string& name, const std::string& model) {
    std::string bytes = read_file(site() / name);
    const size_t at = bytes.find("Quick 6MP");
    ASSERT_NE(at, std::string::npos) << name;
    write(name, bytes.replace(at, model.size(), model));
  }
  /// A photograph's EXIF becomes one that says the model and the body's serial number, of three digits.
  static void take_with_body(const std::string& name, const std::string& serial) {
    std::string bytes = read_file(site() / name);
    while (bytes.size() > 6 && bytes[2] == '\xff' &&
           (static_cast<unsigned char>(bytes[3]) & 0xf0U) == 0xe0U)  // its own APPn segments
      bytes.erase(2, 2 + 256 * static_cast<unsigned char>(bytes[4]) + static_cast<unsigned char>(bytes[5]));
    using namespace std::string_literals;
    // TIFF, little endian: model "A" and a pointer to the EXIF directory at 38, which has BodySerialNumber.
    const std::string tiff = "II\x2a\0\x08\0\0\0\x02\0"s + "\x10\x01\x02\0\x02\0\0\0A\0\0\0"s +
                             "\x69\x87\x04\0\x01\0\0\0\x26\0\0\0"s + "\0\0\0\0"s + "\x01\0\x31\xa4\x02\0\x04\0\0\0"s +
                             serial + "\0\0\0\0\0"s;
    const std::string segment = "Exif\0\0"s + tiff;
    const size_t length = segment.size() + 2;
    bytes.insert(2, "\xff\xe1"s + static_cast<char>(length / 256) + static_cast<char>(length % 256) + segment);
    write(name, bytes);
  }
  static Answer process(std::vector<std::string> more = {}) {
    fs::remove_all(made->work() / "out");
    more.insert(more.begin(),
                {"run", std::string(source_dir()) + "/pipelines/photo_campaign.yaml", "folder=photos", "--out", "out"});
    return (*made)(more);
  }
  static std::string page() { return read_file(made->work() / "out/report.html"); }
  static double rms_of_check_heights() {
    const auto metrics = nlohmann::json::parse(read_file(made->work() / "out/metrics.json"));
    EXPECT_EQ(metrics["comparisons"][0]["use"], "check");
    return metrics["comparisons"][0]["rmse_z"];
  }

  static Program* made;
};
Program* PhotoCampaign::made = nullptr;

TEST_F(PhotoCampaign, TwoCamerasAreOneBlock) {
  photographs("demo_24mp", "right/");
  const Answer folders = process();
  EXPECT_EQ(folders.code, 0) << folders.err;
  EXPECT_LT(rms_of_check_heights(), 0.001);
  for (const char* words : {"Camera</th><td>left, 3000 × 2000", "Camera</th><td>right, 6000 × 4000",
                            "Interior orientation", "3075.", "6151."})
    EXPECT_TRUE(contains(page(), words)) << words;
  // In one folder size and EXIF tell them apart.
  fs::remove_all(site() / "left"), fs::remove_all(site() / "right");
  photographs("quick_6mp", "a"), photographs("demo_24mp", "b");
  const Answer together = process();
  EXPECT_EQ(together.code, 0) << together.err;
  EXPECT_LT(rms_of_check_heights(), 0.001);
  for (const char* words : {"Plumbline Quick 6MP, 3000 × 2000", "Plumbline Demo 24MP, 6000 × 4000"})
    EXPECT_TRUE(contains(page(), words)) << words;
}

TEST_F(PhotoCampaign, EachCameraHasItsCalibration) {
  photographs("demo_24mp", "right/");
  write("camera.yaml", under("left", calibration("quick_6mp")) + under("right", calibration("demo_24mp")));
  const Answer sound = process();
  EXPECT_EQ(sound.code, 0) << sound.err;
  EXPECT_LT(rms_of_check_heights(), 0.001);
  std::string wrong = calibration("demo_24mp");
  wrong.replace(wrong.find("fx: 61"), 6, "fx: 58"), wrong.replace(wrong.find("fy: 61"), 6, "fy: 58");
  write("camera.yaml", under("left", calibration("quick_6mp")) + under("right", wrong));
  const Answer named = process();
  EXPECT_EQ(named.code, 3) << named.err;
  EXPECT_TRUE(contains(named.err, "the images contradict the calibration of camera right")) << named.err;
  EXPECT_FALSE(contains(named.err, "the calibration of camera left")) << named.err;
  // Calibrated in left/board and right/board: the folder that tells them apart counts.
  write("camera.yaml", under("left/board", calibration("quick_6mp")) + under("right/board", calibration("demo_24mp")));
  const Answer elsewhere = process();
  EXPECT_EQ(elsewhere.code, 0) << elsewhere.err;
  EXPECT_FALSE(contains(elsewhere.err, "left out")) << elsewhere.err;
  write("camera.yaml", under("left", calibration("quick_6mp")) + under("rihgt", calibration("demo_24mp")));
  const Answer misspelt = process();
  EXPECT_TRUE(contains(misspelt.err,
                       "left out: right/F01-01.jpg: is of camera 'right', which the file of calibrations "
                       "has not"))
      << misspelt.err;
}

/// One calibration is of one body at one focal length, and of one size.
TEST_F(PhotoCampaign, OneCalibrationIsNotThatOfAnotherCamera) {
  write("camera.yaml", calibration("quick_6mp"));
  photographs("demo_24mp", "right/");
  const Answer sizes = process();
  EXPECT_TRUE(contains(sizes.err,
                       "left out: right/F01-01.jpg: has 6000 x 4000 pixels, camera 'quick_6mp' has 3000 x "
                       "2000"))
      << sizes.err;
  fs::remove_all(site() / "right");
  take_with("left/F01-01.jpg", "Quick 7MP");
  const Answer odd = process();
  EXPECT_EQ(odd.code, 0) << odd.err;
  EXPECT_TRUE(contains(odd.err,
                       "left out: left/F01-01.jpg: was taken with another camera or focal length (Plumbline "
                       "Quick 7MP, 24 mm) than the others (Plumbline Quick 6MP, 24 mm)"))
      << odd.err;
  take_with("left/F01-02.jpg", "Quick 7MP");
  const Answer even = process();
  EXPECT_EQ(even.code, 1);
  EXPECT_TRUE(contains(even.err,
                       "the calibration is of one camera, 'quick_6mp', and by their EXIF the photographs are "
                       "of 2: Plumbline Quick 7MP, 24 mm (2 photographs); Plumbline Quick 6MP, 24 mm (2 "
                       "photographs)"))
      << even.err;
  EXPECT_FALSE(fs::exists(made->work() / "out/report.html"));
  EXPECT_EQ(process({"cameras=one"}).code, 0);
}

/// Two bodies of one model.
TEST_F(PhotoCampaign, TheSerialNumberTellsBodiesApart) {
  for (const auto& [name, serial] : {std::pair("left/F01-01.jpg", "111"), std::pair("left/F01-02.jpg", "111"),
                                     std::pair("left/F01-03.jpg", "222"), std::pair("left/F01-04.jpg", "222")})
    take_with_body(name, serial);
  write("camera.yaml", calibration("quick_6mp"));
  const Answer one = process();
  EXPECT_EQ(one.code, 1) << one.err;
  EXPECT_TRUE(contains(one.err, "by their EXIF the photographs are of 2: A 111 (2 photographs); A 222 (2 photographs)"))
      << one.err;
  EXPECT_EQ(process({"cameras=one"}).code, 0);
}

TEST_F(PhotoCampaign, CalibrationsInFoldersBelowAreNotReadAndNamed) {
  write("left/camera.yaml", calibration("quick_6mp"));
  const Answer answer = process();
  EXPECT_TRUE(contains(answer.err, "left/camera.yaml is not read")) << answer.err;
}

/// The tags' size, the survey's coordinates and the plate table, each against the others.
TEST_F(PhotoCampaign, TablesThatDoNotBelongTogetherAreNamed) {
  const std::string plates = read_file(site() / "plates.csv");
  const auto replaced = [](std::string text, const std::string& from, const std::string& to) {
    for (size_t at = 0; (at = text.find(from, at)) != std::string::npos; at += to.size())
      text.replace(at, from.size(), to);
    return text;
  };
  const auto expect_refused = [&](const Answer& answer, const std::string& words) {
    EXPECT_EQ(answer.code, 1) << answer.err;
    EXPECT_TRUE(contains(answer.err, words)) << answer.err;
    EXPECT_FALSE(fs::exists(made->work() / "out/report.html"));
  };
  write("plates.csv", replaced(plates, "tag36h11", "tag25h9"));
  expect_refused(process(), "no tag of the plate table is in the photographs: it has tag25h9:0, tag25h9:1, ");
  write("plates.csv", replaced(plates, ",200,0,200,0,", ",0.2,0,200,0,"));
  expect_refused(process(),
                 "by tag_size or the plate table 0.20 mm: one of them is in millimetres where metres are said");
  write("plates.csv", replaced(replaced(plates, "tag_size_mm", "tag_size_m"), ",200,0,200,0,", ",0.61,0,200,0,"));
  expect_refused(process(), "by tag_size or the plate table 0.610 m: one of them is in feet");
  // Without sizes only what a tag can measure says that the survey is in millimetres.
  fs::remove_all(site() / "survey"), fs::remove(site() / "plates.csv");
  write("control.csv",
        "id,east_m,north_m,height_m\n0,998,0,821\n1,3001,-3,818\n2,4994,-2,823\n3,1006,-1,2817\n4,3002,-6,2817\n"
        "5,5004,1,2818\n");
  const Answer unit = process();
  expect_refused(unit, "by the distances between the surveyed points the edge of a tag measures ");
  EXPECT_TRUE(contains(unit.err, "which no tag has: are the coordinates in metres")) << unit.err;
}

/// They were counted as anchors that nobody measured.
TEST_F(PhotoCampaign, TagsThatStandForNoPointAreNoAnchors) {
  fs::remove_all(site() / "survey"), fs::remove(site() / "plates.csv");
  write(
      "control.csv",
      "id,east_m,north_m,height_m,sigma_e_mm,sigma_n_mm,sigma_h_mm\n0,0.998,0,0.821,5,5,5\n1,3.001,-0.003,0.818,5,5,5\n"
      "3,1.006,-0.001,2.817,5,5,5\n5,5.004,0.001,2.818,5,5,5\n");
  const Answer answer = process();
  EXPECT_EQ(answer.code, 0) << answer.err;
  EXPECT_TRUE(contains(page(), "anchor"));
  for (const char* words : {"not measured", "does not list"})
    EXPECT_FALSE(contains(answer.out + answer.err, words)) << answer.out << answer.err;
}

TEST_F(PhotoCampaign, ExchangedPointsAreNamed) {
  fs::remove_all(site() / "survey"), fs::remove(site() / "plates.csv");
  const std::string head = "id,east_m,north_m,height_m\n0,0.998,0,0.821\n1,3.001,-0.003,0.818\n2,4.994,-0.002,0.823\n",
                    tail = "5,5.004,0.001,2.818\n6,2.002,0,1.824\n7,3.998,-0.001,1.819\n8,4.997,-0.006,1.822\n";
  write("control.csv", head + "4,1.006,-0.001,2.817\n3,3.002,-0.006,2.817\n" + tail);
  const Answer answer = process();
  EXPECT_EQ(answer.code, 1);
  EXPECT_TRUE(contains(answer.err, "points 3 and 4 are exchanged: the photographs show the tag of each 1.99"))
      << answer.err;
}

}  // namespace test_photo_campaign
}  // namespace plumbline::test
