// What a setting of a combination reaches in its pipeline. One whose every use another setting replaces changes
// nothing, and cells would stand under its name that do not have it.
#pragma once

#include <filesystem>
#include <map>
#include <set>
#include <string>
#include <utility>
#include <vector>

#include "runtime/graph/pipeline_file.hpp"

namespace plumbline::runtime {

class SettingReach {
 public:
  explicit SettingReach(const Registry& registry) : registry_(registry) {}

  /// Of the overrides `all` of a pipeline ("KEY=VALUE", in order) those that together take away all that one of them,
  /// `text`, sets as a variable. Empty where it still reaches something, nothing ever used it, or they say the same.
  std::vector<std::string> replacing(const std::filesystem::path& pipeline, const std::vector<std::string>& all,
                                     const std::string& text);

  /// Whether a variable may reach one of these nodes, or the rounds, where `all` holds. In doubt it does.
  bool reaches(const std::filesystem::path& pipeline, std::vector<std::string> all, const std::string& variable,
               const std::set<std::string>& nodes) const;

 private:
  struct Uses {
    std::set<std::string> places;     ///< "block.with.sigma", "poses.use", …
    std::set<std::string> variables;  ///< that take their value from it
  };
  using Fields = std::map<std::string, std::string>;

  const Uses& uses_of(const std::filesystem::path& pipeline, const std::string& key);
  Fields fields(const std::filesystem::path& pipeline, const std::vector<std::string>& overrides) const;

  const Registry& registry_;
  std::map<std::pair<std::filesystem::path, std::string>, Uses> uses_;
};

}  // namespace plumbline::runtime
