#include "photo/detect/tag_detector.hpp"

#include <apriltag/apriltag.h>
#include <apriltag/common/zarray.h>

#include <algorithm>
#include <cmath>
#include <stdexcept>
#include <tuple>

#include "photo/detect/corner_refinement.hpp"
#include "photo/detect/likeness.hpp"
#include "photo/detect/tag_family.hpp"
#include "photo/detect/tag_pyramid.hpp"
#include "photo/images/grey_image.hpp"
#include "plumbline/stop.hpp"

namespace plumbline::detect {
namespace {

void check(const DetectorOptions& o) {
  const auto refuse = [](const std::string& what) { throw std::runtime_error("AprilTag detector: " + what); };
  if (o.families.empty()) refuse("no tag family is given; name at least one, such as tag36h11");
  const bool whole = o.decimate == std::floor(o.decimate);
  if (o.decimate != 0 && o.decimate != 1.5 && !(whole && o.decimate >= 1 && o.decimate <= 16))
    refuse("decimate is " + std::to_string(o.decimate) + "; possible are 0 (automatic), 1, 1.5, 2, 3, ... 16");
  if (o.bits_corrected < 0 || o.bits_corrected > 2)
    refuse("bits_corrected is " + std::to_string(o.bits_corrected) +
           "; possible are 0, 1 and 2 (3 would take gigabytes)");
  if (!(o.sigma_floor >= 0 && o.apriltag_sigma > 0)) refuse("sigma_floor and apriltag_sigma must be positive [px]");
}

/// Detections that libapriltag allocated, freed whatever happens.
using Detections = std::unique_ptr<zarray_t, void (*)(zarray_t*)>;

DetectedTag plain_tag(const apriltag_detection_t& found, double sigma) {
  DetectedTag tag;
  tag.family = found.family->name;
  tag.id = found.id;
  tag.hamming = found.hamming;
  tag.decision_margin = static_cast<double>(found.decision_margin);
  for (int i = 0; i < 4; ++i) {
    // libapriltag has the centre of the first pixel at (0.5, 0.5).
    tag.corners[i] = {found.p[i][0] - 0.5, found.p[i][1] - 0.5};
    tag.covariances[i] = Eigen::Matrix2d::Identity() * sigma * sigma;
  }
  return tag;
}

/// Whether `tags` has one of the same number where `tag` is.
bool known(const std::vector<DetectedTag>& tags, const DetectedTag& tag) {
  const auto centre = [](const DetectedTag& t) {
    return Eigen::Vector2d(0.25 * (t.corners[0] + t.corners[1] + t.corners[2] + t.corners[3]));
  };
  const double reach = 0.5 * (tag.corners[1] - tag.corners[0]).norm();
  return std::any_of(tags.begin(), tags.end(), [&](const DetectedTag& other) {
    return other.id == tag.id && other.family == tag.family && (centre(other) - centre(tag)).norm() < reach;
  });
}

}  // namespace

double decimation_for(int width, int height) {
  const double ratio = 1e-6 * width * height / 4.5;
  for (const double factor : {1.0, 1.5, 2.0, 3.0})
    if (ratio <= factor * factor) return factor;
  return std::ceil(std::sqrt(ratio));
}

struct TagDetector::Impl {
  DetectorOptions options;
  std::vector<TagFamily> families;         // before the detector: its destruction frees their tables
  std::unique_ptr<TagPyramid> small_tags;  // those that automatic decimation loses
  std::unique_ptr<TagPyramid> wide_tags;   // with a border of two cells, which libapriltag does not know
  std::vector<SquareFamily> weak;          // those whose codes many squares of a scene are read as
  std::unique_ptr<apriltag_detector_t, void (*)(apriltag_detector_t*)> detector{apriltag_detector_create(),
                                                                                apriltag_detector_destroy};

  explicit Impl(const DetectorOptions& o) : options(o) {
    check(options);
    std::vector<std::string> plain, wide;  // by the border's cells
    for (const std::string& name : options.families)
      (apriltag_square_family(name).border > 1 ? wide : plain).push_back(name);
    for (const std::string& name : plain) {
      families.push_back(make_tag_family(name));
      apriltag_family_t* family = families.back().get();
      apriltag_detector_add_family_bits(detector.get(), family,
                                        affordable_bits_corrected(*family, options.bits_corrected));
    }
    for (const std::string& name : plain) {
      const SquareFamily family = apriltag_square_family(name);
      if (chance_of(family) >= kWeakChance) weak.push_back(family);
    }
    detector->nthreads = 1;  // images are the unit of parallel work
    detector->refine_edges = true;
    wide_tags = pyramid(wide, 12);
    if (options.decimate == 0) small_tags = pyramid(plain, 24);
  }

