// The solvers of OpenGV for several projection centres.
#include <algorithm>
#include <opengv/absolute_pose/NoncentralAbsoluteAdapter.hpp>
#include <opengv/absolute_pose/methods.hpp>
#include <stdexcept>

#include "place/pose/opengv_solvers.hpp"

namespace plumbline::pose {
namespace {

namespace ap = opengv::absolute_pose;

/// Bearings, points and cameras of a sample, as OpenGV's adapter refers to them.
struct Data {
  opengv::bearingVectors_t bearings;
  opengv::points_t points;
  ap::NoncentralAbsoluteAdapter::camCorrespondences_t cameras;
  opengv::translations_t centres;  ///< of all cameras in the rig's frame
  opengv::rotations_t rotations;   ///< rig from camera

  explicit Data(const std::vector<RigView>& views) {
    for (const RigView& view : views) {
      const RigidTransform rig_from_cam = view.cam_from_rig.inverse();
      centres.push_back(rig_from_cam.translation);
      rotations.push_back(rig_from_cam.rotation.toRotationMatrix());
    }
  }
  void add(const RigTag& tag, std::size_t corner) {
    bearings.push_back(tag.tag.bearings[corner]);
    points.push_back(tag.tag.corner_in_world(static_cast<int>(corner)));
    cameras.push_back(static_cast<int>(tag.view));
  }
  ap::NoncentralAbsoluteAdapter adapter() const { return {bearings, cameras, points, centres, rotations}; }
};

/// OpenGV gives the viewpoint: rotation world from rig, and the rig's origin.
void add(const opengv::transformation_t& world_from_rig, PoseHypotheses& poses) {
  const Eigen::Matrix3d rotation = world_from_rig.leftCols<3>();
  if (!world_from_rig.allFinite() || !(rotation.determinant() > 0.5)) return;
  const RigidTransform pose{Eigen::Quaterniond(rotation).normalized(), world_from_rig.col(3)};
  poses.push_back(pose.inverse());
}

Data all_corners(const std::vector<RigView>& views, const std::vector<const RigTag*>& sample) {
  Data data(views);
  for (const RigTag* tag : sample)
    for (std::size_t i = 0; i < 4; ++i) data.add(*tag, i);
  return data;
}

PoseHypotheses gp3p(const std::vector<RigView>& views, const std::vector<const RigTag*>& sample) {
  PoseHypotheses poses;
  for (const std::size_t first : {0, 2}) {
    Data data(views);
    for (std::size_t k = 0; k < 3; ++k) data.add(*sample[k], (first + k) % 4);
    for (const auto& found : ap::gp3p(data.adapter())) add(found, poses);
  }
  return poses;
}

PoseHypotheses gpnp(const std::vector<RigView>& views, const std::vector<const RigTag*>& sample) {
  PoseHypotheses poses;
  add(ap::gpnp(all_corners(views, sample).adapter()), poses);
  return poses;
}

PoseHypotheses upnp(const std::vector<RigView>& views, const std::vector<const RigTag*>& sample) {
  PoseHypotheses poses;
  for (const auto& found : ap::upnp(all_corners(views, sample).adapter())) add(found, poses);
  return poses;
}

struct Named {
  const char *name, *central;
  PoseHypotheses (*solve)(const std::vector<RigView>&, const std::vector<const RigTag*>&);
};
constexpr Named solvers[] = {{"gp3p", "p3p_kneip", gp3p}, {"gpnp", "epnp", gpnp}, {"upnp", "upnp", upnp}};

}  // namespace

RigPoseSolver make_opengv_rig_solver(const std::string& name) {
  std::string known;
  for (const Named& solver : solvers) {
    if (name == solver.name) {
      const TagPoseSolver central = make_opengv_solver(solver.central);
      return
          [central, solve = solver.solve](const std::vector<RigView>& views, const std::vector<const RigTag*>& sample) {
            const std::size_t first = sample.front()->view;
            if (std::any_of(sample.begin(), sample.end(), [&](const RigTag* tag) { return tag->view != first; }))
              return solve(views, sample);
            std::vector<const TagView*> tags;
            for (const RigTag* tag : sample) tags.push_back(&tag->tag);
            PoseHypotheses poses = central(tags);
            for (RigidTransform& pose : poses) pose = views[first].cam_from_rig.inverse() * pose;
            return poses;
          };
    }
    known += (known.empty() ? "" : ", ") + std::string(solver.name);
  }
  throw std::runtime_error("unknown OpenGV solver '" + name + "' for rigs; known are " + known);
}

}  // namespace plumbline::pose
