#include "loop/simulate/robot.hpp"

#include <algorithm>
#include <cmath>

#include "loop/fit/panel_pose.hpp"

namespace plumbline::loop {

BracketTask task_of(const Faults& faults, const Eigen::Vector3d& setting, int revision, Random& luck) {
  BracketTask task;
  task.asked = setting, task.revision = revision;
  if (luck.uniform() < faults.did_nothing) {
    task.fault = "did nothing", task.left = setting, task.asked.setZero();
  } else if (luck.uniform() < faults.off_8mm) {
    task.fault = "8 mm off", task.left = {0.008, 0, 0};
    task.asked += Eigen::Vector3d(luck.uniform() < 0.5 ? 0.008 : -0.008, 0, 0);
  } else if (luck.uniform() < faults.wrong_side) {
    task.fault = "wrong side", task.left = 2 * setting, task.asked = -setting;
  } else if (luck.uniform() < faults.wrong_item) {
    task.fault = "wrong item", task.left = setting, task.other_bracket = true;
  } else if (luck.uniform() < faults.skipped) {
    task.fault = "skipped", task.skipped = true, task.asked.setZero();
  } else if (luck.uniform() < faults.twice) {
    task.fault = "done twice", task.left = setting, task.twice = true;
  } else if (luck.uniform() < faults.old_revision) {
    task.fault = "old revision", task.revision = revision > 1 ? revision - 1 : kOtherLoop;
  } else if (luck.uniform() < faults.other_job) {
    task.asked = luck.normal3(0.006);
    task.fault = "other job", task.left = task.asked - setting, task.other_job = true;
  }
  return task;
}

Eigen::Vector3d moved_by(const RobotModel& model, const Eigen::Vector3d& setting, const Eigen::Vector3d& arm,
                         const Eigen::Vector3d& base, Random& own) {
  Eigen::Vector3d moved = setting + arm + base + own.normal3(model.repeatability);
  if (own.uniform() < model.slip_share) moved += own.normal3(model.slip);
  if (model.wander > 0) moved += own.normal3(model.wander).cwiseProduct(Eigen::Vector3d(1, 1, 0));
  return moved;
}

Eigen::Vector3d off_by_base(const RobotModel& model, const Eigen::Vector3d& from_first, int items, Random station,
                            Random drifts, Random tilts) {
  Eigen::Vector3d off = station.normal3(model.station);
  for (int i = 0; i < items; ++i) off += drifts.normal3(model.drift);
  return off + tilts.normal3(model.tilt).cross(from_first - kBase);
}

double sigma_by_base(const RobotModel& model, const std::vector<Eigen::Vector3d>& from_first) {
  double most = model.station * model.station;
  for (std::size_t i = 0; i < from_first.size(); ++i) {
    const Eigen::Vector3d arm = from_first[i] - kBase;
    const double turned = arm.squaredNorm() - arm.cwiseAbs2().minCoeff();
    most = std::max(most, model.station * model.station + static_cast<double>(i + 1) * model.drift * model.drift +
                              model.tilt * model.tilt * turned);
  }
  return std::sqrt(most);
}

Eigen::Vector3d centre_on(const Panel& panel, const std::vector<Bracket>& brackets,
                          const std::vector<Eigen::Vector3d>& truth, double face) {
  std::vector<Bracket> there = brackets;
  for (Bracket& bracket : there) bracket.deviation.setZero();  // each is there, measured or not
  const PanelPose pose = pose_of(panel, there);
  Eigen::VectorXd moved(pose.solve.cols());
  for (Eigen::Index i = 0; i < moved.size(); ++i) moved[i] = pose.held[i].direction.dot(truth[pose.held[i].bracket]);
  const Eigen::Matrix<double, 6, 1> twist = pose.solve * moved;
  return panel.centre + twist.head<3>() + face * panel.axes.col(2);
}

}  // namespace plumbline::loop
