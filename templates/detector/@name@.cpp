// detect.@name@: stands in for detect.apriltag wherever tags are looked for (tags.use=detect.@name@).
//
// It calls libapriltag. Put your own detector into find_tags(): it gets a grey image and gives ids and corners, and
// everything else stays as it is.
#include <apriltag/apriltag.h>
#include <apriltag/tag25h9.h>
#include <apriltag/tag36h11.h>

#include <memory>

#include "artifacts/file.hpp"
#include "artifacts/image.hpp"
#include "artifacts/image_tags.hpp"
#include "photo/images/grey_image.hpp"
#include "plumbline/node.hpp"

using namespace plumbline;

namespace {

struct Found {
  int id = 0;
  /// [px], the centre of the first pixel is (0, 0); bottom left, bottom right, top right, top left of the upright tag.
  std::array<Eigen::Vector2d, 4> corners;
};

std::vector<Found> find_tags(GreyImage& image, const std::string& family) {
  const bool is_36h11 = family == "tag36h11";
  const std::unique_ptr<apriltag_family_t, void (*)(apriltag_family_t*)> codes(
      is_36h11 ? tag36h11_create() : tag25h9_create(), is_36h11 ? tag36h11_destroy : tag25h9_destroy);
  const std::unique_ptr<apriltag_detector_t, void (*)(apriltag_detector_t*)> detector(apriltag_detector_create(),
                                                                                      apriltag_detector_destroy);
  apriltag_detector_add_family_bits(detector.get(), codes.get(), 1);
  detector->quad_decimate = 1;
  image_u8_t view = {image.width, image.height, image.width, image.pixels.data()};
  const std::unique_ptr<zarray_t, void (*)(zarray_t*)> found(apriltag_detector_detect(detector.get(), &view),
                                                             apriltag_detections_destroy);
  std::vector<Found> tags;
  for (int i = 0; i < zarray_size(found.get()); ++i) {
    apriltag_detection_t* one = nullptr;
    zarray_get(found.get(), i, &one);
    Found tag;
    tag.id = one->id;
    // libapriltag has the centre of the first pixel at (0.5, 0.5).
    for (size_t k = 0; k < 4; ++k) tag.corners[k] = {one->p[k][0] - 0.5, one->p[k][1] - 0.5};
    tags.push_back(tag);
  }
  return tags;
}

struct Detector : Node {
  static constexpr Info info{"detect.@name@", "detector", 1, "Finds AprilTags, with one sigma for all corners"};
  Each<Image> images{"images", "photographs: JPEG, PNG or TIFF"};
  Optional<File> family{"family", "not taken by this detector"};
  Param<std::string> dictionary{"dictionary", "tag36h11", one_of("tag36h11", "tag25h9"), "the tags to look for"};
  Param<double> corner_sigma{"corner_sigma", 0.2, "px", between(1e-3, 10), "standard deviation of a corner"};
  Out<ImageTags> observations{"observations", "the tags with the covariance of every corner"};

  void run(Context& context) override {
    if (family)
      throw std::runtime_error("a family from a file is not taken by detect.@name@: choose one by 'dictionary'");
    GreyImage image = read_grey_image(context.resolve(images->uri()->str()));
    ImageTagsT result;
    result.path = images->path()->str();
    result.sha256 = images->sha256()->str();
    if (images->camera()) result.camera = images->camera()->str();
    result.width = image.width, result.height = image.height;
    const double variance = *corner_sigma * *corner_sigma;
    for (const Found& found : find_tags(image, *dictionary)) {
      auto tag = std::make_unique<TagT>();
      tag->family = *dictionary;
      tag->id = found.id;
      for (const Eigen::Vector2d& corner : found.corners) {
        tag->corners.push_back(corner);
        tag->corner_covariances.insert(tag->corner_covariances.end(), {variance, 0, variance});  // xx, xy, yy [px^2]
      }
      result.tags.push_back(std::move(tag));
    }
    observations.commit(result);
  }
};

}  // namespace

PLUMBLINE_PLUGIN("@name@", "0.1.0", "MIT", Detector)
