// read.@name@: reads a survey file of your own format, fixtures/example.@name@ for now. SurveyBuilder keeps set-ups,
// points and pointings in order, and lists what could not be used with line and column.
#include <charconv>
#include <sstream>

#include "artifacts/file.hpp"
#include "artifacts/survey_artifact.hpp"
#include "artifacts/survey_observations.hpp"
#include "plumbline/node.hpp"
#include "survey/files/survey_builder.hpp"

using namespace plumbline;

namespace {

/// Whole words only, and a point whatever the locale.
bool number(const std::string& word, double& value) {
  const auto [end, error] = std::from_chars(word.data(), word.data() + word.size(), value);
  return error == std::errc() && end == word.data() + word.size() && std::isfinite(value);
}

survey::SurveyObservations read(const std::string& text, const std::string& name) {
  survey::SurveyBuilder builder(name, "@name@");
  std::istringstream lines(text);
  std::string line;
  for (int at = 1; std::getline(lines, line); ++at) {
    std::istringstream words_of(line);
    const std::vector<std::string> words{std::istream_iterator<std::string>(words_of), {}};
    if (words.empty() || words[0][0] == '#') continue;
    double n[4];
    if (words.size() == 3 && words[0] == "AT" && number(words[2], n[0])) {
      builder.start_set_up(words[1], n[0], builder.at(at));
    } else if (words.size() == 5 && builder.current_set_up() >= 0 && number(words[1], n[0]) && number(words[2], n[1]) &&
               number(words[3], n[2]) && number(words[4], n[3])) {
      survey::Sighting sighting;
      sighting.to = words[0];
      sighting.direction = survey::gon_to_rad(n[0]);
      sighting.zenith_angle = survey::gon_to_rad(n[1]);
      sighting.slope_distance = n[2];
      sighting.target_height = n[3];
      sighting.source = builder.at(at);
      builder.point(sighting.to, sighting.source);
      builder.add(sighting);
    } else {
      builder.skip(at, 1, line, "AT SET-UP HEIGHT, or below one TARGET DIRECTION ZENITH DISTANCE HEIGHT");
    }
  }
  return builder.finish("no line with a reading", "lines as in fixtures/example.@name@");
}

struct Reader : Node {
  static constexpr Info info{"read.@name@", "survey_reader", 1, "Reads survey files of @name@"};
  In<File> file{"file", "the survey file"};
  Out<SurveyObservations> observations{"observations", frame("frame=building"),
                                       "what it holds, everything skipped named"};
  Param<bool> strict{"strict", false, "refuse a file of which anything has to be skipped"};
  // What of a site's folder is this reader's: with it campaigns and survey_network find it by its role.
  Param<std::vector<std::string>> files{"files", {"*.@name@"}, "names of the files that it reads"};

  void run(Context& context) override {
    const auto* content = file->content();
    const std::string name = file->name()->str();
    const auto survey = read(std::string(content->begin(), content->end()), name);
    for (const auto& skipped : survey.skipped) {
      const std::string text =
          survey::place(skipped.source) + ": found " + skipped.found + ", expected " + skipped.expected;
      if (*strict) throw std::runtime_error(text + "; strict=false reads the rest");
      context.warn(text);
    }
    observations.commit(survey::to_artifact(survey));
  }
};

}  // namespace

PLUMBLINE_PLUGIN("@name@", "0.1.0", "MIT", Reader)
