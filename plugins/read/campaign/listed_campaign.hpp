// A campaign's folder as its nodes take it: what it holds, what campaign.yaml says of it, and what is wrong so far.
#pragma once

#include <filesystem>
#include <map>

#include "artifacts/folder.hpp"
#include "artifacts/input_files.hpp"
#include "artifacts/survey_observations.hpp"
#include "artifacts/survey_readings.hpp"
#include "campaign_artifacts.hpp"
#include "plumbline/node.hpp"
#include "unused_files.hpp"

namespace plumbline::campaign {

/// Every part of the folder is read inside problems.attempt(), and problems.raise() stands before the first commit: a
/// folder's mistakes are told all at once.
struct ListedCampaign {
  /// Reads campaign.yaml, or finds the parts by their names where that may be missing (CampaignUse::photographs), and
  /// looks for what was forgotten. `readings`: what readers of other plugins have read. What is wrong is in `problems`.
  ListedCampaign(FolderT given, std::filesystem::path root, CampaignUse use, SurveyReadingsT readings = {});

  const FolderEntryT& entry(const std::string& path) const { return *entries.at(path); }
  std::vector<std::string> names() const;

  /// What was read or set aside, and how much of it (readings_of()); and what lies there besides. Says to `context` how
  /// much was read.
  InputFilesT inputs(Context& context, std::size_t images, long readings) const;
  InputFilesT unread() const;
  /// Says which tables of known points nothing names (a survey without them may look whole and lie elsewhere), and
  /// which patterns of `unused` fit nothing.
  void warn_of_what_is_left(Context& context) const;

  FolderT given;
  std::filesystem::path root;
  std::map<std::string, const FolderEntryT*> entries;
  CampaignDescription description;
  AddedReadings added;
  std::vector<UnusedFile> unused;
  Problems problems;
};

}  // namespace plumbline::campaign
