// Jobs as orders and states as reports of VDA 5050 (interface of mobile robots, JSON over MQTT), versions 2.0 and 3.0.
//
// A node of an order is a place before the facade, where the base stands, an action one item. Every floor is a map of
// its own ("floor-3"), all maps have the origin of the job's root frame. An action carries the job's own numbers: what
// does not fit the standard's fields is in its parameters.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "artifacts/actuals.hpp"
#include "loop/job/job.hpp"
#include "loop/job/survey_link.hpp"

namespace plumbline::loop {

enum class VdaVersion { v2_0, v3_0 };

/// Where a robot stands: an order begins there, or the robot does not take it.
struct VdaPlace {
  std::string node, map;           ///< the node that it passed last, may be empty; its map
  double x = 0, y = 0, theta = 0;  ///< [m], [rad] on that map
};

/// Who is to do it, and the header that every message begins with.
struct VdaRobot {
  VdaVersion version = VdaVersion::v2_0;
  std::string manufacturer, serial;  ///< as the robot names itself; parts of its topics
  int header_id = 0;                 ///< counts the messages of a topic
  std::string timestamp;             ///< ISO 8601 in UTC
  std::optional<VdaPlace> start;     ///< a node without actions before the first; none: the robot stands at the first
  double stand_off = 1.5;            ///< of the base from where its items are designed, outward [m]; below 0: inside
};

/// An order on its topic. orderId is vda_order_id() and orderUpdateId 0: a job with other contents has another id.
/// Items in the order of the job; those that follow one another on one floor, and are reached from places within 0.5 m,
/// share a node. A node lies `stand_off` along the first item's outward axis, in plan, and `theta` looks back at it; of
/// an item that faces up or down the node is at the item, without theta. Parameters of an action: jobId, item,
/// revision, frame, designPosition, designOrientation, targetPosition, targetOrientation (m, x y z w, root frame),
/// tolerance and setting (m: right, up, out), dependsOn, gate. Throws std::runtime_error for a job without items, an
/// empty manufacturer or serial number, or one with a character that a topic cannot have, a timestamp that is not in
/// UTC.
std::string vda_order(const Job& job, const VdaRobot& robot);

/// orderId of a job, or of a part of it: "job-3-0123456789ab", "job-3-0123456789ab-F2".
std::string vda_order_id(const Job& job);

/// "uagv/v2/MANUFACTURER/SERIAL/order".
std::string vda_topic(const VdaRobot& robot, const std::string& subtopic);

/// actionId of an item in the order of its job, the same in that of a part.
std::string vda_action_id(const Job& job, const JobItem& item);

/// Reports out of state messages of one robot or several, one in each line, by itself or behind its topic as
/// `mosquitto_sub -v` writes it (other topics of the standard are passed over), in any order, as often as they come: an
/// action that FINISHED is done, one that FAILED has failed, anything else is no report. An action is reported once,
/// with the earliest message that says so; a later one that says otherwise is refused, as are messages that are no
/// state of 2.x or 3.x, of an order that is neither the job nor a part of it, on unknown actions or that lack what the
/// standard requires. A result that is a JSON object may hold `measured` (E, N, H [m]), `sigma` and `setting` (right,
/// up, out [m]); any other is a note. Places are in the frame of the job. Throws std::runtime_error for a job in the
/// frame of the survey where survey and design are taken to share one.
ActualsT vda_actuals(const std::string& lines, const Job& job, const std::string& source,
                     const SurveyLink& survey = {});

}  // namespace plumbline::loop
