#include "campaign_yaml.hpp"

#include <algorithm>

#include "base/text/one_document.hpp"
#include "base/text/words.hpp"

namespace plumbline::campaign {
namespace {

std::size_t edit_distance(const std::string& a, const std::string& b) {
  std::vector<std::size_t> row(b.size() + 1);
  for (std::size_t j = 0; j <= b.size(); ++j) row[j] = j;
  for (std::size_t i = 1; i <= a.size(); ++i) {
    std::size_t diagonal = row[0];
    row[0] = i;
    for (std::size_t j = 1; j <= b.size(); ++j) {
      const std::size_t substituted = diagonal + (a[i - 1] == b[j - 1] ? 0 : 1);
      diagonal = row[j];
      row[j] = std::min({row[j] + 1, row[j - 1] + 1, substituted});
    }
  }
  return row[b.size()];
}

}  // namespace

std::string near_name(const std::string& word, const std::vector<std::string>& known) {
  const auto near = std::min_element(known.begin(), known.end(), [&](const auto& a, const auto& b) {
    return edit_distance(word, a) < edit_distance(word, b);
  });
  return near != known.end() && edit_distance(word, *near) <= 2 ? *near : "";
}

YAML::Node load_yaml(const std::string& yaml, const std::filesystem::path& shown) {
  try {
    return text::load_one_document(yaml);
  } catch (const YAML::Exception& error) {
    throw CampaignError(shown, error.mark.line + 1, "this is no YAML: " + error.msg);
  }
}

Mapping::Mapping(const YAML::Node& node, const std::filesystem::path& shown, const std::vector<std::string>& known,
                 Problems* problems)
    : node_(node), shown_(shown) {
  if (!node.IsMap()) throw CampaignError(shown, 0, "found no mapping of keys, expected " + text::join(known));
  std::set<std::string> seen;
  for (const auto& entry : node) {
    const auto check = [&] { check_key(entry.first, known, seen); };
    problems ? static_cast<void>(problems->attempt(check)) : check();
  }
}

void Mapping::check_key(const YAML::Node& at, const std::vector<std::string>& known, std::set<std::string>& seen) {
  if (!at.IsScalar()) fail(at, "a key must be a single word; known are " + text::join(known));
  const std::string key = at.Scalar();
  if (!seen.insert(key).second) fail(at, "'" + key + "' stands here a second time");
  if (std::find(known.begin(), known.end(), key) != known.end()) return;
  const std::string near = near_name(key, known);
  if (!near.empty()) meant_.insert(near);
  fail(at, "unknown key '" + key + "'" +
               (near.empty() ? "; known are " + text::join(known) : ", did you mean '" + near + "'?"));
}

}  // namespace plumbline::campaign
