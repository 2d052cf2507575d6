// What every detector of square tags must do, on drawings of a tag of the family tag36h11: find it where it is, corner
// by corner, with a covariance; the same bytes twice; and obey every parameter that it declares.
#include "artifacts/file.hpp"
#include "artifacts/image.hpp"
#include "artifacts/image_tags.hpp"
#include "node_harness.hpp"
#include "parameter_effects.hpp"
#include "stopping.hpp"
#include "tag_rendering.hpp"

namespace plumbline {
namespace detector_tests {

using namespace test;
using Settings = std::vector<std::pair<std::string, std::string>>;

TagScene scene(double side = 80) {
  TagScene scene;
  scene.corners = square_corners({100.3, 99.1}, side, 0.4);
  scene.noise = 1;
  return scene;
}

/// The place of a cell of the tag, which has eight each way; from the bottom left.
Eigen::Vector2d cell(const TagScene& drawn, double along, double up) {
  const auto& c = drawn.corners;
  return c[0] + (c[1] - c[0]) * along / 8 + (c[3] - c[0]) * up / 8;
}

size_t pixel(const GreyImage& image, const Eigen::Vector2d& p) {
  return static_cast<size_t>(std::lround(p.y()) * image.width + std::lround(p.x()));
}

/// The tag as a dictionary of OpenCV whose codes may be corrected; those of tag36h11 there are not.
FileT as_dictionary() {
  const GreyImage image = render(scene());
  std::string text = "nmarkers: 1\nmarkersize: 6\nmaxCorrectionBits: 5\nmarker_7: \"";
  for (int row = 6; row >= 1; --row)
    for (int column = 1; column <= 6; ++column)
      text += image.pixels[pixel(image, cell(scene(), column + 0.5, row + 0.5))] > 115 ? '1' : '0';
  FileT file;
  file.name = "own.yml";
  text += "\"\n";
  file.content.assign(text.begin(), text.end());
  return file;
}

/// The drawing with one bit of the code wrong: the cell in the third row and column of eight.
GreyImage with_a_wrong_bit() {
  GreyImage image = render(scene());
  const std::uint8_t grey = image.pixels[pixel(image, cell(scene(), 2.5, 2.5))] > 115 ? 40 : 190;
  for (double u = 2; u <= 3; u += 0.05)
    for (double v = 2; v <= 3; v += 0.05) image.pixels[pixel(image, cell(scene(), u, v))] = grey;
  return image;
}

class Detector : public testing::TestWithParam<std::string> {
 protected:
  /// The detector before a photograph in the file `name`; parameters that it does not have are passed over.
  NodeHarness before(const std::string& name, const Settings& settings) const {
    NodeHarness node(GetParam());
    if (node.has_parameter("dictionary", "tag36h11")) node.set("dictionary", "tag36h11");
    for (const auto& [parameter, value] : settings)
      if (node.has_parameter(parameter, value)) node.set(parameter, value);
    ImageT image;
    image.path = name;
    image.uri = (folder_.path() / name).string();
    node.input<Image>("images", image);
    return node;
  }
  Situation of(const std::string& name, const GreyImage& drawing, const Settings& settings = {}) const {
    write_png(folder_.path() / name, drawing);
    return [this, name, settings] { return before(name, settings); };
  }

 private:
  TemporaryFolder folder_;
};

TEST_P(Detector, FindsTheTagWhereItIsWithACovariance) {
  NodeHarness node = of("tag.png", render(scene()))();
  node.run();
  const ImageTagsT found = node.output<ImageTags>("observations");
  ASSERT_EQ(found.tags.size(), 1u);
  EXPECT_EQ(found.tags[0]->id, 7);
  ASSERT_EQ(found.tags[0]->corners.size(), 4u);
  ASSERT_EQ(found.tags[0]->corner_covariances.size(), 12u);
  for (size_t i = 0; i < 4; ++i) {
    EXPECT_LT((found.tags[0]->corners[i] - scene().corners[i]).norm(), 0.15) << "corner " << i;
    const double* c = &found.tags[0]->corner_covariances[3 * i];
    EXPECT_GT(c[0] * c[2], c[1] * c[1]) << "corner " << i;
    EXPECT_LT(std::max(c[0], c[2]), 0.5 * 0.5) << "corner " << i;
  }
}

TEST_P(Detector, GivesTheSameBytesTwice) {
  const Situation situation = of("tag.png", render(scene()));
  NodeHarness once = situation(), again = situation();
  once.run();
  again.run();
  EXPECT_EQ(once.output_bytes("observations"), again.output_bytes("observations"));
}

TEST_P(Detector, EveryDeclaredParameterHasItsEffect) {
  GreyImage negative = render(scene());
  for (auto& pixel : negative.pixels) pixel = static_cast<std::uint8_t>(255 - pixel);
  TagScene faint = scene();
  faint.black = 100, faint.white = 140, faint.noise = 0;
  TagScene cut = scene();
  cut.corners = square_corners({40.4, 100}, 80, 0);
  const Situation corrected = [this, wrong = of("bit.png", with_a_wrong_bit())] {
    NodeHarness node = wrong();
    if (node.has_parameter("dictionary", "")) node.input<File>("family", as_dictionary());
    return node;
  };
  const Situation plain = of("tag.png", render(scene()));
  const Situation missing = [this] { return before("missing.png", {}); };
  EXPECT_EQ(parameters_at_fault({plain, of("bit.png", with_a_wrong_bit()), corrected, of("negative.png", negative),
                                 of("faint.png", render(faint), {{"min_decision_margin", "0"}}),
                                 of("small.png", render(scene(13))), of("cut.png", render(cut)),
                                 of("tag.png", render(scene()), {{"refine", "apriltag"}}),
                                 of("tag.png", render(scene()), {{"refine", "opencv"}}), missing}),
            "");
}

/// A drawing of 200 × 200 pixels is done before a detector asks; of large photographs each tile asks.
TEST_P(Detector, StopsWhereverItAsks) {
  EXPECT_EQ(stopping_at_fault(of("tag.png", render(scene())), MayTakeLong::no), "");
}

INSTANTIATE_TEST_SUITE_P(All, Detector, testing::ValuesIn(kinds_of_role("detector")), test_name);

}  // namespace detector_tests
}  // namespace plumbline
