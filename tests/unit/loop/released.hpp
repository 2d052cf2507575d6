// What tests of jobs and their answers begin with: a plan that was released, and the schema of its job.
#pragma once

#include <nlohmann/json.hpp>
#include <string>
#include <valijson/adapters/nlohmann_json_adapter.hpp>
#include <valijson/schema.hpp>
#include <valijson/schema_parser.hpp>
#include <valijson/validator.hpp>

#include "loop/state/machine.hpp"
#include "loop/state/plan_artifact.hpp"
#include "random_facade.hpp"
#include "test_support.hpp"

namespace plumbline::test {

/// A plan with its state after the first release.
struct Released {
  InstallationPlanT plan;
  LoopStateT state;
  Released() {
    const loop::Facade facade = random_facade({2, 2}, 4, 0.004, 0.0003, 0.0004);
    const loop::Fit fit = loop::plan_settings(facade);
    plan = loop::plan_artifact(facade, fit, loop::judge_plan(facade, fit));
    loop::apply_plan(state, plan, {});
  }
};

/// Whether a document is a job by schemas/robot_job.schema.json.
inline bool is_valid_job(const nlohmann::json& document) {
  const nlohmann::json text =
      nlohmann::json::parse(read_file(std::string(source_dir()) + "/schemas/robot_job.schema.json"));
  valijson::Schema schema;
  valijson::SchemaParser parser;
  parser.populateSchema(valijson::adapters::NlohmannJsonAdapter(text), schema);
  valijson::Validator validator;
  return validator.validate(schema, valijson::adapters::NlohmannJsonAdapter(document), nullptr);
}

}  // namespace plumbline::test
