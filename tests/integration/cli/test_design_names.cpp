// Designs and surveys that name anchors otherwise, through the whole program: nothing of the result may change but the
// names.
#include <algorithm>
#include <map>
#include <regex>

#include "program.hpp"
#include "test_paths.hpp"

namespace plumbline::test {
namespace test_design_names {

namespace fs = std::filesystem;

/// A small site, its results as it was made, and copies of it to be changed.
class DesignNames : public testing::Test {
 protected:
  void SetUp() override {
    plumbline.write(
        "make.yaml",
        "plumbline: 1\nvars: {seed: 5}\nnodes:\n  site: {use: simulate.campaign, with: {floors: 2, columns: "
        "3, camera: quick_6mp, images_per_floor: 4, photographs: observed}}\noutputs: {site: "
        "site.folder}\n");
    const Answer made = plumbline({"run", "make.yaml", "--out", "made"});
    ASSERT_EQ(made.code, 0) << made.err;
    fs::copy(plumbline.work() / "made/site", site(), fs::copy_options::recursive);
    for (const auto& entry : fs::recursive_directory_iterator(site()))
      fs::permissions(entry, fs::perms::owner_write, fs::perm_options::add);
    before = process();
    ASSERT_GT(before.size(), 10u);
    std::istringstream lines(text("plates.csv"));
    std::string line;
    std::getline(lines, line);
    while (std::getline(lines, line)) names.push_back(line.substr(0, line.find(',')));
  }

  fs::path site() const { return plumbline.work() / "site"; }
  std::string text(const std::string& name) const { return read_file(site() / name); }
  void rewrite(const std::string& name, const std::string& content) const {
    std::ofstream(site() / name, std::ios::binary) << content;
  }

  /// Rows of metrics.csv by anchor; the as-built file is checked on the way.
  std::map<std::string, std::string> process() {
    answer = plumbline(
        {"run", std::string(source_dir()) + "/pipelines/site_observations.yaml", "folder=site", "--out", "out"});
    EXPECT_EQ(answer.code, 0) << answer.err;
    as_built = answer.code == 0 ? read_file(plumbline.work() / "out/as_built.ifc") : "";
    std::map<std::string, std::string> rows;
    std::istringstream lines(answer.code == 0 ? read_file(plumbline.work() / "out/metrics.csv") : "");
    std::string line;
    std::getline(lines, line);
    while (std::getline(lines, line)) rows[line.substr(0, line.find(','))] = line.substr(line.find(','));
    EXPECT_EQ(count("'ASB_AnchorDeviation'"), rows.size());
    return rows;
  }
  std::size_t count(const std::string& part) const {
    std::size_t found = 0;
    for (std::size_t at = 0; (at = as_built.find(part, at)) != std::string::npos; ++at) ++found;
    return found;
  }

  static std::string replaced(std::string text, const std::string& from, const std::string& to) {
    for (std::size_t at = 0; (at = text.find(from, at)) != std::string::npos; at += to.size())
      text.replace(at, from.size(), to);
    return text;
  }
  static std::string padded(const std::string& name) { return std::string(16 - name.size(), '0') + name; }

  /// The survey as an instrument writes it that holds `width` characters of a name, and a table from these to elements.
  void rename(std::size_t width, const std::string& stem) {
    std::string gsi = text("survey/total_station.gsi"), plates = text("plates.csv"), table = "point,element\n";
    const std::string design = text("design.ifc");
    for (std::size_t i = 0; i < names.size(); ++i) {
      const std::string name = stem + std::to_string(100 + i);
      ASSERT_EQ(name.size(), width);
      renamed[names[i]] = name;
      gsi = replaced(gsi, padded(names[i]), padded(name));
      plates = replaced(plates, "\n" + names[i] + ",", "\n" + name + ",");
      // By GlobalId and by name in turn.
      std::smatch guid;
      const std::regex element("IFCMECHANICALFASTENER\\('([^']*)',#\\d+,'" + names[i] + "'");
      ASSERT_TRUE(std::regex_search(design, guid, element)) << names[i];
      table += name + "," + (i % 2 ? guid[1].str() : names[i]) + "\n";
    }
    if (width == 8) {
      // GSI-8: no asterisk, eight digits a word.
      gsi = std::regex_replace(gsi, std::regex("51\\.\\.1\\.\\+00000000\\+0000000"), "51....+0000+000");
      gsi = std::regex_replace(gsi, std::regex("([+-])0{8}([0-9A-Z-]{8})"), "$1$2");
      gsi = replaced(gsi, "*", "");
    }
    rewrite("survey/total_station.gsi", gsi);
    rewrite("plates.csv", plates);
    rewrite("names.csv", table);
    rewrite("campaign.yaml", text("campaign.yaml") + "mapping: names.csv\n");
  }

  void expect_renamed(const std::map<std::string, std::string>& after) const {
    ASSERT_EQ(after.size(), before.size());
    for (const auto& [name, row] : before) EXPECT_EQ(after.at(renamed.at(name)), row) << name;
    EXPECT_EQ(count("IFCLABEL('mapping')"), before.size());
    for (const auto& [name, point] : renamed) EXPECT_EQ(count("IFCLABEL('" + point + "')"), 1u) << point;
  }

  const Program plumbline{PLUMBLINE_PLUGIN_FOLDER};
  Answer answer;
  std::string as_built;
  std::vector<std::string> names;
  std::map<std::string, std::string> before, renamed;
};

TEST_F(DesignNames, SixteenCharactersOfGsiThroughTheMappingTable) {
  rename(16, "TOWER-EAST-P-");
  expect_renamed(process());
}

TEST_F(DesignNames, EightCharactersOfGsiThroughTheMappingTable) {
  rename(8, "P0000");
  EXPECT_EQ(text("survey/total_station.gsi").find('*'), std::string::npos);
  expect_renamed(process());
}

TEST_F(DesignNames, AllNamedAlikeWithTheNameInTheTag) {
  const std::string design = text("design.ifc");
  rewrite("design.ifc",
          std::regex_replace(design, std::regex("(IFCMECHANICALFASTENER\\('[^']*',#\\d+,)'[^']*'"), "$1'ANKER'"));
  EXPECT_EQ(process(), before);
  EXPECT_EQ(count("IFCLABEL('tag')"), before.size());
}

TEST_F(DesignNames, AllInOneStoreyCostsTheFloorStatisticsOnly) {
  EXPECT_EQ(count("'ASB_FloorStatistics'"), 2u);
  std::string design = text("design.ifc");
  const std::regex containment("(IFCRELCONTAINEDINSPATIALSTRUCTURE\\([^;]*,)(#\\d+)\\);");
  std::smatch first;
  ASSERT_TRUE(std::regex_search(design, first, containment));
  rewrite("design.ifc", std::regex_replace(design, containment, "$1" + first[2].str() + ");"));
  EXPECT_EQ(process(), before);
  EXPECT_EQ(count("'ASB_FloorStatistics'"), 0u);
  EXPECT_TRUE(contains(answer.err, "2 floors of the plate table have their anchors in one storey of design.ifc"))
      << answer.err;
}

}  // namespace test_design_names
}  // namespace plumbline::test
