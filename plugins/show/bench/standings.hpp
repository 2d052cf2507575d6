// Where each alternative of a group is beaten, by how much, and what else counts against taking it.
#pragma once

#include <map>
#include <set>
#include <string>
#include <vector>

#include "show/bench/pairing.hpp"

namespace plumbline::bench {

struct Standing {
  std::vector<std::string> beaten_on, untried;        ///< places
  double most = 0;                                    ///< largest difference by which it is beaten on one of them [m]
  bool beaten_overall = false, best_overall = false;  ///< by the verdict with the file's weights; best: and beats some
  double most_overall = 0;                            ///< [m]
  std::size_t cells = 0, failed = 0, useless = 0;
  struct Count {
    std::size_t cells = 0, lost = 0;  ///< lost: without result, or of no use
  };
  std::map<std::string, Count> at;                      ///< by place
  std::size_t unplanned = 0;                            ///< cells of which no pipeline could be made
  std::map<Stated, std::vector<std::string>> untested;  ///< who wins by more results that its own test forbids
  std::set<std::string> untested_on;                    ///< places
  std::set<const Cell*> forbidden;                      ///< its cells there that its own test forbids and they give
  bool compared = false;                                ///< with enough trials for a verdict
  std::set<std::string> compared_on;                    ///< places
  bool is_beaten() const { return beaten_overall || !beaten_on.empty(); }
};
using Standings = std::map<std::string, Standing>;

Standings standings_of(const Bench& bench, const Group& group, const Analysis& analysis,
                       const std::vector<Pairing>& pairs);

}  // namespace plumbline::bench
