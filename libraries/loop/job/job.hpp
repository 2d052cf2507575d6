// What a robot or a person is to do, as neutral JSON (schemas/robot_job.schema.json).
#pragma once

#include <Eigen/Geometry>
#include <optional>
#include <set>
#include <string>
#include <vector>

#include "artifacts/installation_plan.hpp"
#include "artifacts/loop_state.hpp"
#include "geometry/frame_graph.hpp"

namespace plumbline::loop {

struct JobItem {
  std::string id, kind, operation;  ///< "bracket" is set ("setBracket"), "panel" is hung ("placePanel")
  std::string guid, reason;
  int floor = 0, revision = 0;
  std::vector<std::string> depends_on;
  Eigen::Vector3d design = Eigen::Vector3d::Zero();  ///< [m] in the root frame, less its origin
  Eigen::Vector3d target = Eigen::Vector3d::Zero();  ///< [m] likewise: where it is to be
  Eigen::Quaterniond design_rotation{1, 0, 0, 0};    ///< root_from_item; the item's axes: right, up, out
  Eigen::Quaterniond target_rotation{1, 0, 0, 0};
  Eigen::Vector3d setting = Eigen::Vector3d::Zero();  ///< of a bracket, along right, up, out [m]
  Eigen::Vector3d tolerance =
      Eigen::Vector3d::Zero();  ///< half widths of the zone about the target, along right, up, out [m]
  double p_in = 1;
};

struct Job {
  std::string id;
  std::string part;  ///< "-F2": the items of these floors alone, for one robot of several; empty: the whole job
  int revision = 0;
  std::string created_at, valid_until;  ///< ISO 8601; empty: not said
  std::string basis;                    ///< InstallationPlan.basis
  std::string design_file;
  std::string frame = "building";              ///< name of the root frame: "building", or "survey", that of the control
  std::optional<FrameLink> building_from_job;  ///< of "survey": for points less the origin below, its covariance there
  Eigen::Vector3d origin = Eigen::Vector3d::Zero();  ///< of the job's coordinates in the root frame [m]
  double station_sigma = 0, setting_sigma = 0;       ///< assumed of the robot [m]
  std::vector<JobItem> items;
};

/// Released items of the state, in the order of the plan; those of `floor` only unless it is 0. Throws
/// std::runtime_error if the state was made from another plan, for a released panel that is not GO in it, and for one
/// whose corners do not tell which way it faces. The id is a hash of the content.
Job make_job(const InstallationPlanT& plan, const LoopStateT& state, int floor, const std::string& created_at,
             const std::string& valid_until);

/// The same job in the frame of the survey, where the control is that a robot or a tool is set up on. The id is kept:
/// it is that of the content.
Job in_survey(const Job& job, const FrameLink& building_from_survey);

/// Notes at all released items the ids of the jobs that hold them: of all floors and of their own.
void note_jobs(const InstallationPlanT& plan, LoopStateT& state);

/// Its items on these floors, for one of several robots; all of them without floors. The id stays that of the whole, so
/// that reports answer it. Throws std::runtime_error for a floor on which the job has no item.
Job part_of(const Job& job, const std::set<int>& floors);

std::string job_json(const Job& job);

/// Throws std::runtime_error that says what is wrong and where: no JSON, a key that is missing or of another type,
/// units that are not metres, items twice, a circle in dependsOn, a quaternion that is none, numbers that are not
/// finite.
Job read_job(const std::string& text);

/// Why a robot refuses a job: an older revision than one it has seen, past its time, none of the control it was
/// localised in.
std::vector<std::string> job_objections(const Job& job, int newest_revision, const std::string& now,
                                        const std::string& basis);

}  // namespace plumbline::loop
