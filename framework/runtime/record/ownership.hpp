// What run.jsonl says of the files in its folder: the lines that prove who wrote them.
//
//   {"event":"run_start", ..., "staging", "owned"}                    what earlier runs left, taken over
//   {"event":"deliver","output","number","files":{path: sha256},"folders":[...]}   before anything is put in place
//   {"event":"run_end", ..., "owned"}                                 the final state
#pragma once

#include <filesystem>
#include <set>

#include "runtime/record/output_folder.hpp"

namespace plumbline::runtime {

/// Reads the record of a run. False if the file is no such record; lines cut off by a crash are passed over.
/// `displaced` gets, for every delivery, the name of its old tree in the staging folder.
bool read_ownership(const std::filesystem::path& record, Ownership& owned, std::string& staging,
                    std::map<std::string, std::string>& displaced);

/// The text of a deliver line.
std::string deliver_line(const std::string& output, size_t number, const std::map<std::string, std::string>& files,
                         const std::set<std::string>& folders);

/// {"files": {path: [sha256]}, "made_from", "folders", "origins": {output: {"time", "arguments"}}}, as JSON text.
std::string ownership_text(const Ownership& owned);

/// ", process 123 on host since 2026-11-21T23:47:49Z", or nothing.
std::string record_owner(const std::filesystem::path& record);

}  // namespace plumbline::runtime
