#include "listed_campaign.hpp"

#include "artifacts/input_files_text.hpp"
#include "base/text/whole_file.hpp"
#include "campaign_artifacts.hpp"

namespace plumbline::campaign {
namespace {

std::unique_ptr<InputFileT> file_of(const FolderEntryT& entry, const std::string& use, bool read) {
  auto file = std::make_unique<InputFileT>();
  file->path = entry.path, file->sha256 = entry.sha256, file->size = entry.size;
  file->use = use, file->read = read;
  return file;
}

}  // namespace

ListedCampaign::ListedCampaign(FolderT listed, std::filesystem::path at, CampaignUse use, SurveyReadingsT readings)
    : given(std::move(listed)), root(std::move(at)) {
  for (const auto& file : readings.files) added[file->path] = std::move(file->observations);
  for (const auto& file : given.files) entries[file->path] = file.get();
  const std::filesystem::path yaml = root / "campaign.yaml";
  const bool there = entries.count("campaign.yaml") > 0;
  description.control_left_out = false;  // until somebody has read what the folder holds
  problems.attempt([&] {
    refuse_misnamed_campaign(root, names());
    if (there)
      description = parse_campaign(text::read_whole(yaml), yaml, names(), use, problems);
    else if (use == CampaignUse::photographs)
      description = find_campaign(root, names());
    else
      throw CampaignError(yaml, 0,
                          "this file is missing; it tells what the folder holds: `plumbline campaign init FOLDER` "
                          "writes one of what lies there");
  });
  const bool understood = problems.empty();
  unused = unused_files(description, root, names());
  for (const auto& file : readings.unnamed)  // what they are, only the reader of another plugin knows
    for (UnusedFile& left : unused)
      if (left.path == file->path) left.looks_like = "survey";
  // What a wrong key does not name is not forgotten: of a file with mistakes only kinds whose own key was understood
  // are told.
  problems.attempt([&] { refuse_forgotten(unused, description, root, use, understood); });
}

std::vector<std::string> ListedCampaign::names() const {
  std::vector<std::string> all;
  for (const auto& file : given.files) all.push_back(file->path);
  return all;
}

InputFilesT ListedCampaign::inputs(Context& context, std::size_t images, long readings) const {
  InputFilesT result;
  const auto uses = uses_of(description, names());
  std::map<std::string, const UnusedFile*> aside;
  for (const UnusedFile& file : unused)
    if (file.set_aside && !file.looks_like.empty() && file.sheet.empty()) aside[file.path] = &file;
  for (const auto& [path, listed] : entries) {
    if (const auto use = uses.find(path); use != uses.end())
      result.files.push_back(file_of(*listed, use->second, true));
    else if (const auto left = aside.find(path); left != aside.end())
      result.files.push_back(file_of(*listed, left->second->looks_like, false));
  }
  for (const UnusedFile& sheet : unused) {
    if (!sheet.set_aside || sheet.sheet.empty()) continue;
    result.files.push_back(file_of(entry(sheet.path), sheet.looks_like, false));
    result.files.back()->path = sheet.name();
  }
  result.images = static_cast<int>(images), result.readings = static_cast<int>(readings);
  context.info("read: " + what_took_part(result) + " of the folder");
  return result;
}

InputFilesT ListedCampaign::unread() const {
  InputFilesT result;
  for (const UnusedFile& file : unused)
    if (!file.set_aside || file.looks_like.empty()) {
      result.files.push_back(file_of(entry(file.path), file.looks_like, false));
      result.files.back()->path = file.name();
    }
  return result;
}

void ListedCampaign::warn_of_what_is_left(Context& context) const {
  for (const std::string& remark : description.remarks) context.warn(remark);
  const std::vector<std::string> names = forgotten_control(unused);
  if (!names.empty()) context.warn(words_of_forgotten_control(names));
}

}  // namespace plumbline::campaign
