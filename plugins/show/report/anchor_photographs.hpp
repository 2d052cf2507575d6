// What the photographs show of the anchors that are not in order: a part of the best ones, with the marker as it was
// detected and the place where the design has it.
#pragma once

#include <Eigen/Core>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "artifacts/camera.hpp"
#include "artifacts/deviation.hpp"
#include "artifacts/image_tags.hpp"
#include "artifacts/plates.hpp"
#include "artifacts/poses.hpp"

namespace plumbline::report {

/// A part of a photograph around an anchor's marker. Places are in pixels of the photograph, from the part's corner.
struct AnchorPhotograph {
  std::string anchor, photograph, tag;
  ToleranceVerdict verdict = ToleranceVerdict::not_measured;
  std::string jpeg;                                 ///< grey
  double width = 0, height = 0;                     ///< of the part [px of the photograph]
  std::vector<Eigen::Vector2d> outline;             ///< of the marker
  std::optional<Eigen::Vector2d> design, as_built;  ///< the surveyed point; nothing without a pose in its frame
};

struct AnchorPhotographs {
  std::vector<AnchorPhotograph> parts;          ///< in the order of worst_first()
  std::vector<std::string> not_shown;           ///< anchors that are not in order and that no photograph at hand shows
  std::map<std::string, std::string> not_read;  ///< photographs that cannot be opened, with the reason
  /// Anchors that a photograph at hand shows and of which no part could be cut out, with the reason.
  std::map<std::string, std::string> not_cut;
  std::size_t left_out = 0;  ///< anchors above the number that a page takes
};

/// What is known of a campaign's photographs.
struct PhotographSources {
  std::vector<ImageTagsT> tags;
  PlatesT plates;
  std::map<std::string, std::string> files;  ///< by Image.path
  std::optional<PosesT> poses;               ///< in the frame of the deviations
  std::optional<CameraT> camera;             ///< of these poses
};

/// Of each failing or undecided anchor the photograph in which its marker is largest, of the worst ones the best two;
/// each photograph is opened once. The same input gives the same bytes.
AnchorPhotographs photographs_of(const DeviationT& deviation, const PhotographSources& sources);

}  // namespace plumbline::report
