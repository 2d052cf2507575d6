// Keys that a report, a robot's result or a job has and nobody reads.
#pragma once

#include <map>
#include <nlohmann/json.hpp>
#include <string>
#include <string_view>
#include <vector>

namespace plumbline::loop {

/// The one of `known` that `key` seems to mean: the same but for capitals and separators, or one letter in four is
/// missing, too many, another one or exchanged with the next. Empty: none.
std::string meant_by(const std::string& key, const std::vector<std::string>& known);

/// Keys of `object` that are none of `known`, each counted in `ignored`. Throws std::runtime_error for one that seems
/// to mean a known one: what it says would be lost.
void note_unknown_keys(const nlohmann::ordered_json& object, const std::vector<std::string>& known,
                       std::map<std::string, int>& ignored);

/// "'temperature' (3 times) and 'speed' are not read"; empty: nothing is ignored.
std::string words_of_ignored(const std::map<std::string, int>& ignored);

/// Parses; throws std::runtime_error for text that is no JSON, with line and column, and for a key that an object has
/// twice: which of the two counts nobody could tell.
nlohmann::ordered_json parse_each_key_once(std::string_view text);

/// Throws std::runtime_error if `object` says a unit of lengths other than metres, or a frame that is none of `frames`:
/// as "units": {"length": "m"}, "unit": "m", "frame": "building".
void refuse_other_units(const nlohmann::ordered_json& object, const std::vector<std::string>& frames);

}  // namespace plumbline::loop
