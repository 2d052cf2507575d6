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

/// Panels on one plane, and the rectangle that holds their faces.
struct Extent {
  std::vector<const PanelSurfaceFiguresT*> panels;
  Eigen::Vector3d origin, right, up, out;
  double low_u = std::numeric_limits<double>::infinity(), high_u = -low_u, low_v = low_u, high_v = -low_u;
  explicit Extent(const SurfaceFaceT& first) : origin(first.origin), right(first.right), up(first.up), out(first.out) {}
  bool holds(const SurfaceFaceT& face) const {
    return face.out.dot(out) > 1 - 1e-9 && std::abs((face.origin - origin).dot(out)) < 1e-6;
  }
  void add(const PanelSurfaceFiguresT& panel) {
    if (panel.coefficients.size() != 6) throw std::runtime_error("panel " + panel.face->id + " has no form");
    const Eigen::Vector3d from = panel.face->origin - origin;
    const double half_u = 0.5 * panel.face->width, half_v = 0.5 * panel.face->height;
    low_u = std::min(low_u, right.dot(from) - half_u), high_u = std::max(high_u, right.dot(from) + half_u);
    low_v = std::min(low_v, up.dot(from) - half_v), high_v = std::max(high_v, up.dot(from) + half_v);
    panels.push_back(&panel);
  }
  std::int64_t columns(double pitch) const { return static_cast<std::int64_t>((high_u - low_u) / pitch); }
  std::int64_t rows(double pitch) const { return static_cast<std::int64_t>((high_v - low_v) / pitch); }
};

std::vector<Extent> facades_of(const SurfacesT& surfaces) {
  std::vector<Extent> facades;
  for (const auto& panel : surfaces.panels) {
    const auto found =
        std::find_if(facades.begin(), facades.end(), [&](const Extent& facade) { return facade.holds(*panel->face); });
    const auto at = static_cast<size_t>(found - facades.begin());
    if (at == facades.size()) facades.emplace_back(*panel->face);
    facades[at].add(*panel);
  }
  return facades;
}

}  // namespace

void SimulateScan::run(Context& context) {
  const SurfacesT as_built = surfaces.unpack();
  if (as_built.panels.empty()) throw std::runtime_error("input 'surfaces' has no panel");
  const std::vector<Extent> facades = facades_of(as_built);
  Random random(context.seed(), "scan");
  const Eigen::Vector3d moved = random.normal3(*place_sigma);
  std::int64_t cells = 0, done = 0;
  for (const Extent& extent : facades) cells += extent.columns(*pitch) * extent.rows(*pitch);
  context.reserve_memory(static_cast<std::uint64_t>(cells) * sizeof(Eigen::Vector3d));
  std::vector<Eigen::Vector3d> points;
  for (const Extent& extent : facades)
    for (std::int64_t r = 0; r < extent.rows(*pitch); ++r) {
      if (context.cancelled()) throw Stopped();
      context.progress(static_cast<double>(done) / static_cast<double>(cells), "scanning");
      done += extent.columns(*pitch);
      for (std::int64_t c = 0; c < extent.columns(*pitch); ++c) {
        // Somewhere in its cell: the pattern of a scanner does not run along the panels.
        const double u = extent.low_u + (static_cast<double>(c) + random.uniform()) * *pitch,
                     v = extent.low_v + (static_cast<double>(r) + random.uniform()) * *pitch,
                     noise_here = random.normal();
        double height = -*recess;
        bool through = false;
        for (const PanelSurfaceFiguresT* panel : extent.panels) {
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
  cloud::CloudWriter writer(path, cloud::CloudFormat::las, points.size(), facades.front().origin, "survey");
  constexpr size_t at_once = 100000;
  for (size_t i = 0; i < points.size(); ++i) {
    if (i % at_once == 0 && context.cancelled()) throw Stopped();
    writer.add(points[i], static_cast<float>(*noise));
  }
  writer.finish();
  context.metric("points", static_cast<double>(points.size()), "1");
  scan.commit(file_reference("scan.las", "application/vnd.las", folder.uri + "/scan.las", context.digest(path)));
}

}  // namespace plumbline::simulate
