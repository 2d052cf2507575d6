// detect.apriltag, detect.aruco, detect.tag_pyramid: tags of one image; detect.collect: the tags of all images in one
// artifact; detect.board: the points of a calibration board;
// read.tag_family: the codes of a dictionary file; write.observations: the tags as a JSON file of their own.
#include "artifacts/image.hpp"
#include "artifacts/image_tags.hpp"
#include "artifacts/tag_observations.hpp"
#include "collect_nodes.hpp"
#include "detector_node.hpp"
#include "detector_pool.hpp"
#include "photo/detect/tag_detector.hpp"
#include "plumbline/node.hpp"
#include "pyramid_node.hpp"

namespace {

using namespace plumbline;
namespace pd = plumbline::detect;  // short, and apart from the contract's own `detail`

pd::DetectorPool& pool() {
  static pd::DetectorPool detectors;
  return detectors;
}

struct DetectAprilTag : Node {
  static constexpr Info info{"detect.apriltag", "detector", 4,
                             "Finds AprilTags and measures their corners in the full-resolution image"};
  Each<Image> images{"images", "photographs: JPEG, PNG or TIFF"};
  Optional<File> family{"family", "the family of read.tag_family, in place of `families`"};
  Out<ImageTags> observations{"observations", "the tags with the covariance of every corner"};
  Param<std::vector<std::string>> families{
      "families",
      {"tag36h11"},
      "tag36h11, tag36h10, tag25h9, tag16h5, tagCircle21h7, tagCircle49h12, tagCustom48h12, tagStandard41h12 or "
      "tagStandard52h13"};
  Param<double> decimate{
      "decimate", 0.0, between(0, 16),
      "reduction of the image for the search: 1, 1.5, 2, 3, ...; 0 leaves it about 4.5 megapixels. "
      "Tags smaller than 16 px times this are lost, with 0 those smaller than 24 px; corners keep their accuracy"};
  Param<int64_t> bits_corrected{"bits_corrected", 2, between(0, 2),
                                "bits a decoder may correct; families of 48 bits and more get 1 for their memory"};
  Param<int64_t> max_hamming{"max_hamming", 1, between(0, 2), "tags that needed more corrected bits are dropped"};
  Param<double> min_decision_margin{"min_decision_margin", 25.0, "grey levels", at_least(0),
                                    "tags that were decoded with less contrast are dropped"};
  Param<std::string> refine{"refine", "edges", one_of("edges", "apriltag"),
                            "edges: corners from a fit of the four edges, with its covariance; apriltag: libapriltag's "
                            "own corners, with one fixed covariance"};
  Param<double> curvature_sigma{"curvature_sigma", 2e-5, "1/px", at_least(0),
                                "how much a lens may bow a straight edge; 0: not at all"};
  Param<double> sigma_floor{"sigma_floor", 0.02, "px", between(0, 10), "added in quadrature to the fit's sigma"};
  Param<double> apriltag_sigma{"apriltag_sigma", 0.25, "px", between(0.001, 10),
                               "sigma of corners that are libapriltag's own"};

  Param<std::string> on_bad_image{"on_bad_image", "error", one_of("error", "leave_out"),
                                  "what to do with a photograph that cannot be read: stop, or go on without it"};

  void run(Context& context) override {
    // The file's bytes, the grey values, and what libapriltag takes: 30 bytes for each pixel of the reduced image.
    const double pixels = static_cast<double>(images->width()) * images->height();
    const double factor = *decimate > 0 ? *decimate : pd::decimation_for(images->width(), images->height());
    context.reserve_memory(
        static_cast<uint64_t>(static_cast<double>(images->size()) + pixels * (1 + 30 / (factor * factor))));
    const pd::DetectorOptions chosen = options();
    const auto search_with = [this](pd::DetectorOptions with) -> pd::SearchImage {
      return [this, with](const GreyImage& grey) {
        return pool().with_detector(key(with), with, [&](pd::TagDetector& detector) { return detector.detect(grey); });
      };
    };
    pd::SearchImage wide;
    if (pd::DetectorOptions other = chosen; pd::with_two_cells(other.families)) wide = search_with(other);
    observations.commit(
        pd::search_image(context, *images, *on_bad_image == "error", search_with(chosen), wide, chosen.families));
  }

 private:
  pd::DetectorOptions options() {
    pd::DetectorOptions o;
    o.families =
        family ? std::vector<std::string>{pd::apriltag_family_of(family->name()->str(), family->content()->size())}
               : *families;
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
  std::string key(const pd::DetectorOptions& chosen) const {
    using plumbline::detail::to_text;
    std::string text = to_text(chosen.families) + '|' + *refine;
    for (const double value : {*decimate, static_cast<double>(*bits_corrected), static_cast<double>(*max_hamming),
                               *min_decision_margin, *curvature_sigma, *sigma_floor, *apriltag_sigma})
      text += '|' + to_text(value);
    return text;
  }
};

}  // namespace

PLUMBLINE_PLUGIN("detect", PLUMBLINE_BUILD_ID, "MIT", DetectAprilTag, plumbline::detect::DetectTagPyramid,
                 plumbline::detect::CollectTags, plumbline::detect::ReadTagFamily, plumbline::detect::WriteObservations)
