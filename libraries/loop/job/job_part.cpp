// One job for several robots: each gets the items of its floors.
#include <algorithm>
#include <stdexcept>

#include "base/text/words.hpp"
#include "loop/job/job.hpp"

namespace plumbline::loop {

Job part_of(const Job& job, const std::set<int>& floors) {
  if (floors.empty()) return job;
  std::set<int> there;
  for (const JobItem& item : job.items) there.insert(item.floor);
  Job part = job;
  for (const int floor : floors) {
    if (!there.contains(floor)) {
      std::vector<std::string> words;
      for (const int one : there) words.push_back(std::to_string(one));
      throw std::runtime_error("floor " + std::to_string(floor) + " has no item of job " + job.id +
                               "; expected one of its floors: " + text::join(words));
    }
    part.part += "-F" + std::to_string(floor);
  }
  std::erase_if(part.items, [&](const JobItem& item) { return !floors.contains(item.floor); });
  return part;
}

}  // namespace plumbline::loop
