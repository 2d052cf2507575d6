// What the rounds beside a job's own say of it: a round that went on from that one, and what a robot was given before
// and this round knows nothing of.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "loop/job/job.hpp"

namespace plumbline::loop {

/// One line of a file *.given.jsonl: a robot's from then on.
struct GivenItem {
  std::string item;
  int revision = 0;
  std::string robot;  ///< MANUFACTURER/SERIAL
  std::string order;  ///< the orderId it was given in; empty where the line says none
  std::filesystem::path file;
  /// Lines that the journal of its round had by then; npos: the line does not say it.
  std::size_t since = std::string::npos;
};

/// In the order of the lines; none where there is no file. Throws std::runtime_error with file and line for one that
/// does not say item, revision and robot: what it gives away is not known.
std::vector<GivenItem> given_lines(const std::filesystem::path& file);

/// Lines of the journal of the round in `folder`; 0: it has none.
std::size_t journal_lines(const std::filesystem::path& folder);

/// The folder of the last round that goes on from the one in `folder` (journal.next, whose journal begins with that of
/// `folder`); empty: none. What it recalled is not asked for any more, what it still asks for its own job has.
std::filesystem::path later_round(const std::filesystem::path& folder);

/// Items of the job that a robot was given in another order, before this round or beside it, and of which the journal
/// in `folder` has no report since: who did not say that it is done may have done it, or may be about to. Looked
/// through are `given` (the file of this job, or of a site) and the *.given.jsonl of the rounds in folders beside
/// `folder` that this one goes on from. An item whose revision is that of the job's cannot have been reported.
/// Of an order that was recalled counts that what became of it is known (JournalEntry::answered_revision). `folder`
/// empty, or no journal in it: what was reported is not known, and only items of the job's own revisions are held.
/// `robot`: whose order `order` is; that one it goes on with. Throws what given_lines() throws.
std::vector<GivenItem> unanswered(const std::filesystem::path& folder, const std::filesystem::path& given,
                                  const Job& job, const std::string& robot, const std::string& order);

}  // namespace plumbline::loop
