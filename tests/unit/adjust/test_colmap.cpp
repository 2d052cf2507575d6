// The program COLMAP beside our own adjustment of the same observations, and what happens if it is not there, fails,
// takes too long or is no longer wanted.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <csignal>
#include <fstream>

#include "photo/colmap/reconstruction.hpp"
#include "photo/colmap/tag_block.hpp"
#include "plumbline/stop.hpp"
#include "synthetic_block.hpp"
#include "test_support.hpp"

namespace test_colmap {

using namespace plumbline;
using namespace plumbline::colmap;
using testing::HasSubstr;

#define REQUIRE_COLMAP() \
  if (!is_installed()) GTEST_SKIP() << "the program colmap is not installed (apt install colmap)"

/// Sets a variable of the environment for the length of a test.
class Setting {
 public:
  Setting(const char* name, const std::string& value) : name_(name) {
    if (const char* old = std::getenv(name)) was_set_ = true, old_ = old;
    setenv(name, value.c_str(), 1);
  }
  ~Setting() { was_set_ ? setenv(name_, old_.c_str(), 1) : unsetenv(name_); }

 private:
  const char* name_;
  bool was_set_ = false;
  std::string old_;
};

/// A program `colmap` made of lines of shell, in the place of the true one; nothing may stay in its TMPDIR.
class FakeProgram {
 public:
  explicit FakeProgram(const std::string& lines) {
    std::filesystem::create_directories(folder_.path() / "tmp");
    if (!lines.empty()) {
      std::ofstream(folder_.path() / "colmap") << "#!/bin/sh\n" << lines << "\n";
      std::filesystem::permissions(folder_.path() / "colmap", std::filesystem::perms::owner_all);
    }
    path_ = std::make_unique<Setting>("PATH", folder_.path().string() + (lines.empty() ? "" : ":/usr/bin:/bin"));
    temporary_ = std::make_unique<Setting>("TMPDIR", (folder_.path() / "tmp").string());
  }
  bool left_nothing() const { return std::filesystem::is_empty(folder_.path() / "tmp"); }
  /// The process whose number the lines wrote to the file `number` is gone.
  bool has_ended() const {
    const std::string number = test::read_file(folder_.path() / "number");
    return number.empty() || (kill(std::stoi(number), 0) != 0 && errno == ESRCH);
  }
  std::filesystem::path folder() const { return folder_.path(); }

