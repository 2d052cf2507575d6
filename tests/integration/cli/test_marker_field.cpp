// marker_field on public photographs (images/field2024) with one rotation of the layout wrong.
#include <array>
#include <cmath>
#include <nlohmann/json.hpp>

#include "program.hpp"
#include "test_paths.hpp"

namespace plumbline::test {
namespace test_marker_field {

namespace fs = std::filesystem;
using Json = nlohmann::json;

fs::path photographs() { return data_file("images/field2024"); }

/// The rotation of a tag, turned about an axis of the tag (its normal is x, up is z) [rad].
void turn(Json& layout, int id, size_t axis, double angle) {
  std::array<double, 3> v{};
  v[axis] = std::sin(0.5 * angle);
  const double c = std::cos(0.5 * angle);
  for (Json& tag : layout["field-tags"]) {
    if (tag["ID"] != id) continue;
    Json& q = tag["pose"]["rotation"]["quaternion"];
    const double w = q["W"], x = q["X"], y = q["Y"], z = q["Z"];
    q = {{"W", w * c - x * v[0] - y * v[1] - z * v[2]},
         {"X", w * v[0] + x * c + y * v[2] - z * v[1]},
         {"Y", w * v[1] - x * v[2] + y * c + z * v[0]},
         {"Z", w * v[2] + x * v[1] - y * v[0] + z * c}};
  }
}

TEST(MarkerField, ATagThatTheLayoutTurnsIsNamedAndLeavesThePosesAsTheyAre) {
  PLUMBLINE_REQUIRE_DATA("images/field2024");
  const Program plumbline{PLUMBLINE_PLUGIN_FOLDER};
  plumbline.write("camera.yaml",
                  "plumbline_camera: 1\nid: lifecam\nwidth: 1280\nheight: 720\npixel_origin: centre\nparameters: {fx: "
                  "1124.32, fy: 1123.77, cx: 625.55, cy: 331.70, k1: 0.1356, k2: -1.1339, k3: 2.1636, p1: -0.00306, "
                  "p2: -0.00122}\nsigmas: {fx: 1.9, fy: 1.9, cx: 1.1, cy: 1.1, k1: 0.0047, k2: 0.038, k3: 0.097, p1: "
                  "0.00026, p2: 0.00024}\n");
  const Json sound = Json::parse(read_file(photographs() / "2024-crescendo.json"));
  const auto centres = [&](const Json& layout, const std::string& words) {
    plumbline.write("layout.json", layout.dump());
    fs::remove_all(plumbline.work() / "out");
    const Answer answer = plumbline({"run", std::string(source_dir()) + "/pipelines/marker_field.yaml",
                                     "folder=" + photographs().string(), "layout=layout.json", "camera=camera.yaml",
                                     "tag_size=0.1651", "--out", "out"});
    EXPECT_EQ(answer.code, 0) << answer.err;
    EXPECT_TRUE(contains(answer.err, words)) << answer.err;
    EXPECT_EQ(contains(answer.err, "against the layout") || contains(answer.err, "or the layout is wrong"),
              !words.empty())
        << answer.err;
    std::vector<std::array<double, 3>> all;
    const Json poses = Json::parse(read_file(plumbline.work() / "out/poses.json"));
    for (const Json& image : poses["images"]) all.push_back(image["centre"]);
    return all;
  };
  const auto expected = centres(sound, "");
  ASSERT_EQ(expected.size(), 15u);
  // One of two neighbours that is tilted turns both by less than what their layout may be off.
  for (const auto& [id, axis, angle, words] :
       {std::tuple(7, 0, M_PI, "tag 7 is turned by 180 degrees about its normal"),
        std::tuple(4, 2, M_PI, "tag 4 is tilted by 179 degrees"),
        std::tuple(7, 1, M_PI / 9, "tag 7 is tilted by 19 degrees"),
        // Whether it was turned or moved is not to be told of so little; that it was one of them is.
        std::tuple(8, 2, M_PI / 18, "tag 8 is ")}) {
    Json layout = sound;
    turn(layout, id, static_cast<size_t>(axis), angle);
    const auto found = centres(layout, words);
    ASSERT_EQ(found.size(), expected.size());
    for (size_t i = 0; i < found.size(); ++i)
      EXPECT_LT(std::hypot(found[i][0] - expected[i][0], found[i][1] - expected[i][1], found[i][2] - expected[i][2]),
                0.05)
          << i;
  }
}

}  // namespace test_marker_field
}  // namespace plumbline::test
