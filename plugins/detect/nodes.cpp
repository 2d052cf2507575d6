// detect.apriltag: tags of one image; detect.collect: the tags of all images in one artifact.
#include "artifacts/image.hpp"
#include "artifacts/image_tags.hpp"
#include "artifacts/tag_observations.hpp"
#include "detect/detector_pool.hpp"
#include "detect/tag_detector.hpp"
#include "images/grey_image.hpp"
#include "plumbline/node.hpp"

namespace {

using namespace plumbline;
namespace pd = plumbline::detect;  // short, and apart from the contract's own `detail`

pd::DetectorPool& pool() {
  static pd::DetectorPool detectors;
  return detectors;
}

std::unique_ptr<TagT> tag_artifact(const pd::DetectedTag& found) {
  auto tag = std::make_unique<TagT>();
  tag->family = found.family;
  tag->id = found.id;
  tag->hamming = found.hamming;
  tag->decision_margin = static_cast<float>(found.decision_margin);
  for (int i = 0; i < 4; ++i) {
    tag->corners.push_back(found.corners[i]);
    const Eigen::Matrix2d& c = found.covariances[i];
    for (const double value : {c(0, 0), c(0, 1), c(1, 1)}) tag->corner_covariances.push_back(value);
  }
  return tag;
}

struct DetectAprilTag : Node {
  static constexpr Info info{"detect.apriltag", "detector", 2,
                             "Finds AprilTags and measures their corners in the full-resolution image"};
  Each<Image> images{"images", "photographs: JPEG, PNG or TIFF"};
  Out<ImageTags> observations{"observations", "the tags with the covariance of every corner"};
  Param<std::vector<std::string>> families{
      "families",
      {"tag36h11"},
      "tag36h11, tag36h10, tag25h9, tag16h5, tagCircle21h7, tagCircle49h12, tagCustom48h12, tagStandard41h12 or "
      "tagStandard52h13"};
  Param<double> decimate{"decimate", 0.0, between(0, 16),
                         "reduction of the image for the search: 1, 1.5, 2, 3, ...; 0 leaves it about 4.5 megapixels. "
                         "Tags smaller than 16 px times this are lost; corners keep their accuracy"};
  Param<int64_t> bits_corrected{"bits_corrected", 2, between(0, 2),
                                "bits a decoder may correct; families of 48 bits and more get 1 for their memory"};
  Param<int64_t> max_hamming{"max_hamming", 1, between(0, 2), "tags that needed more corrected bits are dropped"};
  Param<double> min_decision_margin{"min_decision_margin", 25.0, "grey levels", at_least(0),
                                    "tags that were decoded with less contrast are dropped"};
  Param<std::string> refine{"refine", "edges", one_of("edges", "apriltag"),
                            "edges: corners from a fit of the four edges, with its covariance; apriltag: libapriltag's "
                            "own corners, which scatter three times as much"};
  Param<double> curvature_sigma{"curvature_sigma", 2e-5, "1/px", at_least(0),
                                "how much a lens may bow a straight edge; 0: not at all"};
  Param<double> sigma_floor{"sigma_floor", 0.02, "px", between(0, 10), "added in quadrature to the fit's sigma"};
  Param<double> apriltag_sigma{"apriltag_sigma", 0.25, "px", between(0.001, 10),
                               "sigma of corners that are libapriltag's own"};

  void run(Context& context) override {
    // The file's bytes, the grey values, and what libapriltag takes: 30 bytes for each pixel of the reduced image.
    const double pixels = static_cast<double>(images->width()) * images->height();
    const double factor = *decimate > 0 ? *decimate : pd::decimation_for(images->width(), images->height());
    context.reserve_memory(
        static_cast<uint64_t>(static_cast<double>(images->size()) + pixels * (1 + 30 / (factor * factor))));

    const std::string path = context.resolve(images->uri()->str());
    const GreyImage grey = read_grey_image(path);
    if (images->width() > 0 && (grey.width != images->width() || grey.height != images->height()))
      throw std::runtime_error(path + " has " + std::to_string(grey.width) + " x " + std::to_string(grey.height) +
                               " pixels, but was registered with " + std::to_string(images->width()) + " x " +
                               std::to_string(images->height()) + "; it was changed since");
    const auto tags =
        pool().with_detector(key(), options(), [&](pd::TagDetector& detector) { return detector.detect(grey); });
    if (tags.empty()) context.warn("no tag found in " + images->path()->str());

    ImageTagsT result;
    result.path = images->path()->str();
    result.sha256 = images->sha256()->str();
    if (images->camera()) result.camera = images->camera()->str();
    result.width = grey.width;
    result.height = grey.height;
    for (const auto& tag : tags) result.tags.push_back(tag_artifact(tag));
    observations.commit(result);
  }

 private:
  pd::DetectorOptions options() const {
    pd::DetectorOptions o;
    o.families = *families;
    o.decimate = *decimate;
    o.bits_corrected = static_cast<int>(*bits_corrected);
    o.max_hamming = static_cast<int>(*max_hamming);
    o.min_decision_margin = *min_decision_margin;
    o.refinement = *refine == "edges" ? pd::Refinement::edges : pd::Refinement::apriltag;
    o.edge.curvature_sigma = *curvature_sigma;
    o.sigma_floor = *sigma_floor;
    o.apriltag_sigma = *apriltag_sigma;
    return o;
  }
  std::string key() const {
    using plumbline::detail::to_text;
    std::string text = to_text(*families) + '|' + *refine;
    for (const double value : {*decimate, static_cast<double>(*bits_corrected), static_cast<double>(*max_hamming),
                               *min_decision_margin, *curvature_sigma, *sigma_floor, *apriltag_sigma})
      text += '|' + to_text(value);
    return text;
  }
};

struct CollectTags : Node {
  static constexpr Info info{"detect.collect", "", 1, "Gathers the tags of all images in one artifact"};
  List<ImageTags> observations{"observations", "tags of each image"};
  Out<TagObservations> all{"observations", "the same, in the same order"};

  void run(Context&) override {
    TagObservationsT result;
    for (size_t i = 0; i < observations.size(); ++i)
      result.images.push_back(std::make_unique<ImageTagsT>(observations.unpack(i)));
    all.commit(result);
  }
};

}  // namespace

PLUMBLINE_PLUGIN("detect", "0.1.0", "MIT", DetectAprilTag, CollectTags)