 private:
  test::TemporaryFolder folder_;
  std::unique_ptr<Setting> path_, temporary_;
};

test::SyntheticBlock small_block() {
  test::SyntheticBlock synthetic = test::make_block({.floors = 1, .stations = 2});
  synthetic.use_control(synthetic.choose([](int, int, int) { return true; }));
  return synthetic;
}

std::string failure_of(const block::TagBlock& block, const TagBlockOptions& options = {}) {
  try {
    adjust_plates(block, options);
  } catch (const std::runtime_error& error) {
    return error.what();
  }
  return "(no error)";
}

TEST(ColmapProgram, ThatIsMissingIsNamedWithTheMend) {
  const FakeProgram none("");
  EXPECT_FALSE(is_installed());
  EXPECT_THAT(failure_of(small_block().block), HasSubstr("apt install colmap"));
  EXPECT_TRUE(none.left_nothing());
}

TEST(ColmapProgram, ThatFailsIsQuoted) {
  const FakeProgram failing("echo 'F1122 no such thing' >&2; exit 3");
  EXPECT_THAT(
      failure_of(small_block().block),
      testing::AllOf(HasSubstr("'colmap bundle_adjuster' failed with exit code 3"), HasSubstr("no such thing")));
  EXPECT_TRUE(failing.left_nothing());
}

TEST(ColmapProgram, ThatDiesOrLeavesNoModelIsAnError) {
  const FakeProgram dying("kill -SEGV $$");
  EXPECT_THAT(failure_of(small_block().block), HasSubstr("died of signal 11"));
  const FakeProgram silent("echo 'Termination : Convergence'");
  EXPECT_THAT(failure_of(small_block().block), HasSubstr("is no COLMAP model"));
  EXPECT_TRUE(silent.left_nothing());
}

TEST(ColmapProgram, ThatDoesNotConvergeIsAnError) {
  const FakeProgram slow("echo ' Iterations : 100'; echo ' Termination : No convergence'");
  EXPECT_THAT(failure_of(small_block().block), HasSubstr("did not converge in 100 iterations"));
}

TEST(ColmapProgram, ThatTakesTooLongIsEnded) {
  const FakeProgram endless("echo $$ > \"$(dirname $0)/number\"; exec sleep 30");
  TagBlockOptions options;
  options.bundle.time_limit = 0.2;
  EXPECT_THAT(failure_of(small_block().block, options), HasSubstr("took longer than time_limit, 0.2 s"));
  EXPECT_TRUE(endless.left_nothing());
  EXPECT_TRUE(endless.has_ended());
}

TEST(ColmapBlock, RefusesALensThatItHasNot) {
  auto distances = small_block().block, shifts = small_block().block;
  distances.cameras[0].distance_terms.x() = 0.01;
  distances.cameras[0].reference_distance = 8;
  shifts.images[1].principal_point.y() = 0.5;
  for (const auto& block : {distances, shifts})
    EXPECT_THAT(test::error_of([&] { adjust_plates(block, {}); }),
                testing::HasSubstr("COLMAP has neither distortion that changes with the distance"));
}

TEST(ColmapProgram, IsEndedWhenNobodyWaitsForIt) {
  const FakeProgram endless("echo $$ > \"$(dirname $0)/number\"; exec sleep 30");
  const std::filesystem::path started = endless.folder() / "number";
  const StopScope scope(
      [](const void* file) { return std::filesystem::exists(*static_cast<const std::filesystem::path*>(file)); },
      &started);
  EXPECT_THROW(adjust_plates(small_block().block, {}), Stopped);
  EXPECT_TRUE(endless.left_nothing());
  EXPECT_TRUE(endless.has_ended());
}

/// The same corners as single points through our own engine: same minimum, same shape. Half a pixel, an axis, the order
/// of a quaternion or of the coefficients that is wrong on the way out or back would show here.
void expect_minimum_of_colmap(const test::SyntheticBlock& synthetic) {
  bundle::Problem problem;
  bundle::State state;
  problem.groups = {{"images"}};
  const bool is_fisheye = synthetic.camera.lens == LensModel::fisheye;
  std::vector<bool> free(8, true);
  if (!is_fisheye) free = {true, true, true, true, true, true, false, true, true, false, false};
  problem.cameras = {{"camera", bundle::lens_of(synthetic.camera.lens), 0, free}};
  state.interiors.emplace_back();
  const auto values = synthetic.camera.parameters();
  std::copy(values.begin(), values.end(), state.interiors[0].begin());
  for (const auto& image : synthetic.block.images) {
    problem.images.push_back({image.name});
    state.images.emplace_back();
    state.images.back().set(image.cam_from_world->rotation, image.cam_from_world->inverse().translation);
  }
  for (size_t j = 0; j < synthetic.anchors.size(); ++j)
    for (const auto& corner : tag_corners_in_plate(synthetic.block.plates[j].plate)) {
      problem.points.push_back({"corner"});
      state.points.push_back(synthetic.anchors[j] + synthetic.world_from_plate[j] * corner);
    }
  for (const auto& seen : synthetic.block.observations)
    for (size_t k = 0; k < 4; ++k)
      problem.image_points.push_back({seen.image, 4 * seen.plate + static_cast<int>(k), seen.corners[k]});

  bundle::State theirs = state, ours = state;
  adjust_by_colmap(problem, theirs, {true, true, true, 200, 60});
  bundle::minimise_schur(problem, ours, {});
  const bundle::Layout layout(problem);
  bundle::Elimination at_theirs(problem, layout), at_ours(problem, layout);
  ASSERT_TRUE(at_theirs.build(theirs));
  ASSERT_TRUE(at_ours.build(ours));
  EXPECT_NEAR(at_theirs.sum_of_squares() / at_ours.sum_of_squares(), 1, 1e-9);
  for (size_t v = 0; v < 9; ++v)
    EXPECT_NEAR(theirs.interiors[0][v], ours.interiors[0][v], 1e-4 * std::max(1.0, std::abs(ours.interiors[0][v])))
        << v;
}

TEST(ColmapBlock, FindsTheMinimumThatOurEngineFinds) {
  REQUIRE_COLMAP();
  expect_minimum_of_colmap(small_block());
}

TEST(ColmapBlock, FindsTheMinimumThatOurEngineFindsThroughAFisheye) {
  REQUIRE_COLMAP();
  expect_minimum_of_colmap(test::make_block({.floors = 1, .fisheye = true}));
}

TEST(ColmapBlock, PutsPlatesWhereOurAdjustmentPutsThem) {
  REQUIRE_COLMAP();
  test::SyntheticBlock synthetic = test::make_block({.floors = 2});
  synthetic.use_control(synthetic.choose([](int, int, int) { return true; }));
  block::TagBlock calibrated = synthetic.block;
  calibrated.cameras[0].interior = synthetic.camera;
  TagBlockOptions options;
  options.bundle.refine_focal_length = options.bundle.refine_extra_params = false;
  block::TagBlockOptions own;
  own.self_calibration = false;
  const auto theirs = adjust_plates(calibrated, options), ours = block::adjust_tag_block(calibrated, own);
  ASSERT_EQ(theirs.plates, ours.plates);
  EXPECT_NEAR(theirs.sigma0, 1, 0.05);
  EXPECT_NEAR(theirs.batches.at(0).scale, 1, 2e-4);
  // Corners that need not form squares cost accuracy, but less than the survey's 1 mm.
  for (size_t j = 0; j < ours.plates.size(); ++j)
    EXPECT_LT((theirs.anchors - ours.anchors).segment<3>(3 * static_cast<Eigen::Index>(j)).norm(), 1e-3);
  for (size_t k = 0; k < theirs.control.size(); ++k)
    EXPECT_NEAR(theirs.control[k].coordinates[2].residual, ours.control[k].coordinates[2].residual, 1e-3);
  EXPECT_EQ(theirs.anchor_covariance.size(), 0);
}

TEST(ColmapBlock, WithoutControlHasTheScaleOfItsTags) {
  REQUIRE_COLMAP();
  test::SyntheticBlock synthetic = small_block();
  synthetic.block.control = {};
  for (auto& plate : synthetic.block.plates) plate.plate.tag_size *= 2;  // not what was photographed
  for (auto& image : synthetic.block.images) image.cam_from_world.reset();
  const auto first = &synthetic.block.images[0];
  first->cam_from_world = synthetic.cam_from_world[0];
  const auto found = adjust_plates(synthetic.block, {});
  const auto distance = [](const Eigen::VectorXd& x, Eigen::Index a, Eigen::Index b) {
    return (x.segment<3>(3 * a) - x.segment<3>(3 * b)).norm();
  };
  ASSERT_EQ(found.plates.size(), synthetic.anchors.size());
  const double truth = (synthetic.anchors[0] - synthetic.anchors[7]).norm();
  EXPECT_NEAR(distance(found.anchors, 0, 7), 2 * truth, 0.01 * truth);
  EXPECT_NEAR(found.batches.at(0).scale, 1, 1e-9);
  EXPECT_TRUE(found.control.empty());
}

TEST(ColmapBlock, LeavesOutAPlateOfOneImageAndSaysSo) {
  REQUIRE_COLMAP();
  test::SyntheticBlock synthetic = small_block();
  int kept = 0;
  std::erase_if(synthetic.block.observations, [&](const auto& seen) { return seen.plate == 3 && kept++ > 0; });
  const auto found = adjust_plates(synthetic.block, {});
  EXPECT_THAT(found.left_out, testing::Contains(HasSubstr(synthetic.block.plates[3].anchor + ": seen in one image")));
  EXPECT_THAT(found.plates, testing::Not(testing::Contains(3)));
}

/// COLMAP says "convergence" of a block of two parts.
TEST(ColmapBlock, RefusesWhatImagesDoNotHoldTogether) {
  REQUIRE_COLMAP();
  test::SyntheticBlock synthetic = small_block();
  const size_t half = synthetic.block.images.size() / 2;
  std::erase_if(synthetic.block.observations,
                [&](const auto& seen) { return (static_cast<size_t>(seen.image) < half) != (seen.plate % 2 == 0); });
  EXPECT_THAT(failure_of(synthetic.block), HasSubstr("falls into 2 parts"));
}

/// A folder with photographs as far as their names go, and one file that is none.
struct Photographs {
  explicit Photographs(int count) {
    for (int i = 0; i < count; ++i) std::ofstream(folder.path() / ("p" + std::to_string(i) + ".jpg")) << "x";
    std::ofstream(folder.path() / "notes.txt") << "x";
  }
  test::TemporaryFolder folder;
};

/// Writes two models of two and three photographs where the mapper is told to, and what it was told beside itself.
constexpr const char* fake_reconstruction = R"sh(
command=$1; echo "$@" >> "$(dirname "$0")/told"
while [ $# -gt 0 ]; do
  [ "$1" = --output_path ] && out=$2
  [ "$1" = --image_list_path ] && cp "$2" "$(dirname "$0")/list"
  shift
done
[ $command = mapper ] || exit 0
for m in 0 1; do
  mkdir "$out/$m"
  echo "1 SIMPLE_RADIAL 640 480 500 320 240 0.1" > "$out/$m/cameras.txt"
  : > "$out/$m/points3D.txt"
  for i in $(seq 1 $((2 + m))); do printf '%d 1 0 0 0 %d 0 0 1 p%d.jpg\n\n' $i $i $i; done > "$out/$m/images.txt"
done
)sh";

TEST(Reconstruct, TakesTheLargestModelAndNamesWhatIsNotInIt) {
  const Photographs photographs(5);
  const FakeProgram program(fake_reconstruction);
  ReconstructionOptions options;
  options.one_camera = false;
  const Reconstruction found = reconstruct(photographs.folder.path(), options);
  EXPECT_EQ(found.model.images.size(), 3u);
  EXPECT_THAT(found.unregistered, testing::ElementsAre("p0.jpg", "p4.jpg"));
  EXPECT_THAT(found.warnings, testing::ElementsAre(HasSubstr("2 models of 2, 3 photographs")));
  EXPECT_EQ(test::read_file(program.folder() / "list"), "p0.jpg\np1.jpg\np2.jpg\np3.jpg\np4.jpg\n");
  const std::string told = test::read_file(program.folder() / "told");
  for (const char* word : {"--SiftExtraction.use_gpu 0", "--SiftMatching.use_gpu 0", "--SiftExtraction.num_threads 1",
                           "--Mapper.num_threads 1", "--ImageReader.single_camera 0"})
    EXPECT_THAT(told, HasSubstr(word));
  EXPECT_TRUE(program.left_nothing());
}

TEST(Reconstruct, SaysWhatIsMissing) {
  const Photographs one(1), several(3);
  {
    const FakeProgram program("exit 0");
    EXPECT_THAT(test::error_of([&] { reconstruct(one.folder.path(), {}); }), HasSubstr("has 1 photographs"));
    EXPECT_THAT(test::error_of([&] { reconstruct(several.folder.path(), {}); }),
                HasSubstr("COLMAP found no two photographs to begin with"));
  }
  const FakeProgram absent("");
  EXPECT_THAT(test::error_of([&] { reconstruct(several.folder.path(), {}); }), HasSubstr("apt install colmap"));
}

}  // namespace test_colmap
