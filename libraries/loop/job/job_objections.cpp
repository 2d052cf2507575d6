// Why a robot does not take a job that can be read.
#include "loop/job/job.hpp"
#include "loop/state/date.hpp"

namespace plumbline::loop {

std::vector<std::string> job_objections(const Job& job, int newest_revision, const std::string& now,
                                        const std::string& basis) {
  std::vector<std::string> objections;
  if (job.revision < newest_revision)
    objections.push_back("job " + job.id + " is revision " + std::to_string(job.revision) + ", revision " +
                         std::to_string(newest_revision) + " is out: fetch that one");
  const auto until = seconds_of(job.valid_until), here = seconds_of(now);
  if (!job.valid_until.empty() && !until)
    objections.push_back("job " + job.id + " is valid until '" + job.valid_until +
                         "', expected ISO 8601 with a zone, such as 2026-05-02T08:00:00Z");
  if (!now.empty() && !here) objections.push_back("the date of today, '" + now + "', is none: ISO 8601 with a zone");
  const auto made = seconds_of(job.created_at);
  constexpr double kClocks = 300;  // what two clocks that nobody looks after may differ by [s]
  if (!job.created_at.empty() && !made)
    objections.push_back("job " + job.id + " was made at '" + job.created_at +
                         "', expected ISO 8601 with a zone, such as 2026-05-02T08:00:00Z");
  if (until && made && *until <= *made)
    objections.push_back("job " + job.id + " is valid until " + job.valid_until + " and was made later, at " +
                         job.created_at);
  else if (until && here && made && *made > *here + kClocks)
    objections.push_back("job " + job.id + " was made at " + job.created_at + ", it is " + now +
                         " by the clock of this machine: until when the job is valid cannot be told; mend the clock");
  if (until && here && *until < *here)
    objections.push_back("job " + job.id + " was valid until " + job.valid_until + ", it is " + now);
  if (!basis.empty() && job.basis != basis)
    objections.push_back("job " + job.id + " rests on another adjustment (" + job.basis.substr(0, 12) +
                         ") than the robot is localised in (" + basis.substr(0, 12) + ")");
  return objections;
}

}  // namespace plumbline::loop
