// What is rendered must lie where the geometry says, to a few hundredths of a pixel: everything that is measured on
// simulated photographs rests on it.
#include <gtest/gtest.h>

#include <algorithm>

#include "jpeg.hpp"
#include "photo/detect/tag_detector.hpp"
#include "photo/images/grey_image.hpp"
#include "plate_raster.hpp"
#include "record.hpp"
#include "renderer.hpp"

namespace plumbline::simulate {
namespace test_renderer {

/// The demo camera at two fifths of its resolution: the same view in a sixth of the time.
SimulatedCamera small_camera(std::uint64_t seed) {
  CameraProfile profile = camera_profile("demo_24mp");
  BrownCamera& c = profile.nominal;
  c.width = 2400, c.height = 1600;
  for (double* value : {&c.fx, &c.fy, &c.cx, &c.cy}) *value *= 0.4;
  return make_camera(profile, seed);
}

GreyImage render(const Renderer& renderer) {
  GreyImage image;
  image.width = renderer.width();
  image.height = renderer.height();
  Renderer::Band band;
  for (int b = 0; b < renderer.bands(); ++b) {
    renderer.render(b, band);
    for (int r = 0; r < Renderer::band_rows && b * Renderer::band_rows + r < image.height; ++r) {
      const auto row = band.luma.begin() + r * renderer.padded_width();
      image.pixels.insert(image.pixels.end(), row, row + image.width);
    }
  }
  return image;
}

/// How far the border's edges lie from where the geometry has them [px], positive outwards; by the sum of reflectance
/// along lines of pixels across the edge, which for an area-correct image is exact.
struct EdgeOffset {
  double sum = 0;
  int n = 0;
};

/// Image of an edge of the tag at 65 points: the lens bends it by some hundredths of a pixel.
std::vector<Eigen::Vector2d> edge_curve(const Anchor& anchor, const BrownCamera& camera, const RigidTransform& pose,
                                        std::size_t edge) {
  const auto corners = tag_corners_in_plate(anchor.true_plate);
  std::vector<Eigen::Vector2d> curve;
  for (int k = 0; k <= 64; ++k) {
    const Eigen::Vector3d p = corners[edge] + k / 64.0 * (corners[(edge + 1) % 4] - corners[edge]);
    curve.push_back(*project(camera, pose * (anchor.building_from_plate * p)));
  }
  return curve;
}

/// Coordinate `across` of the curve where its other coordinate is `at`.
double crossing(const std::vector<Eigen::Vector2d>& curve, int across, double at) {
  for (std::size_t k = 0; k + 1 < curve.size(); ++k) {
    const double a = curve[k][1 - across] - at, b = curve[k + 1][1 - across] - at;
    if (a * b <= 0 && a != b) return curve[k][across] + a / (a - b) * (curve[k + 1][across] - curve[k][across]);
  }
  throw std::logic_error("the line does not meet the edge");
}

void add_edge(const PlateRaster& plate, const std::vector<Eigen::Vector2d>& curve, const Eigen::Vector2d& inside,
              double module, EdgeOffset& offset) {
  constexpr double white = 0.82, black = 0.05;
  const Eigen::Vector2d along = curve.back() - curve.front();
  const int across = std::abs(along.x()) > std::abs(along.y()) ? 1 : 0;  // the axis the sums run along
  const int line = 1 - across;
  const double sign = inside[across] > 0.5 * (curve.front() + curve.back())[across] ? 1 : -1;  // from white to black
  const double from = std::min(curve.front()[line], curve.back()[line]) + 1.5 * module;
  const double to = std::max(curve.front()[line], curve.back()[line]) - 1.5 * module;
  for (int i = static_cast<int>(std::ceil(from)); i <= to; ++i) {
    const double edge = crossing(curve, across, i);
    const int reach = static_cast<int>(0.7 * module), centre = static_cast<int>(std::lround(edge));
    double white_pixels = 0;
    for (int k = -reach; k <= reach; ++k) {
      const int column = (across == 0 ? centre + k : i) - plate.left, row = (across == 0 ? i : centre + k) - plate.top;
      const double value = plate.reflectance[row * plate.width + column];
      white_pixels += (value - black) / (white - black);
    }
    const double found = sign > 0 ? centre - reach - 0.5 + white_pixels : centre + reach + 0.5 - white_pixels;
    offset.sum += sign * (edge - found);
    ++offset.n;
  }
}

TEST(PlateRaster, EdgesLieWhereTheGeometrySays) {
  for (std::uint64_t seed = 1; seed <= 2; ++seed) {
    const Building b = make_building({.floors = 2}, seed);
    const SimulatedCamera camera = small_camera(seed);
    const RayGrid rays(camera.truth);
    for (const CameraStation& s : plan_camera_stations(b, camera, {.images_per_floor = 4}, seed)) {
      EdgeOffset all;
      for (const VisibleTag& tag : visible_tags(b, camera.truth, s.camera_from_building)) {
        // Sums across an edge must end within the white edge on one side and the black border on the other.
        const double module =
            std::min((tag.corners[0] - tag.corners[1]).norm(), (tag.corners[1] - tag.corners[2]).norm()) / 8;
        if (module < 5) continue;
        const PlateRaster plate = raster_plate(*tag.anchor, camera.truth, s.camera_from_building, rays, 0.6);
        const Eigen::Vector2d middle = 0.25 * (tag.corners[0] + tag.corners[1] + tag.corners[2] + tag.corners[3]);
        EdgeOffset one;
        for (std::size_t i = 0; i < 4; ++i) {
          add_edge(plate, edge_curve(*tag.anchor, camera.truth, s.camera_from_building, i), middle, module, one);
        }
        EXPECT_NEAR(one.sum / one.n, 0, 0.005) << s.image << " " << tag.anchor->id;
        all.sum += one.sum, all.n += one.n;
      }
      EXPECT_NEAR(all.sum / all.n, 0, 0.002) << s.image;
    }
  }
}

TEST(PlateRaster, CoversTheAreaOfThePlate) {
  const Building b = make_building({.floors = 1}, 1);
  const SimulatedCamera camera = small_camera(1);
  const RayGrid rays(camera.truth);
  const CameraStation s = plan_camera_stations(b, camera, {}, 1)[2];
  for (const VisibleTag& tag : visible_tags(b, camera.truth, s.camera_from_building, 60)) {
    const PlateRaster plate = raster_plate(*tag.anchor, camera.truth, s.camera_from_building, rays, 0.6);
    const PlateOutline o = plate_outline(tag.anchor->true_plate);
    double area = 0, covered = 0;
    std::array<Eigen::Vector2d, 4> corners;
    const double x[] = {-o.half_width, o.half_width, o.half_width, -o.half_width};
    const double y[] = {o.bottom, o.bottom, o.top, o.top};
    for (std::size_t i = 0; i < 4; ++i) {
      corners[i] = *project(
          camera.truth, s.camera_from_building * (tag.anchor->building_from_plate * Eigen::Vector3d(x[i], y[i], 0)));
    }
    for (std::size_t i = 0; i < 4; ++i) {
      const auto &p = corners[i], &q = corners[(i + 1) % 4];
      area += 0.5 * std::abs(p.x() * q.y() - p.y() * q.x()) * (p.x() * q.y() > p.y() * q.x() ? 1 : -1);
    }
    for (const float c : plate.coverage) covered += c;
    EXPECT_NEAR(covered / std::abs(area), 1, 1e-3) << tag.anchor->id;
  }
}

double corner_rms(const GreyImage& image, const std::vector<VisibleTag>& truth, detect::Refinement refinement,
                  std::size_t& found) {
  detect::DetectorOptions options;
  options.refinement = refinement;
  detect::TagDetector detector(options);
  double sum = 0;
  int n = 0;
  for (const auto& tag : detector.detect(image)) {
    for (const VisibleTag& t : truth) {
      if (t.anchor->tag_id != tag.id) continue;
      ++found;
      for (std::size_t i = 0; i < 4; ++i) sum += (tag.corners[i] - t.corners[i]).squaredNorm(), n += 2;
    }
  }
  return std::sqrt(sum / n);
}

TEST(Renderer, DetectedCornersAgreeWithTheTruth) {
  const Building b = make_building({.floors = 1}, 1);
  const SimulatedCamera camera = small_camera(1);
  const auto stations = plan_camera_stations(b, camera, {}, 1);
  for (const std::size_t i : {0u, 3u}) {
    const auto truth = visible_tags(b, camera.truth, stations[i].camera_from_building);
    for (const double noise : {i == 0 ? 0.0 : 1.0}) {
      RenderOptions options;
      options.noise_scale = noise;
      const GreyImage image = render(Renderer(b, camera, stations[i].camera_from_building, options));
      std::size_t found = 0;
      EXPECT_LT(corner_rms(image, truth, detect::Refinement::edges, found), noise > 0 ? 0.06 : 0.03)
          << stations[i].image;
      EXPECT_EQ(found, truth.size());
    }
  }
}

/// What perturbs plates is in the truth of the corners: twisted and displaced tags are found where that says.
TEST(Perturbations, OfPlatesAreInTheTruthOfTheCorners) {
  BuildingOptions options{.floors = 1};
  const Building plain = make_building(options, 1);
  options.flaws.plate_bend = 0.004, options.flaws.plate_offset_sigma = 0.005, options.flaws.mounting_sigma = 0.005;
  const Building flawed = make_building(options, 1);
  const SimulatedCamera camera = small_camera(1);
  const RigidTransform pose = plan_camera_stations(plain, camera, {}, 1)[0].camera_from_building;
  RenderOptions render_options;
  render_options.noise_scale = 0;
  const GreyImage image = render(Renderer(flawed, camera, pose, render_options));
  std::size_t found = 0, found_elsewhere = 0;
  const auto truth = visible_tags(flawed, camera.truth, pose);
  EXPECT_LT(corner_rms(image, truth, detect::Refinement::edges, found), 0.04);
  EXPECT_EQ(found, truth.size());
  EXPECT_GT(corner_rms(image, visible_tags(plain, camera.truth, pose), detect::Refinement::edges, found_elsewhere),
            0.5);
  EXPECT_EQ(flawed.anchors[3].built, plain.anchors[3].built);
  EXPECT_GT((flawed.anchors[3].target() - flawed.anchors[3].built).norm(), 1e-3);
}

/// The same view in a tenth of the demo camera's resolution.
GreyImage tiny_view(const Perturbations& perturbations) {
  CameraProfile profile = camera_profile("demo_24mp");
  BrownCamera& c = profile.nominal;
  c.width = 600, c.height = 400;
  for (double* value : {&c.fx, &c.fy, &c.cx, &c.cy}) *value *= 0.1;
  const SimulatedCamera camera = make_camera(profile, 1);
  const Building b = make_building({.floors = 1}, 1);
  RenderOptions options;
  options.noise_scale = 0;
  options.perturbations = perturbations;
  return render(Renderer(b, camera, look_at({4, -8, 2}, {4, 0, 2}, 0), options));
}

TEST(Perturbations, HaveEachItsEffectAndNoneOfThemIsTheIdealPicture) {
  const GreyImage ideal = tiny_view({});
  EXPECT_EQ(ideal.pixels, tiny_view(optics_of("ideal")).pixels);
  const auto changed = [&](auto member, double size) {
    Perturbations p;
    p.*member = size;
    return tiny_view(p).pixels != ideal.pixels;
  };
  EXPECT_TRUE(changed(&Perturbations::sharpening, 0.5));
  EXPECT_TRUE(changed(&Perturbations::motion_blur, 5));
  EXPECT_TRUE(changed(&Perturbations::rolling_shutter, 5));
  EXPECT_TRUE(changed(&Perturbations::ink_spread, 0.01));
  EXPECT_TRUE(changed(&Perturbations::dirt, 20));
  EXPECT_TRUE(changed(&Perturbations::glare, 1));
  EXPECT_TRUE(changed(&Perturbations::clutter, 1));
  EXPECT_THROW(optics_of("kind"), std::invalid_argument);
  EXPECT_GT(optics_of("real").sharpening, 0);
  Perturbations unknown;
  unknown.transfer = "film";
  EXPECT_THROW(tiny_view(unknown), std::invalid_argument);
}

TEST(Perturbations, TransferCurveIsThatOfSrgb) {
  Perturbations p;
  p.transfer = "srgb";
  const GreyImage linear = tiny_view({}), curved = tiny_view(p);
  std::size_t off = 0;
  for (std::size_t i = 0; i < linear.pixels.size(); ++i) {
    // A linear value stands for half a grey value up and down; at 0.04 and more of the light the curve is less than 4
    // steep.
    if (linear.pixels[i] < 10 || linear.pixels[i] > 254) continue;
    const double expected = 255 * (1.055 * std::pow(linear.pixels[i] / 255.0, 1 / 2.4) - 0.055);
    off += std::abs(curved.pixels[i] - expected) > 3;
  }
  EXPECT_EQ(off, 0u);
}

/// A camera's own picture has more contrast in the middle than sRGB: darks darker, lights lighter, ends and half as
/// they are.
TEST(Perturbations, TransferCurveOfACameraRaisesTheContrastOfTheMiddle) {
  Perturbations p;
  p.transfer = "camera";
  const GreyImage linear = tiny_view({}), curved = tiny_view(p);
  std::size_t off = 0, asked = 0;
  for (std::size_t i = 0; i < linear.pixels.size(); ++i) {
    if (linear.pixels[i] < 10 || linear.pixels[i] > 254) continue;
    const double v = 1.055 * std::pow(linear.pixels[i] / 255.0, 1 / 2.4) - 0.055;
    off += std::abs(curved.pixels[i] - 255 * (v + 0.24 * v * (1 - v) * (2 * v - 1))) > 4;
    ++asked;
  }
  EXPECT_GT(asked, 1000u);
  EXPECT_EQ(off, 0u);
}

TEST(Perturbations, LackOfLightIsNoise) {
  const auto noise = [](double stops) {
    Perturbations p;
    p.low_light = stops;
    const Building b = make_building({.floors = 1}, 1);
    CameraProfile profile = camera_profile("quick_6mp");
    const SimulatedCamera camera = make_camera(profile, 1);
    RenderOptions with, without;
    with.perturbations = without.perturbations = p;
    without.noise_scale = 0;
    const RigidTransform pose = look_at({4, -8, 2}, {4, 0, 2}, 0);
    Renderer::Band noisy, clean;
    Renderer(b, camera, pose, with).render(60, noisy);
    Renderer(b, camera, pose, without).render(60, clean);
    double sum = 0;
    for (std::size_t i = 0; i < clean.luma.size(); ++i) sum += std::pow(noisy.luma[i] - clean.luma[i], 2);
    return std::sqrt(sum / static_cast<double>(clean.luma.size()));
  };
  const double little = noise(2), much = noise(6);  // 2 and 8 times the noise of full light
  EXPECT_NEAR(much / little, 4, 0.4);
}

TEST(Renderer, AScaffoldHidesTheTagsThatItsGeometrySays) {
  const Building b = make_building({.floors = 1}, 1);
  const SimulatedCamera camera = small_camera(1);
  const RigidTransform pose = plan_camera_stations(b, camera, {}, 1)[0].camera_from_building;
  const auto all = visible_tags(b, camera.truth, pose);
  std::size_t hidden = 0;
  for (std::uint64_t seed = 1; seed <= 2; ++seed) {
    Obstruction scaffold = make_obstruction(b, {.scaffold_spacing = 2.0}, seed);
    const auto free = visible_tags(b, camera.truth, pose, 12, scaffold);
    const GreyImage image = render(Renderer(b, camera, pose, {}, scaffold));
    std::size_t found_free = 0, found = 0;
    EXPECT_LT(corner_rms(image, free, detect::Refinement::edges, found_free), 0.06);
    corner_rms(image, all, detect::Refinement::edges, found);
    EXPECT_EQ(found_free, free.size()) << "a tag that no tube touches is found";
    EXPECT_LE(found - found_free, 1u) << "a tag that a tube crosses is lost; one that it touches may be found";
    hidden += all.size() - free.size();
  }
  EXPECT_GE(hidden, 3u);
}

/// Means of squares of 100 pixels, and of the colours of each band, of a photograph with all that a photograph may
/// have.
TEST(Renderer, APhotographIsTheRecordedOne) {
  BuildingOptions options{.floors = 2};
  options.flaws = optics_of("real");
  const Building b = make_building(options, 4);
  const SimulatedCamera camera = small_camera(4);
  const RigidTransform pose = plan_camera_stations(b, camera, {}, 4)[2].camera_from_building;
  RenderOptions how;
  how.haze = 0.1, how.light_gradient = 0.3, how.exposure = 0.9, how.perturbations = options.flaws, how.seed = 9;
  const Renderer renderer(b, camera, pose, how, make_obstruction(b, {2.5, 1.2, 0.1}, 4));
  const GreyImage image = render(renderer);
  std::string text;
  for (int top = 0; top < image.height; top += 100) {
    for (int left = 0; left < image.width; left += 100) {
      double sum = 0;
      for (int y = top; y < top + 100; ++y)
        for (int x = left; x < left + 100; ++x) sum += image.pixels[static_cast<std::size_t>(y) * image.width + x];
      text += std::to_string(std::lround(sum / 10000)) + " ";
    }
    text += "\n";
  }
  Renderer::Band band;
  const auto mean = [](const std::vector<std::uint8_t>& values) {
    double sum = 0;
    for (const std::uint8_t value : values) sum += value;
    return std::to_string(std::lround(sum / static_cast<double>(values.size())));
  };
  for (int k = 0; k < renderer.bands(); k += 10) {
    renderer.render(k, band);
    text += "band " + std::to_string(k) + ": " + mean(band.blue) + " " + mean(band.red) + "\n";
  }
  test::expect_recorded("unit/simulate/recorded/photograph.txt", text);
}

TEST(Renderer, HazeLowersTheContrastAndLostPlatesAreGone) {
  const Building b = make_building({.floors = 1}, 1);
  const SimulatedCamera camera = small_camera(1);
  const RigidTransform pose = plan_camera_stations(b, camera, {}, 1)[0].camera_from_building;
  RenderOptions options;
  options.noise_scale = 0;
  const GreyImage clear = render(Renderer(b, camera, pose, options));
  options.haze = 0.5;
  const GreyImage hazy = render(Renderer(b, camera, pose, options));
  // Within a tag, where the light is the same: black and white come nearer to each other by the haze.
  const auto range = [](const GreyImage& image, const VisibleTag& tag) {
    int low = 255, high = 0;
    const Eigen::Vector2d centre = 0.5 * (tag.corners[0] + tag.corners[2]), reach(25, 25);
    for (int y = static_cast<int>(centre.y() - reach.y()); y < centre.y() + reach.y(); ++y)
      for (int x = static_cast<int>(centre.x() - reach.x()); x < centre.x() + reach.x(); ++x) {
        const int value = image.pixels[y * image.width + x];
        low = std::min(low, value), high = std::max(high, value);
      }
    return static_cast<double>(high - low);
  };
  for (const VisibleTag& tag : visible_tags(b, camera.truth, pose, 40))
    EXPECT_NEAR(range(hazy, tag) / range(clear, tag), 0.5, 0.02);
  Obstruction obstruction = make_obstruction(b, {.lost_plates = 1}, 1);
  EXPECT_TRUE(visible_tags(b, camera.truth, pose, 12, obstruction).empty());
  std::size_t found = 0;
  corner_rms(render(Renderer(b, camera, pose, options, obstruction)), visible_tags(b, camera.truth, pose),
             detect::Refinement::edges, found);
  EXPECT_EQ(found, 0u);
}

TEST(Renderer, NoiseIsOfTheSizeTheCameraHas) {
  const Building b = make_building({.floors = 1}, 1);
  SimulatedCamera camera = small_camera(1);
  camera.profile.read_noise = 3;
  camera.profile.shot_noise = 0.05;
  const RigidTransform pose = plan_camera_stations(b, camera, {}, 1)[0].camera_from_building;
  RenderOptions options;
  const GreyImage noisy = render(Renderer(b, camera, pose, options));
  options.noise_scale = 0;
  const GreyImage clean = render(Renderer(b, camera, pose, options));
  double sum = 0, sum2 = 0;
  for (std::size_t i = 0; i < clean.pixels.size(); ++i) {
    const double difference = (noisy.pixels[i] - clean.pixels[i]) / std::sqrt(9 + 0.05 * clean.pixels[i] + 1.0 / 6);
    sum += difference, sum2 += difference * difference;
  }
  const double n = static_cast<double>(clean.pixels.size());
  EXPECT_NEAR(sum / n, 0, 0.01);
  EXPECT_NEAR(std::sqrt(sum2 / n), 1, 0.02);
}

TEST(Jpeg, IsReadableAndTheSameEveryTime) {
  const Building b = make_building({.floors = 1}, 1);
  const SimulatedCamera camera = small_camera(1);
  const RigidTransform pose = plan_camera_stations(b, camera, {}, 1)[1].camera_from_building;
  const Renderer renderer(b, camera, pose, {});
  const ExifFields exif{"Maker", "Model", "2026:05:04 09:00:00", 0.024};
  const std::string first = encode_jpeg(renderer, 93, exif);
  EXPECT_EQ(first, encode_jpeg(Renderer(b, camera, pose, {}), 93, exif));
  EXPECT_NE(first, encode_jpeg(Renderer(b, camera, pose, {.seed = 2}), 93, exif));
}

TEST(TagModules, RefusesIdsTheFamilyLacks) {
  EXPECT_EQ(tag_modules(586).size(), 100u);
  EXPECT_THROW(tag_modules(587), std::invalid_argument);
  EXPECT_THROW(tag_modules(-1), std::invalid_argument);
}

}  // namespace test_renderer
}  // namespace plumbline::simulate
