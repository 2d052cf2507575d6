#include "readings_nodes.hpp"

#include <algorithm>
#include <map>

#include "base/text/name_pattern.hpp"

namespace plumbline::survey_files {

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
  if (all.files.size() != observations.size())
    throw std::runtime_error(std::to_string(all.files.size()) + " files were given to readers, and " +
                             std::to_string(observations.size()) +
                             " were read: connect 'offered' and 'observations' of the same readers, in one order");
  std::map<std::string, std::string> reader_of;
  for (size_t i = 0; i < all.files.size(); ++i) {
    ReadSurveyFileT& file = *all.files[i];
    file.observations = std::make_unique<SurveyObservationsT>(observations.unpack(i));
    const auto [other, fresh] = reader_of.emplace(file.path, file.reader);
    if (!fresh)
      throw std::runtime_error(
          file.path + " is read by " + other->second + " and by " + file.reader +
          ", whose `files` both name it: take one of the two plugins away, or let one of them name "
          "fewer files");
    context.info(file.path + " is read by " + file.reader);
  }
  const auto by_path = [](const auto& a, const auto& b) { return a->path < b->path; };
  std::stable_sort(all.files.begin(), all.files.end(), by_path);
  std::stable_sort(all.unnamed.begin(), all.unnamed.end(), by_path);
  readings.commit(all);
}

}  // namespace plumbline::survey_files