  std::unique_ptr<TagPyramid> pyramid(const std::vector<std::string>& names, double smallest_tag) const {
    if (names.empty()) return nullptr;
    PyramidOptions search;
    search.refinement = Refinement::apriltag;
    search.smallest_tag = smallest_tag;
    search.max_hamming = std::min(options.max_hamming, options.bits_corrected);
    search.min_decision_margin = options.min_decision_margin;
    search.unrefined_sigma = options.apriltag_sigma;
    std::vector<SquareFamily> squares;
    for (const std::string& name : names) squares.push_back(apriltag_square_family(name));
    return std::make_unique<TagPyramid>(std::move(squares), search);
  }

  void search(const GreyImage& image, std::vector<DetectedTag>& tags, std::vector<Quadrilateral>& quadrilaterals) {
    detector->quad_decimate =
        static_cast<float>(options.decimate > 0 ? options.decimate : decimation_for(image.width, image.height));
    // libapriltag takes a pointer to non-const, but does not write to the image without quad_sigma.
    image_u8_t view{image.width, image.height, image.width, const_cast<std::uint8_t*>(image.pixels.data())};
    const Detections found(apriltag_detector_detect(detector.get(), &view), apriltag_detections_destroy);
    stop_point();
    for (int k = 0; k < zarray_size(found.get()); ++k) {
      apriltag_detection_t* detection = nullptr;
      zarray_get(found.get(), k, &detection);
      if (detection->hamming > options.max_hamming ||
          static_cast<double>(detection->decision_margin) < options.min_decision_margin)
        continue;
      tags.push_back(plain_tag(*detection, options.apriltag_sigma));
      quadrilaterals.push_back({tags.back().corners, detection->family->width_at_border});
    }
  }

  double chance_of(const SquareFamily& family) const {
    return chance_of_code(family.codes.size(), family.cells.size(),
                          std::min(options.max_hamming, options.bits_corrected));
  }

  /// Tags of weak families have to look like their drawing.
  void leave_out_unlike(const GreyImage& image, std::vector<DetectedTag>& tags) const {
    std::vector<const std::uint8_t*> rows;
    for (int y = 0; y < image.height; ++y)
      rows.push_back(image.pixels.data() + static_cast<std::ptrdiff_t>(y) * image.width);
    const PixelRows pixels{0, image.width, 0, image.height, rows.data()};
    for (const SquareFamily& family : weak) {
      const LikenessLimit limit = likeness_limit(chance_of(family));
      std::erase_if(tags, [&](const DetectedTag& tag) {
        const auto at = std::find(family.ids.begin(), family.ids.end(), tag.id);
        return tag.family == family.name && at != family.ids.end() &&
               !limit.holds(likeness(pixels, tag.corners, family, static_cast<size_t>(at - family.ids.begin())));
      });
    }
  }
};

TagDetector::TagDetector(const DetectorOptions& options) : impl_(std::make_unique<Impl>(options)) {}
TagDetector::~TagDetector() = default;
TagDetector::TagDetector(TagDetector&&) noexcept = default;
TagDetector& TagDetector::operator=(TagDetector&&) noexcept = default;

std::vector<DetectedTag> TagDetector::detect(const GreyImage& image) {
  const DetectorOptions& options = impl_->options;
  std::vector<DetectedTag> tags;
  if (image.width < 16 || image.height < 16) return tags;  // libapriltag's tiles do not fit
  std::vector<Quadrilateral> quadrilaterals;
  if (!impl_->families.empty()) impl_->search(image, tags, quadrilaterals);
  const auto add = [&](const TagPyramid& pyramid) {
    for (DetectedTag& tag : pyramid.detect(image).tags) {
      if (known(tags, tag)) continue;
      const SquareFamily family = apriltag_square_family(tag.family);
      quadrilaterals.push_back({tag.corners, family.modules});
      quadrilaterals.back().border = family.border;
      tags.push_back(std::move(tag));
    }
  };
  if (impl_->small_tags && impl_->detector->quad_decimate > 1) add(*impl_->small_tags);
  if (impl_->wide_tags) add(*impl_->wide_tags);
  if (options.refinement == Refinement::edges) {
    const Measurement measured = measure_corners(image, quadrilaterals, options.edge);
    for (std::size_t k = 0; k < tags.size(); ++k) {
      if (!measured.corners[k]) continue;
      tags[k].corners = measured.corners[k]->corners;
      for (int i = 0; i < 4; ++i)
        tags[k].covariances[i] = measured.corners[k]->covariances[i] +
                                 Eigen::Matrix2d::Identity() * options.sigma_floor * options.sigma_floor;
      tags[k].refined = true, tags[k].inset_sigma = measured.quality.inset_sigma;
    }
  }
  if (!impl_->weak.empty()) impl_->leave_out_unlike(image, tags);
  std::sort(tags.begin(), tags.end(), [](const DetectedTag& a, const DetectedTag& b) {
    const auto key = [](const DetectedTag& t) {
      return std::make_tuple(t.family, t.id, t.corners[0].x(), t.corners[0].y());
    };
    return key(a) < key(b);
  });
  return tags;
}

}  // namespace plumbline::detect
