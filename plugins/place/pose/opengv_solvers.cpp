#include "place/pose/opengv_solvers.hpp"

#include <algorithm>
#include <iostream>
#include <mutex>
#include <opengv/absolute_pose/CentralAbsoluteAdapter.hpp>
#include <opengv/absolute_pose/methods.hpp>
#include <sstream>
#include <stdexcept>

namespace plumbline::pose {
namespace {

namespace ap = opengv::absolute_pose;

/// Bearings and points of a sample, as OpenGV's adapters refer to them.
struct Data {
  opengv::bearingVectors_t bearings;
  opengv::points_t points;
};

Data all_corners(const std::vector<const TagView*>& sample) {
  Data data;
  for (const TagView* tag : sample)
    for (int i = 0; i < 4; ++i) {
      data.bearings.push_back(tag->bearings[i]);
      data.points.push_back(tag->corner_in_world(i));
    }
  return data;
}

/// One corner of each tag, another one each time: three tags in one line still span a triangle. Of fewer than three
/// tags, three corners of what there is.
Data one_corner_each(const std::vector<const TagView*>& sample, std::size_t first) {
  Data data;
  for (std::size_t k = 0; k < std::max<std::size_t>(3, sample.size()); ++k) {
    const std::size_t i = (first + k) % 4;
    const TagView& tag = *sample[k % sample.size()];
    data.bearings.push_back(tag.bearings[i]);
    data.points.push_back(tag.corner_in_world(static_cast<int>(i)));
  }
  return data;
}

/// OpenGV gives the viewpoint: rotation world from camera, and the projection centre.
void add(const opengv::transformation_t& world_from_cam, PoseHypotheses& poses) {
  const Eigen::Matrix3d rotation = world_from_cam.leftCols<3>();
  if (!rotation.allFinite() || !(rotation.determinant() > 0.5)) return;
  const RigidTransform pose{Eigen::Quaterniond(rotation).normalized(), world_from_cam.col(3)};
  poses.push_back(pose.inverse());
}

PoseHypotheses p3p_kneip(const std::vector<const TagView*>& sample) {
  PoseHypotheses poses;
  for (const std::size_t first : {0, 2}) {
    const Data data = one_corner_each(sample, first);
    for (const auto& found : ap::p3p_kneip(ap::CentralAbsoluteAdapter(data.bearings, data.points))) add(found, poses);
  }
  return poses;
}

PoseHypotheses p3p_gao(const std::vector<const TagView*>& sample) {
  PoseHypotheses poses;
  for (const std::size_t first : {0, 2}) {
    const Data data = one_corner_each(sample, first);
    for (const auto& found : ap::p3p_gao(ap::CentralAbsoluteAdapter(data.bearings, data.points))) add(found, poses);
  }
  return poses;
}

/// What is printed to std::cerr meanwhile goes to the listener. One at a time, as there is one std::cerr.
class PrintedText {
 public:
  PrintedText() : lock_(mutex()), before_(std::cerr.rdbuf(text_.rdbuf())) {}
  ~PrintedText() { std::cerr.rdbuf(before_); }
  bool empty() const { return text_.view().empty(); }
  PrintedText(const PrintedText&) = delete;
  PrintedText& operator=(const PrintedText&) = delete;

 private:
  static std::mutex& mutex() {
    static std::mutex one;
    return one;
  }
  std::lock_guard<std::mutex> lock_;
  std::ostringstream text_;
  std::streambuf* before_;
};

/// OpenGV says on std::cerr, and nowhere else, that its equations are singular; what it gives then is no pose.
PoseHypotheses epnp(const std::vector<const TagView*>& sample) {
  const Data data = all_corners(sample);
  PoseHypotheses poses;
  const PrintedText complaint;
  const auto found = ap::epnp(ap::CentralAbsoluteAdapter(data.bearings, data.points));
  if (complaint.empty()) add(found, poses);
  return poses;
}

PoseHypotheses upnp(const std::vector<const TagView*>& sample) {
  const Data data = all_corners(sample);
  PoseHypotheses poses;
  for (const auto& found : ap::upnp(ap::CentralAbsoluteAdapter(data.bearings, data.points))) add(found, poses);
  return poses;
}

struct Named {
  const char* name;
  PoseHypotheses (*solve)(const std::vector<const TagView*>&);
};
constexpr Named solvers[] = {{"p3p_kneip", p3p_kneip}, {"p3p_gao", p3p_gao}, {"epnp", epnp}, {"upnp", upnp}};

}  // namespace

const std::vector<std::string>& opengv_solver_names() {
  static const std::vector<std::string> names = [] {
    std::vector<std::string> list;
    for (const Named& solver : solvers) list.emplace_back(solver.name);
    return list;
  }();
  return names;
}

TagPoseSolver make_opengv_solver(const std::string& name) {
  std::string known;
  for (const Named& solver : solvers) {
    if (name == solver.name) return solver.solve;
    known += (known.empty() ? "" : ", ") + std::string(solver.name);
  }
  throw std::runtime_error("unknown OpenGV solver '" + name + "'; known are " + known);
}

}  // namespace plumbline::pose
