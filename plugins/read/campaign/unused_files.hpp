// What lies in the folder of a campaign and takes no part. Photographs and readings are evidence: nobody may believe
// that they were used when they were not, so those that nothing names end the run.
#pragma once

#include <map>

#include "campaign_folder.hpp"

namespace plumbline::campaign {

/// What each file that the campaign names is read as, by path: "campaign", "photograph", "observations", "camera",
/// "plates", "survey", "control", "design", "mapping", "tolerances".
std::map<std::string, std::string> uses_of(const CampaignDescription& description,
                                           const std::vector<std::string>& files);

struct UnusedFile {
  std::string path;
  /// A sheet of a workbook whose other sheets are read: the file has a use, this sheet none.
  std::string sheet = {};
  /// "photograph", "survey" (a file with readings), "control" (a table of known points, where none is named), or empty.
  std::string looks_like;
  bool set_aside = false;  ///< `unused` names it

  /// In messages and lists: "Tables.xlsx, sheet 'Control'".
  std::string name() const { return sheet.empty() ? path : path + ", sheet '" + sheet + "'"; }
};

/// All files without a use, ordered by path. What a file looks like is told by its name for photographs, else by its
/// content, which is read from `root`. Where control is left out (not: where a wrong key or a broken file may name it),
/// sheets of known points in workbooks that are named for something else are among them.
std::vector<UnusedFile> unused_files(const CampaignDescription& description, const std::filesystem::path& root,
                                     std::vector<std::string> files);

/// Tables of known points that nothing names, where 'control' is left out; none if it is there. A network without
/// its known points looks whole and lies elsewhere.
std::vector<std::string> forgotten_control(const std::vector<UnusedFile>& unused);
/// What to say of them, and what to do; `names` is not empty.
std::string words_of_forgotten_control(const std::vector<std::string>& names);

/// Throws CampaignError that names the photographs and survey files which nothing uses or sets aside, and what to write
/// into campaign.yaml. With CampaignUse::survey photographs may lie there, and where tags were measured already, too.
/// Where campaign.yaml has mistakes (not `understood`) only kinds of which it names some are told.
void refuse_forgotten(const std::vector<UnusedFile>& unused, const CampaignDescription& description,
                      const std::filesystem::path& root, CampaignUse use, bool understood);

/// Whether the file holds readings of an instrument. Tables may hold anything: they count if they have some that
/// can be read, or the columns of sightings, whatever is wrong with them. Instruments' files count even where they are
/// damaged.
bool holds_readings(const std::filesystem::path& path, const std::string& name);

/// The files as campaign.yaml would name them: by a pattern where several of a folder end alike.
std::vector<std::string> patterns_for(const std::vector<std::string>& names);

}  // namespace plumbline::campaign
