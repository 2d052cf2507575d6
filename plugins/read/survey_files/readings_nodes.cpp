#include "readings_nodes.hpp"

#include <algorithm>
#include <map>

#include "base/text/name_pattern.hpp"

namespace plumbline::survey_files {

namespace {

std::string names_of(const SurveyReadingsT& readings) {
  std::string names;
  for (const auto& file : readings.files) names += (names.empty() ? "" : ", ") + file->path;
  return names.empty() ? "none" : names;
}

}  // namespace

void FileForReader::run(Context&) {
  SurveyReadingsT offer;
  const std::string name = file->name()->str();
  if (text::is_named_by(*files, name)) {
    taken.commit(file.unpack());
    auto one = std::make_unique<ReadSurveyFileT>();
    one->path = name, one->reader = *reader;
    offer.files.push_back(std::move(one));
  }
  offered.commit(offer);
}

void CollectReadings::run(Context& context) {
  SurveyReadingsT all;
  for (size_t i = 0; i < offered.size(); ++i) {
    SurveyReadingsT one = offered.unpack(i);
    std::move(one.files.begin(), one.files.end(), std::back_inserter(all.files));
    std::move(one.unnamed.begin(), one.unnamed.end(), std::back_inserter(all.unnamed));
  }
  std::map<std::string, std::string> reader_of;
  for (const auto& file : all.files)
    if (const auto [other, fresh] = reader_of.emplace(file->path, file->reader); !fresh)
      throw std::runtime_error(
          file->path + " is read by " + other->second + " and by " + file->reader +
          ", whose `files` both name it: take one of the two plugins away, or let one of them name "
          "fewer files");
  // By name: the order in which readers are connected is the pipeline's, and says nothing of what they read.
  std::map<std::string, std::unique_ptr<SurveyObservationsT>> read;
  for (size_t i = 0; i < observations.size(); ++i) {
    auto one = std::make_unique<SurveyObservationsT>(observations.unpack(i));
    const std::string path = one->files.size() == 1 ? one->files.front() : std::string();
    if (!reader_of.contains(path))
      throw std::runtime_error(
          "observations[" + std::to_string(i) + "] " +
          (path.empty() ? "names " + std::to_string(one->files.size()) + " files" : "is of " + path) +
          ", and the files given to readers are " + names_of(all) +
          ": connect 'offered' and 'observations' of the same readers; a reader names the one "
          "file it read, as it got it");
    if (!read.emplace(path, std::move(one)).second)
      throw std::runtime_error(path + " was read twice: connect each reader to 'observations' once");
  }
  for (auto& file : all.files) {
    const auto found = read.find(file->path);
    if (found == read.end())
      throw std::runtime_error(file->path + " was given to " + file->reader +
                               ", and nothing that was read is of it: connect its 'observations'");
    file->observations = std::move(found->second);
    context.info(file->path + " is read by " + file->reader);
  }
  const auto by_path = [](const auto& a, const auto& b) { return a->path < b->path; };
  std::stable_sort(all.files.begin(), all.files.end(), by_path);
  std::stable_sort(all.unnamed.begin(), all.unnamed.end(), by_path);
  readings.commit(all);
}

}  // namespace plumbline::survey_files
