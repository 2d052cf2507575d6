// What every writer of survey files must do: what it wrote is read back as it was.
#include <cmath>
#include <filesystem>

#include "artifacts/file.hpp"
#include "artifacts/survey_artifact.hpp"
#include "artifacts/survey_observations.hpp"
#include "kit_fixtures.hpp"
#include "node_harness.hpp"
#include "parameter_effects.hpp"
#include "survey/files/survey_format.hpp"

namespace survey_writer_tests {

using namespace plumbline;
using namespace plumbline::test;
namespace fs = std::filesystem;

SurveyObservationsT read_back(const std::string& name, const std::string& bytes) {
  return survey::to_artifact(survey::read_survey(bytes, name));
}

class SurveyWriter : public testing::TestWithParam<std::string> {};

TEST_P(SurveyWriter, WritesWhatReadSurveyReadsBack) {
  const auto expected = read_back("source.gsi", read_file(fs::path(kit_fixtures()) / "code_block_cr_only.gsi"));
  NodeHarness writer(GetParam());
  writer.input<SurveyObservations>("observations", expected);
  writer.run();
  const FileT written = writer.output<File>("file");
  EXPECT_FALSE(written.media_type.empty());
  const auto found = read_back(written.name, std::string(written.content.begin(), written.content.end()));
  ASSERT_EQ(found.observations.size(), expected.observations.size());
  ASSERT_EQ(found.set_ups.size(), expected.set_ups.size());
  // gama XML has the height at each observation.
  const double own = found.observations[0]->instrument_height;
  EXPECT_NEAR(std::isnan(own) ? found.set_ups[0]->instrument_height : own, expected.set_ups[0]->instrument_height,
              1e-9);
}

TEST_P(SurveyWriter, EveryDeclaredParameterHasItsEffect) {
  const auto written = [this](const char* fixture) -> Situation {
    return [survey = read_back("source.gsi", read_file(fs::path(kit_fixtures()) / fixture))] {
      NodeHarness writer(GetParam());
      writer.input<SurveyObservations>("observations", survey);
      return writer;
    };
  };
  EXPECT_EQ(parameters_at_fault({written("code_block_cr_only.gsi"), written("station_coordinates.gsi")}), "");
}

INSTANTIATE_TEST_SUITE_P(All, SurveyWriter, testing::ValuesIn(kinds_of_role("survey_writer")), test_name);

}  // namespace survey_writer_tests
