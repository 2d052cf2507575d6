#include "campaign_resolver.hpp"

#include <algorithm>

#include "base/text/name_order.hpp"
#include "base/text/words.hpp"
#include "plumbline/folder_files.hpp"

namespace plumbline::campaign {
namespace {

bool is_pattern(const std::string& text) { return text.find_first_of("*?") != std::string::npos; }

std::string in_small(std::string text) {
  for (char& c : text) c = c >= 'A' && c <= 'Z' ? static_cast<char>(c - 'A' + 'a') : c;
  return text;
}

/// "Tables.xlsx#Sheet" of a workbook that is there.
bool is_sheet_of(const std::vector<std::string>& files, const std::string& text) {
  const std::size_t mark = text.rfind(".xlsx#");
  return mark != std::string::npos && std::find(files.begin(), files.end(), text.substr(0, mark + 5)) != files.end();
}

}  // namespace

Resolver::Resolver(const Mapping& mapping, std::vector<std::string> files)
    : mapping_(mapping), files_(std::move(files)) {
  std::sort(files_.begin(), files_.end());
}

std::vector<std::string> Resolver::set_aside(std::vector<std::string>& remarks) {
  if (!mapping_.has("unused")) return {};
  const YAML::Node node = mapping_.get("unused");
  std::vector<std::string> found, sheets;
  const auto take = [&](const YAML::Node& item) {
    if (!item.IsScalar())
      mapping_.fail(item, "'unused' must be a file, a pattern such as old/**, or a list; what it names is left out");
    const std::size_t before = found.size();
    for (const std::string& file : files_)
      if (matches_pattern(item.Scalar(), file)) found.push_back(file);
    if (found.size() > before) return;
    if (is_sheet_of(files_, item.Scalar()))
      sheets.push_back(item.Scalar());
    else if (is_pattern(item.Scalar()))
      remarks.push_back(mapping_.shown().string() + ":" + std::to_string(line_of(item)) + ": 'unused' names '" +
                        item.Scalar() + "', which fits nothing here");
    else
      not_there("unused", item);
  };
  if (node.IsSequence())
    for (const YAML::Node& item : node) take(item);
  else
    take(node);
  unused_ = {found.begin(), found.end()};
  std::vector<std::string> all(unused_.begin(), unused_.end());
  all.insert(all.end(), sheets.begin(), sheets.end());
  return all;
}

std::string Resolver::one(const std::string& key) const {
  const std::vector<std::string> found = many(key);
  if (found.size() != 1) {
    mapping_.fail(mapping_.get(key), "'" + key + "' matches " + std::to_string(found.size()) + " files, expected one" +
                                         (found.empty() ? "" : ": " + text::join(found, 4)));
  }
  return found.front();
}

std::vector<std::string> Resolver::files_of(const std::string& key, const YAML::Node& node) const {
  std::vector<std::string> found = in_order(key, node);
  std::sort(found.begin(), found.end());
  return found;
}

std::vector<std::string> Resolver::in_order(const std::string& key, const YAML::Node& node) const {
  std::vector<std::string> found, once;
  Problems problems;
  if (node.IsSequence()) {
    for (const YAML::Node& item : node) problems.attempt([&] { add(key, item, found); });
  } else {
    add(key, node, found);
  }
  problems.raise();
  std::set<std::string> known;
  for (const std::string& file : found)
    if (known.insert(file).second) once.push_back(file);
  return once;
}

void Resolver::add(const std::string& key, const YAML::Node& node, std::vector<std::string>& found) const {
  if (!node.IsScalar()) mapping_.fail(node, "'" + key + "' must be a file, a pattern such as images/*.jpg, or a list");
  const std::string pattern = node.Scalar();
  const std::size_t before = found.size();
  for (const std::string& file : files_) {
    if (!matches_pattern(pattern, file)) continue;
    if (!is_pattern(pattern) && unused_.count(file))
      mapping_.fail(node, "'" + key + "' names '" + file + "', and 'unused' names it too; take it out of one");
    const bool passed_over = is_pattern(pattern) && (unused_.count(file) || is_system_file(file));
    if (!passed_over) found.push_back(file);
  }
  if (found.size() == before) not_there(key, node);
  std::sort(found.begin() + static_cast<std::ptrdiff_t>(before), found.end(), text::before_by_name);
}

void Resolver::not_there(const std::string& key, const YAML::Node& node) const {
  const std::string pattern = node.Scalar();
  std::string why = "the folder has no such file; paths are relative to campaign.yaml";
  std::vector<std::string> alike;
  for (const std::string& file : files_)
    if (matches_pattern(in_small(pattern), in_small(file)) && !is_system_file(file) && !unused_.count(file))
      alike.push_back(file);
  std::error_code ignored;
  if (!alike.empty())
    why += " and upper and lower case differ: there is " + alike.front() +
           (alike.size() > 1 ? " and " + std::to_string(alike.size() - 1) + " more" : "");
  else if (!is_pattern(pattern) && std::filesystem::is_directory(mapping_.shown().parent_path() / pattern, ignored))
    why = "that is a folder; name what is meant in it, such as " +
          (std::filesystem::path(pattern) / (key == "images" ? "*.jpg" : "*")).generic_string();
  else if (!is_pattern(pattern) && std::filesystem::exists(mapping_.shown().parent_path() / pattern, ignored))
    why = "that is the output of a run, which is no content of the folder; copy it to a place of its own";
  mapping_.fail(node, "'" + key + "' names '" + pattern + "', and " + why);
}

}  // namespace plumbline::campaign
