#include "reader_files_node.hpp"

#include <algorithm>

#include "base/text/whole_file.hpp"
#include "campaign_artifacts.hpp"
#include "plumbline/folder_files.hpp"

namespace plumbline::campaign {
namespace {

/// Survey files and what is set aside. What is wrong with the folder its campaign tells, which reads all of it.
CampaignDescription survey_of(const std::filesystem::path& root, const std::vector<std::string>& names) {
  Problems told_by_the_campaign;
  CampaignDescription description;
  told_by_the_campaign.attempt([&] {
    const std::filesystem::path yaml = root / "campaign.yaml";
    const bool there = std::find(names.begin(), names.end(), "campaign.yaml") != names.end();
    description = there ? parse_campaign(text::read_whole(yaml), yaml, names, CampaignUse::survey, told_by_the_campaign)
                        : find_campaign(root, names);
  });
  return description;
}

}  // namespace

void FilesForReader::run(Context& context) {
  const FolderT given = folder.unpack();
  const std::filesystem::path root = context.resolve(given.uri);
  std::vector<std::string> names;
  for (const auto& entry : given.files) names.push_back(entry->path);
  std::sort(names.begin(), names.end());
  const CampaignDescription description = survey_of(root, names);
  const auto among = [](const std::vector<std::string>& list, const std::string& name) {
    return std::find(list.begin(), list.end(), name) != list.end();
  };
  SurveyReadingsT offer;
  for (const std::string& path : names) {
    if (is_system_file(path) || !text::is_named_by(*files, path)) continue;
    if (among(description.survey, path)) {
      FileT file;
      const std::string bytes = text::read_whole(root / path);
      file.name = path;
      file.content.assign(bytes.begin(), bytes.end());
      taken.commit(file);
      offer.files.push_back(std::make_unique<ReadSurveyFileT>());
      offer.files.back()->path = path, offer.files.back()->reader = *reader;
    } else {  // also what `unused` sets aside: the campaign tells which it is
      offer.unnamed.push_back(std::make_unique<UnnamedSurveyFileT>());
      offer.unnamed.back()->path = path, offer.unnamed.back()->reader = *reader;
    }
  }
  offered.commit(offer);
}

}  // namespace plumbline::campaign
