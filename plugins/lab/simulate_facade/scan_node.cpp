#include "scan_node.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

#include "artifacts/file_artifact.hpp"
#include "geometry/random.hpp"
#include "plumbline/stop.hpp"
#include "surface/cloud/cloud_writer.hpp"

namespace plumbline::simulate {
namespace {

/// Height of a panel over its face, u and v from its middle [m]; nan beside it.
double height_of(const PanelSurfaceFiguresT& panel, double u, double v) {
  const double x = 2 * u / panel.face->width, y = 2 * v / panel.face->height;
  if (std::abs(x) > 1 || std::abs(y) > 1) return std::nan("");
  const std::vector<double>& c = panel.coefficients;
  return c[0] + c[1] * x + c[2] * y + c[3] * (1 - x * x) + c[4] * (1 - y * y) + c[5] * x * y;
}

/// The rectangle that holds all faces, on the plane of the first.
struct Extent {
  Eigen::Vector3d origin, right, up, out;
  double low_u = std::numeric_limits<double>::infinity(), high_u = -low_u, low_v = low_u, high_v = -low_u;
  explicit Extent(const SurfacesT& surfaces) {
    const SurfaceFaceT& first = *surfaces.panels.front()->face;
    origin = first.origin, right = first.right, up = first.up, out = first.out;
    for (const auto& panel : surfaces.panels) {
      const Eigen::Vector3d from = panel->face->origin - origin;
      if (panel->face->out.dot(out) < 1 - 1e-9 || std::abs(from.dot(out)) > 1e-6)
        throw std::runtime_error("panel " + panel->face->id + " does not lie in the plane of " + first.id +
                                 "; a scan of several facades is not simulated");
      if (panel->coefficients.size() != 6) throw std::runtime_error("panel " + panel->face->id + " has no form");
      const double half_u = 0.5 * panel->face->width, half_v = 0.5 * panel->face->height;
      low_u = std::min(low_u, right.dot(from) - half_u), high_u = std::max(high_u, right.dot(from) + half_u);
      low_v = std::min(low_v, up.dot(from) - half_v), high_v = std::max(high_v, up.dot(from) + half_v);
    }
  }
};

}  // namespace

void SimulateScan::run(Context& context) {
  const SurfacesT as_built = surfaces.unpack();
  if (as_built.panels.empty()) throw std::runtime_error("input 'surfaces' has no panel");
  const Extent extent(as_built);
  Random random(context.seed(), "scan");
  const Eigen::Vector3d moved = random.normal3(*place_sigma);
  const auto columns = static_cast<std::int64_t>((extent.high_u - extent.low_u) / *pitch),
             rows = static_cast<std::int64_t>((extent.high_v - extent.low_v) / *pitch);
  context.reserve_memory(static_cast<std::uint64_t>(columns * rows) * sizeof(Eigen::Vector3d));
  std::vector<Eigen::Vector3d> points;
  for (std::int64_t r = 0; r < rows; ++r) {
    if (context.cancelled()) throw Stopped();
    context.progress(static_cast<double>(r) / static_cast<double>(rows), "scanning");
    for (std::int64_t c = 0; c < columns; ++c) {
      // Somewhere in its cell: the pattern of a scanner does not run along the panels.
      const double u = extent.low_u + (static_cast<double>(c) + random.uniform()) * *pitch,
                   v = extent.low_v + (static_cast<double>(r) + random.uniform()) * *pitch,
                   noise_here = random.normal();
      double height = -*recess;
      bool through = false;
      for (const auto& panel : as_built.panels) {
        const Eigen::Vector3d from = panel->face->origin - extent.origin;
        const double here = height_of(*panel, u - extent.right.dot(from), v - extent.up.dot(from));
        if (std::isnan(here)) continue;
        height = here, through = panel->not_measured == "glass";
      }
      if (!through)
        points.push_back(extent.origin + moved + u * extent.right + v * extent.up +
                         (height + *noise * noise_here) * extent.out);
    }
  }
  const auto folder = scan.make_folder();
  const std::string path = folder.path + "/scan.las";
  cloud::CloudWriter writer(path, cloud::CloudFormat::las, points.size(), extent.origin, "survey");
  for (const Eigen::Vector3d& point : points) writer.add(point, static_cast<float>(*noise));
  writer.finish();
  context.metric("points", static_cast<double>(points.size()), "1");
  scan.commit(file_reference("scan.las", "application/vnd.las", folder.uri + "/scan.las", context.digest(path)));
}

}  // namespace plumbline::simulate
