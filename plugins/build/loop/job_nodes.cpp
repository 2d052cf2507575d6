#include "build/loop/job_nodes.hpp"

#include <map>

#include "base/text/whole_file.hpp"
#include "build/loop/file_content.hpp"
#include "geometry/random.hpp"
#include "loop/fit/facade.hpp"
#include "loop/job/job.hpp"
#include "loop/job/layout_files.hpp"
#include "loop/job/signature.hpp"
#include "loop/state/plan_artifact.hpp"

namespace plumbline::loop {
void WriteJob::run(Context& context) {
  const InstallationPlanT planned = plan.unpack();
  const Job made = make_job(planned, state.unpack(), static_cast<int>(*floor), *created_at, *valid_until);
  const std::string text = job_json(made);
  job.commit(text_file("job.json", "application/json", text));
  std::string signed_bytes;
  if (!signing_key->empty()) {
    signed_bytes = sign_bytes(text, text::read_whole(*signing_key));
  } else if (!made.items.empty()) {
    context.warn("the job is not signed: a robot cannot tell who made it; signing_key=key.pem signs it");
  }
  signature.commit(text_file("job.json.sig", "application/octet-stream", signed_bytes));
  std::vector<LayoutPoint> of_control;
  if (control)
    for (const auto& point : control.unpack().points)
      if (point->role == "control") of_control.push_back({point->id, point->position, "control"});
  const std::vector<LayoutPoint> points = layout_points(planned);
  hilti.commit(text_file("layout_hilti.csv", "text/csv", layout_csv(points, LayoutFormat::hilti)));
  trimble.commit(text_file("layout_trimble.csv", "text/csv", layout_csv(points, LayoutFormat::trimble)));
  leica.commit(text_file("layout_leica.csv", "text/csv", layout_csv(points, LayoutFormat::leica)));
  control_points.commit(text_file("control.csv", "text/csv", layout_csv(of_control, LayoutFormat::hilti)));
  drawing.commit(text_file("layout.dxf", "image/vnd.dxf", layout_dxf(planned, of_control)));
  context.metric("items", static_cast<double>(made.items.size()), "1");
}

void ReadActuals::run(Context& context) {
  const std::string text = content_of(*file, context), name = file->name()->str();
  ActualsT read = *format == "json"      ? read_actuals_json(text, name)
                  : *format == "hilti"   ? read_staked(text, LayoutFormat::hilti, name)
                  : *format == "trimble" ? read_staked(text, LayoutFormat::trimble, name)
                                         : read_staked(text, LayoutFormat::leica, name);
  for (const std::string& line : read.refused) context.warn(line);
  if (read.items.empty())
    throw std::runtime_error(name + " has no report or point in it" +
                             (read.refused.empty() ? "" : "; " + read.refused[0]));
  context.metric("reports", static_cast<double>(read.items.size()), "1");
  actuals.commit(read);
}

namespace {

/// What one robot does to one bracket, and what it says.
struct Deed {
  std::string where;
  Eigen::Vector3d setting;
  std::string outcome = "done", fault;
  int revision = 0;
};

}  // namespace

void SimulateRobots::run(Context& context) {
  const Job todo = read_job(content_of(*job, context));
  PointsT site = truth.unpack();
  std::map<std::string, PointT*> point;
  for (const auto& p : site.points) point[p->id] = p.get();
  const std::uint64_t seed = context.seed();
  ActualsT reports;
  int faults = 0;
  for (std::size_t i = 0; i < todo.items.size(); ++i) {
    const JobItem& item = todo.items[i];
    Random luck(seed, "fault " + item.id), station(seed, "station", static_cast<std::uint64_t>(item.floor));
    Random own(seed, "setting " + item.id);
    Deed deed{item.id, item.setting, "done", "", item.revision};
    if (luck.uniform() < *skipped)
      deed.outcome = "skipped", deed.fault = "skipped", deed.setting.setZero();
    else if (luck.uniform() < *old_revision)
      deed.revision -= 1, deed.fault = "old revision";
    else if (luck.uniform() < *did_nothing)
      deed.setting.setZero(), deed.fault = "did nothing";
    else if (item.kind != "bracket")
      deed.fault = "";
    else if (luck.uniform() < *off_8mm)
      deed.setting.x() += 0.008, deed.fault = "8 mm off";
    else if (luck.uniform() < *wrong_side)
      deed.setting = -deed.setting, deed.fault = "wrong side";
    else if (luck.uniform() < *wrong_item) {
      deed.where = todo.items[(i + 1) % todo.items.size()].id, deed.fault = "wrong item";
    }
    faults += !deed.fault.empty();
    const auto hook = point.find(deed.where);
    if (item.kind == "bracket" && hook != point.end() && deed.outcome == "done" && deed.fault != "did nothing") {
      Eigen::Vector3d done = deed.setting + station.normal3(*station_sigma) + own.normal3(*repeatability);
      if (own.uniform() < *slip_share) done += own.normal3(*slip_sigma);
      hook->second->position += item.design_rotation * done;
    }
    auto report = std::make_unique<ActualT>();
    report->item = item.id, report->job = todo.id, report->revision = deed.revision, report->outcome = deed.outcome;
    report->by = "robot-" + std::to_string(1 + item.floor % 2), report->measured.setConstant(kUnknown);
    // A robot sees the panel that it has hung, to a millimetre.
    if (item.kind == "panel" && deed.outcome == "done" && deed.fault != "did nothing")
      report->measured = todo.origin + item.target + own.normal3(0.001);
    report->sigma.setConstant(kUnknown), report->setting.setConstant(kUnknown);
    reports.items.push_back(std::move(report));
  }
  context.metric("done", static_cast<double>(todo.items.size()), "1");
  context.metric("faults", faults, "1");
  moved.commit(site);
  actuals.commit(reports);
}

}  // namespace plumbline::loop
