// What the keys of campaign.yaml name in the folder.
#pragma once

#include "campaign_yaml.hpp"

namespace plumbline::campaign {

/// Patterns pass over what systems write beside people's files, and over what `unused` names. Errors are
/// CampaignErrors with the line of campaign.yaml.
class Resolver {
 public:
  Resolver(const Mapping& mapping, std::vector<std::string> files);

  /// What `unused` names, sheets of workbooks ("Tables.xlsx#Sheet") behind the files; to be called first. A name that
  /// is not there is an error; a pattern without a match is none, because `unused: old/**` may stand in every
  /// campaign.yaml of an office, and goes to `remarks`.
  std::vector<std::string> set_aside(std::vector<std::string>& remarks);
  std::string one(const std::string& key) const;
  /// A file, a pattern, or a list of them.
  std::vector<std::string> many(const std::string& key) const { return files_of(key, mapping_.get(key)); }
  std::vector<std::string> files_of(const std::string& key, const YAML::Node& node) const;
  /// As written, each once; those of a pattern by their names as people count: m2 before m10.
  std::vector<std::string> in_order(const std::string& key, const YAML::Node& node) const;
  std::vector<std::string> in_order(const std::string& key) const { return in_order(key, mapping_.get(key)); }

 private:
  void add(const std::string& key, const YAML::Node& node, std::vector<std::string>& found) const;
  [[noreturn]] void not_there(const std::string& key, const YAML::Node& node) const;

  const Mapping& mapping_;
  std::vector<std::string> files_;
  std::set<std::string> unused_;
};

}  // namespace plumbline::campaign
