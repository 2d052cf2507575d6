#include "build/loop/job_nodes.hpp"

#include "base/text/whole_file.hpp"
#include "build/loop/file_content.hpp"
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

}  // namespace plumbline::loop
