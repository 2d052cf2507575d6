#include "build/loop/vda_nodes.hpp"

#include "build/loop/file_content.hpp"
#include "loop/exchange/vda5050.hpp"
#include "loop/state/plan_artifact.hpp"

namespace plumbline::loop {

void WriteVda5050::run(Context& context) {
  const Job made = read_job(content_of(*job, context));
  VdaRobot robot;
  robot.version = *version == "2.0.0" ? VdaVersion::v2_0 : VdaVersion::v3_0;
  robot.manufacturer = *manufacturer, robot.serial = *serial_number, robot.timestamp = *timestamp;
  robot.header_id = static_cast<int>(*header_id), robot.stand_off = *stand_off;
  order.commit(text_file("order.json", "application/json", vda_order(made, robot)));
  topic.commit(text_file("topic.txt", "text/plain", vda_topic(robot, "order") + "\n"));
  context.metric("actions", static_cast<double>(made.items.size()), "1");
}

void ReadVda5050::run(Context& context) {
  const Job ordered = read_job(content_of(*job, context));
  const SurveyLink survey = frames ? survey_link(frames.unpack()) : SurveyLink();
  const ActualsT read = vda_actuals(content_of(*states, context), ordered, states->name()->str(), survey);
  for (const auto* lines : {&read.refused, &read.ignored})
    for (const std::string& line : *lines) context.warn(line);
  context.metric("reports", static_cast<double>(read.items.size()), "1");
  context.metric("refused", static_cast<double>(read.refused.size()), "1");
  actuals.commit(read);
}

}  // namespace plumbline::loop
