// make_job OUT.json ITEMS [ID]: a job for the tests of plumbline-robots.
#include <cstdlib>
#include <fstream>

#include "loop/job/job.hpp"

int main(int count, char** arguments) {
  using namespace plumbline::loop;
  if (count < 3) return 2;
  Job job;
  job.id = count > 3 ? arguments[3] : "job-1", job.revision = 1, job.basis = std::string(64, 'a');
  for (int i = 0; i < std::atoi(arguments[2]); ++i) {
    JobItem item;
    item.id = "F01-C0" + std::to_string(i + 1) + "-R1", item.kind = "bracket", item.operation = "setBracket";
    item.revision = 1, item.floor = 1, item.reason = "gate of its panels is GO";
    item.design = {2.0 * i, 0, 3}, item.target = {2.0 * i, 0, 3.004}, item.setting = {0, 0.004, 0};
    item.design_rotation = item.target_rotation =
        Eigen::Quaterniond(Eigen::AngleAxisd(0.5 * 3.14159265358979323846, Eigen::Vector3d::UnitX()));
    item.tolerance = {0.003, 0.003, 0.003}, item.p_in = 0.99;
    if (i > 0) item.depends_on = {job.items.back().id};
    job.items.push_back(item);
  }
  std::ofstream(arguments[1], std::ios::binary) << job_json(job);
}
