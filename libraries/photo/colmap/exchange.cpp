#include "photo/colmap/exchange.hpp"

#include <cmath>
#include <fstream>
#include <stdexcept>

#include "geometry/camera.hpp"
#include "plumbline/failure.hpp"

namespace plumbline::colmap {
namespace {

namespace fs = std::filesystem;

InteriorOrientation camera_of(const bundle::Camera& of, const bundle::Interior& values) {
  InteriorOrientation camera;
  camera.lens = of.lens == bundle::Lens::fisheye ? LensModel::fisheye : LensModel::brown;
  std::array<double, BrownCamera::parameter_count> p;
  std::copy_n(values.begin(), p.size(), p.begin());
  camera.set_parameters(p);
  // The program wants a size, of which its adjustment makes no use.
  camera.width = static_cast<int>(2 * std::abs(camera.cx)) + 2;
  camera.height = static_cast<int>(2 * std::abs(camera.cy)) + 2;
  return camera;
}

void write_files(const std::map<std::string, std::string>& files, const fs::path& folder) {
  for (const auto& [name, text] : files) {
    std::ofstream stream(folder / name, std::ios::binary);
    if (!(stream << text).flush())
      throw std::runtime_error("cannot write " + (folder / name).string() + " for COLMAP; is the disk full?");
  }
}

/// What stands after "name :" in a report of COLMAP; empty if nothing does.
std::string reported(const std::string& text, const std::string& name) {
  const size_t at = text.rfind(name);
  if (at == std::string::npos) return {};
  const size_t colon = text.find(':', at), end = text.find('\n', at);
  if (colon == std::string::npos || colon > end) return {};
  const std::string value = text.substr(colon + 1, end - colon - 1);
  const size_t first = value.find_first_not_of(' ');
  return first == std::string::npos ? "" : value.substr(first);
}

void read_back(const cameras::ColmapModel& model, const std::vector<int>& order, const bundle::Problem& problem,
               bundle::State& state) {
  for (size_t k = 0; k < order.size(); ++k) {
    const auto found = model.images.find(static_cast<std::uint32_t>(k + 1));
    const size_t i = static_cast<size_t>(order[k]);
    if (found == model.images.end())
      throw std::runtime_error("COLMAP lost the image " + problem.images[i].name + " in its adjustment");
    const RigidTransform& pose = found->second.cam_from_world;
    state.images[i].set(pose.rotation, pose.inverse().translation);
  }
  for (size_t j = 0; j < problem.points.size(); ++j) {
    const auto found = model.points.find(static_cast<std::int64_t>(j + 1));
    if (found == model.points.end())
      throw std::runtime_error(
          "COLMAP dropped " + problem.points[j].name +
          " because it lay behind a camera that sees it: a wrong number or a bad approximate pose");
    state.points[j] = found->second.position;
  }
  for (size_t c = 0; c < problem.cameras.size(); ++c) {
    const auto found = model.cameras.find(static_cast<std::uint32_t>(c + 1));
    if (found == model.cameras.end()) throw std::runtime_error("COLMAP's answer lacks a camera");
    const auto values = found->second.camera.parameters();
    for (size_t v = 0; v < found->second.camera.names().size(); ++v)
      if (problem.cameras[c].free[v]) state.interiors[c][v] = values[v];
  }
}

}  // namespace

std::vector<int> image_order(const bundle::State& state) {
  const int n = static_cast<int>(state.images.size());
  int first = 0, second = 1;
  double longest = -1;
  for (int a = 0; a < n; ++a)
    for (int b = 0; b < n; ++b) {
      const auto &one = state.images[a], &other = state.images[b];
      const double base = std::abs(other.matrix.row(0).dot(other.position - one.position));
      if (a != b && base > longest) longest = base, first = a, second = b;
    }
  std::vector<int> order = {first, second};
  for (int i = 0; i < n; ++i)
    if (i != first && i != second) order.push_back(i);
  return order;
}

cameras::ColmapModel model_of(const bundle::Problem& problem, const bundle::State& state,
                              const std::vector<int>& order) {
  cameras::ColmapModel model;
  for (size_t c = 0; c < problem.cameras.size(); ++c) {
    const auto id = static_cast<std::uint32_t>(c + 1);
    model.cameras[id] = {id, "", camera_of(problem.cameras[c], state.interiors[c])};
  }
  std::vector<std::uint32_t> id_of(problem.images.size());
  for (size_t k = 0; k < order.size(); ++k) {
    const size_t i = static_cast<size_t>(order[k]);
    const auto id = id_of[i] = static_cast<std::uint32_t>(k + 1);
    const bundle::Placement& p = state.images[i];
    model.images[id] = {id,
                        static_cast<std::uint32_t>(problem.images[i].camera + 1),
                        "image" + std::to_string(id),
                        RigidTransform{p.rotation, -(p.matrix * p.position)},
                        {}};
  }
  for (size_t j = 0; j < problem.points.size(); ++j)
    model.points[static_cast<std::int64_t>(j + 1)].position = state.points[j];
  for (const auto& seen : problem.image_points) {
    cameras::ColmapImage& image = model.images[id_of[seen.image]];
    model.points[seen.point + 1].track.emplace_back(image.id, static_cast<std::uint32_t>(image.features.size()));
    image.features.push_back({seen.observed, seen.point + 1});
  }
  return model;
}

BundleSummary adjust_by_colmap(const bundle::Problem& problem, bundle::State& state, const BundleOptions& options) {
  const ScratchFolder scratch;
  const fs::path in = scratch.make("in"), out = scratch.make("out");
  const std::vector<int> order = image_order(state);
  write_files(cameras::colmap_text(model_of(problem, state, order)), in);
  const auto flag = [](bool on) { return std::string(on ? "1" : "0"); };
  const std::string said =
      run_program(options.program,
                  {"bundle_adjuster", "--input_path", in.string(), "--output_path", out.string(),
                   "--BundleAdjustment.max_num_iterations", std::to_string(options.max_iterations),
                   "--BundleAdjustment.function_tolerance", "1e-12", "--BundleAdjustment.parameter_tolerance", "1e-12",
                   "--BundleAdjustment.refine_focal_length", flag(options.refine_focal_length),
                   "--BundleAdjustment.refine_principal_point", flag(options.refine_principal_point),
                   "--BundleAdjustment.refine_extra_params", flag(options.refine_extra_params)},
                  options.time_limit, scratch.path() / "log");
  BundleSummary summary;
  summary.iterations = std::atoi(reported(said, "Iterations").c_str());
  summary.message = reported(said, "Termination");
  if (summary.message != "Convergence")
    throw NotConverged("COLMAP's bundle_adjuster did not converge in " + std::to_string(summary.iterations) +
                       " iterations (it says: " + (summary.message.empty() ? "nothing" : summary.message) +
                       "); raise max_iterations, or hold what the images do not determine (refine_focal_length, "
                       "refine_extra_params: false)");
  read_back(cameras::read_colmap(out.string()), order, problem, state);
  return summary;
}

}  // namespace plumbline::colmap
