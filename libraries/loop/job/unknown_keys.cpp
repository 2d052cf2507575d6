#include "loop/job/unknown_keys.hpp"

#include <algorithm>
#include <cctype>
#include <set>
#include <stdexcept>

#include "base/text/near_text.hpp"
#include "base/text/words.hpp"

namespace plumbline::loop {
namespace {

using Json = nlohmann::ordered_json;

std::string bare(const std::string& key) {
  std::string out;
  for (const unsigned char c : key)
    if (std::isalnum(c)) out += static_cast<char>(std::tolower(c));
  return out;
}

}  // namespace

std::string meant_by(const std::string& key, const std::vector<std::string>& known) {
  const std::string wanted = bare(key).substr(0, 64);
  std::string best;
  std::size_t least = 1000;
  for (const std::string& candidate : known) {
    const std::string other = bare(candidate);
    const std::size_t apart = text::letter_edits(wanted, other);
    if (apart <= other.size() / 4 && apart < least) best = candidate, least = apart;
  }
  return best;
}

void note_unknown_keys(const Json& object, const std::vector<std::string>& known, std::map<std::string, int>& ignored) {
  for (const auto& [key, value] : object.items()) {
    if (std::find(known.begin(), known.end(), key) != known.end()) continue;
    if (const std::string meant = meant_by(key, known); !meant.empty())
      throw std::runtime_error("has '" + key + "', which is no key; '" + meant + "' is");
    ++ignored[key];
  }
}

std::string words_of_ignored(const std::map<std::string, int>& ignored) {
  std::vector<std::string> names;
  for (const auto& [key, count] : ignored)
    names.push_back("'" + key.substr(0, 60) + "'" + (count > 1 ? " (" + std::to_string(count) + " times)" : ""));
  if (names.empty()) return {};
  const bool one = names.size() == 1;
  if (names.size() > 8) names.resize(8), names.push_back("others");
  return text::enumerate(names) + (one ? " is not read" : " are not read");
}

Json parse_each_key_once(std::string_view text) {
  std::vector<std::set<std::string>> open;
  const auto look = [&](int, Json::parse_event_t event, Json& parsed) {
    if (event == Json::parse_event_t::object_start) open.emplace_back();
    if (event == Json::parse_event_t::object_end) open.pop_back();
    if (event == Json::parse_event_t::key && !open.back().insert(parsed.get<std::string>()).second)
      throw std::runtime_error("has '" + parsed.get<std::string>() +
                               "' twice in one object: which of the two counts nobody can tell");
    return true;
  };
  try {
    return Json::parse(text, look);
  } catch (const Json::exception& error) {
    const std::string words = error.what();  // "[json.exception.parse_error.101] parse error at line 1, column 29: ..."
    const auto begin = words.find("] ");
    throw std::runtime_error("is no JSON: " + (begin == std::string::npos ? words : words.substr(begin + 2)));
  }
}

void refuse_other_units(const Json& object, const std::vector<std::string>& frames) {
  for (const char* key : {"units", "unit"}) {
    if (!object.contains(key)) continue;
    const Json& said = object[key];
    const Json& length = said.is_object() && said.contains("length") ? said["length"] : said;
    if (length != "m" && length != "metre" && length != "metres" && length != "meter" && length != "meters")
      throw std::runtime_error("'" + std::string(key) + "' is " + said.dump().substr(0, 60) +
                               "; lengths are in metres: expected \"m\"");
  }
  if (object.contains("frame") && std::find(frames.begin(), frames.end(), object["frame"]) == frames.end())
    throw std::runtime_error("'frame' is " + object["frame"].dump().substr(0, 60) +
                             "; places are in the frame of the job, expected " + Json(frames).dump());
}

}  // namespace plumbline::loop
