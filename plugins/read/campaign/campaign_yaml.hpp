// YAML files of a campaign: mappings with known keys, and what is wrong with them in words.
#pragma once

#include <yaml-cpp/yaml.h>

#include <cmath>
#include <set>

#include "campaign_folder.hpp"

namespace plumbline::campaign {

inline int line_of(const YAML::Node& node) { return node.Mark().line + 1; }

/// The name among `known` that `word` is nearly written like; empty if there is none.
std::string near_name(const std::string& word, const std::vector<std::string>& known);

/// Throws CampaignError if it is no YAML.
YAML::Node load_yaml(const std::string& yaml, const std::filesystem::path& shown);

/// Told already by its wrong name; nothing to add.
struct ToldAlready {};

/// A mapping with known keys; every use of a wrong one is an error that names the nearest right one.
class Mapping {
 public:
  /// Without `problems` the first wrong key is thrown.
  Mapping(const YAML::Node& node, const std::filesystem::path& shown, const std::vector<std::string>& known,
          Problems* problems = nullptr);

  [[noreturn]] void fail(const YAML::Node& at, const std::string& what) const {
    throw CampaignError(shown_, line_of(at), what);
  }
  YAML::Node get(const std::string& key) const {
    const YAML::Node value = node_[key];
    if (!value && meant_.count(key)) throw ToldAlready();
    if (!value) throw CampaignError(shown_, line_of(node_), "the key '" + key + "' is missing");
    return value;
  }
  bool has(const std::string& key) const { return static_cast<bool>(node_[key]); }
  const std::filesystem::path& shown() const { return shown_; }
  template <typename T>
  T as(const std::string& key, const char* expected) const {
    const YAML::Node value = get(key);
    try {
      return value.as<T>();
    } catch (const YAML::Exception&) {
      fail(value, "'" + key + "' is '" + (value.IsScalar() ? value.Scalar() : "(no single value)") + "', expected " +
                      expected);
    }
  }
  double number(const std::string& key) const {
    const double value = as<double>(key, "a number");
    if (!std::isfinite(value)) fail(get(key), "'" + key + "' is not a finite number");
    return value;
  }
  void require_version(const std::string& key) const {
    if (as<int>(key, "the version 1") != 1) fail(get(key), "this program reads version 1 of '" + key + "'");
  }

 private:
  void check_key(const YAML::Node& at, const std::vector<std::string>& known, std::set<std::string>& seen);

  YAML::Node node_;
  std::filesystem::path shown_;
  std::set<std::string> meant_;  // by wrong keys
};

}  // namespace plumbline::campaign
