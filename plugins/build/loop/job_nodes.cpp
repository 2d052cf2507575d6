#include "build/loop/job_nodes.hpp"

#include <algorithm>
#include <map>

#include "base/text/whole_file.hpp"
#include "build/loop/file_content.hpp"
#include "loop/job/job.hpp"
#include "loop/job/layout_files.hpp"
#include "loop/job/signature.hpp"
#include "loop/state/date.hpp"
#include "loop/state/hash.hpp"
#include "loop/state/plan_artifact.hpp"

namespace plumbline::loop {

namespace {

/// Robots refuse what they cannot read or what is over: better said before the job is out.
void check_dates(const std::string& created_at, const std::string& valid_until) {
  for (const auto& [name, date] : {std::pair{"created_at", created_at}, {"valid_until", valid_until}})
    if (!date.empty() && !seconds_of(date))
      throw std::runtime_error(std::string(name) + " is '" + date +
                               "'; expected ISO 8601 with a zone, such as 2026-05-02T08:00:00Z");
  if (!created_at.empty() && !valid_until.empty() && *seconds_of(valid_until) <= *seconds_of(created_at))
    throw std::runtime_error("the job would be valid until " + valid_until + ", and it is made at " + created_at +
                             ": every robot would refuse it");
}

}  // namespace

void WriteJob::run(Context& context) {
  check_dates(*created_at, *valid_until);
  const InstallationPlanT planned = plan.unpack();
  const SurveyLink survey = frames ? survey_link(frames.unpack()) : SurveyLink();
  Job made = make_job(planned, state.unpack(), static_cast<int>(*floor), *created_at, *valid_until);
  if (survey) made = in_survey(made, *survey);
  const bool sets =
      std::any_of(made.items.begin(), made.items.end(), [](const JobItem& item) { return item.kind == "bracket"; });
  if (sets && !(made.station_sigma > 0))
    context.warn(
        "the job takes whoever sets brackets to stand where he thinks (stationSigma is 0), and p with it: give the "
        "plan "
        "station_sigma, 0.5 mm for a set-up on control by total station");
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
  std::map<std::string, Eigen::Vector3d> asked;
  for (const JobItem& item : made.items)
    if (item.kind == "bracket") asked[item.id] = item.setting;
  settings.commit(text_file("settings.csv", "text/csv", settings_csv(planned, asked)));
  const std::vector<LayoutPoint> points = layout_points(made);
  hilti.commit(text_file("layout_hilti.csv", "text/csv", layout_csv(points, LayoutFormat::hilti)));
  trimble.commit(text_file("layout_trimble.csv", "text/csv", layout_csv(points, LayoutFormat::trimble)));
  leica.commit(text_file("layout_leica.csv", "text/csv", layout_csv(points, LayoutFormat::leica)));
  control_points.commit(text_file("control.csv", "text/csv", layout_csv(of_control, LayoutFormat::hilti)));
  drawing.commit(text_file("layout.dxf", "image/vnd.dxf", layout_dxf(planned, made, of_control, survey)));
  context.metric("items", static_cast<double>(made.items.size()), "1");
}

void ReadActuals::run(Context& context) {
  const std::string text = content_of(*file, context), name = file->name()->str();
  const SurveyLink survey = frames ? survey_link(frames.unpack()) : SurveyLink();
  ActualsT read = *format == "json"      ? read_actuals_json(text, name, survey)
                  : *format == "hilti"   ? read_staked(text, LayoutFormat::hilti, name, survey)
                  : *format == "trimble" ? read_staked(text, LayoutFormat::trimble, name, survey)
                                         : read_staked(text, LayoutFormat::leica, name, survey);
  for (const auto& item : read.items) item->digest = sha256_hex(text);
  for (const auto* lines : {&read.refused, &read.ignored})
    for (const std::string& line : *lines) context.warn(line);
  if (read.items.empty())
    throw std::runtime_error(name + " has no report or point in it" +
                             (read.refused.empty() ? "" : "; " + read.refused[0]));
  context.metric("reports", static_cast<double>(read.items.size()), "1");
  actuals.commit(read);
}

}  // namespace plumbline::loop
