// The photographs of a block as views: orientations and their joint covariance from artifacts, pixels when they are
// needed.
#pragma once

#include <functional>
#include <list>
#include <map>
#include <string>
#include <vector>

#include "artifacts/camera.hpp"
#include "artifacts/image.hpp"
#include "artifacts/poses.hpp"
#include "surface/dense/facet.hpp"
#include "surface/dense/panel_surface.hpp"

namespace plumbline::surface {

class Photographs {
 public:
  /// Views of the images that have a pose. Throws std::runtime_error, saying what to do, if no image has one, if the
  /// poses come without their joint covariance, or if the cameras do not fit.
  Photographs(const std::vector<ImageT>& images, const PosesT& poses, const CameraT& camera);

  const std::vector<View>& views() const { return views_; }
  const OrientationCovariance& orientations() const { return orientations_; }
  std::vector<Eigen::Vector3d> centres() const;
  /// Images without a pose, by name.
  const std::vector<std::string>& without_pose() const { return without_pose_; }

  /// Number of the view; its file's uri by images()[…].
  const std::string& uri(size_t view) const { return uris_[view]; }
  std::uint64_t bytes(size_t view) const;  ///< that its pixels take in memory

  /// Views that see the rectangle of a face at all, `reach` [m] before or behind it, too.
  std::vector<size_t> that_see(const PanelFace& face, double reach) const;

 private:
  std::vector<View> views_;
  std::vector<std::string> uris_, without_pose_;
  OrientationCovariance orientations_;
};

/// Pixels of the views last used, within a limit of memory.
class PixelCache {
 public:
  using Load = std::function<GreyImage(size_t view)>;
  PixelCache(const Photographs& photographs, std::uint64_t most_bytes, Load load)
      : photographs_(photographs), most_(most_bytes), load_(std::move(load)) {}
  /// Facet views of some views, all in memory at once. They stay valid until the next call. Throws std::runtime_error
  /// if the limit is too small for them together.
  std::vector<FacetView> take(const std::vector<size_t>& views);

 private:
  const Photographs& photographs_;
  std::uint64_t most_, held_ = 0;
  Load load_;
  std::list<size_t> used_;  ///< the last one first
  std::map<size_t, Pyramid> pixels_;
};

}  // namespace plumbline::surface
