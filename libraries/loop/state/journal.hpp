// An append-only journal: one line of JSON for each change, each with the SHA-256 of the line before. Who changes,
// inserts or takes out a line breaks the chain from there on; reading it finds the place.
#pragma once

#include <string>
#include <vector>

namespace plumbline::loop {

struct JournalEntry {
  int round = 0;
  std::string item, kind;             ///< "F01-P02", "panel"
  std::string from, to;               ///< states
  std::string by, at, why;            ///< who, when (ISO 8601; may be empty in a simulation), reason
  std::vector<std::string> rests_on;  ///< hashes of the artifacts it rests on
  std::string reason = {};            ///< the reason for programs, a name of ItemReason; empty: none
  int reported_revision = 0;          ///< of a report on an order that was recalled: the revision of that order
  int answered_revision = 0;          ///< of such an order: what became of it is known from here on; 0: says nothing
};

/// What the first line has for the hash of the line before: 64 zeros.
std::string journal_start();

/// Hash that the next line carries: of the last line, without its end. journal_start() of an empty journal.
std::string journal_head(const std::vector<std::string>& lines);

/// One line without its end: keys previous, round, item, kind, from, to, by, at, why, rests_on, in this order; then
/// reason, reported_revision and answered_revision, if there are such.
std::string journal_line(const JournalEntry& entry, const std::string& previous);

/// Number (from 1) of the first line that is not JSON, lacks a key or whose `previous` is not the hash of the line
/// before, with what is wrong; 0 and empty if the chain holds.
struct JournalFault {
  std::size_t line = 0;
  std::string words;
};
JournalFault check_journal(const std::vector<std::string>& lines);

}  // namespace plumbline::loop
