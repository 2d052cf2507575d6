// What an artifact must keep is checked where it leaves a node.
#include <gtest/gtest.h>

#include <cmath>

#include "artifacts/camera.hpp"
#include "artifacts/folder.hpp"
#include "artifacts/points.hpp"
#include "artifacts/poses.hpp"
#include "artifacts/survey_observations.hpp"
#include "runtime/plugins/artifact_rules.hpp"
#include "runtime/plugins/artifact_type.hpp"

namespace plumbline::test {
namespace test_rules {

template <typename Table>
flatbuffers::FlatBufferBuilder packed(const typename artifact_traits<Table>::Native& native) {
  flatbuffers::FlatBufferBuilder builder;
  builder.Finish(Table::Pack(builder, &native, nullptr));
  return builder;
}
template <typename Table>
std::string broken(const typename artifact_traits<Table>::Native& native) {
  const auto builder = packed<Table>(native);
  const plumbline_bytes bytes{builder.GetBufferPointer(), builder.GetSize()};
  const std::string problem = runtime::verify_artifact(artifact_traits<Table>::type(), bytes);
  return problem.empty() ? runtime::broken_rule(artifact_traits<Table>::type(), bytes) : problem;
}

PointsT three() {
  PointsT points;
  for (const char* id : {"A", "B", "C"}) {
    auto point = std::make_unique<PointT>();
    point->id = id, point->position = {1, 2, 3}, point->sigma.setConstant(0.001);
    points.points.push_back(std::move(point));
  }
  return points;
}

TEST(ArtifactRules, SoundPointsPassWhateverIsUnknown) {
  PointsT points = three();
  EXPECT_EQ(broken<Points>(points), "");
  points.covariance.assign(45, 0.0);
  points.points[0]->position.x() = std::nan("");
  points.points[1]->sigma.setConstant(std::nan(""));
  EXPECT_EQ(broken<Points>(points), "");
  EXPECT_EQ(broken<Points>(PointsT()), "");
}

/// A node made covariances of nothing of it, without a word.
TEST(ArtifactRules, OfALongListTheFirstThatIsUnknownIsNamed) {
  CameraT camera;
  camera.parameters.assign(9, 1), camera.covariance.assign(45, 0);
  EXPECT_EQ(broken<Camera>(camera), "");
  camera.covariance[3] = std::nan("");
  EXPECT_EQ(broken<Camera>(camera), "covariance holds nan as number 4 of 45, expected numbers only");
  camera.covariance[3] = 0, camera.parameters[8] = std::nan("");
  EXPECT_EQ(broken<Camera>(camera), "parameters holds [1, 1, 1, 1, 1, 1, 1, 1, nan], expected numbers only");
}

TEST(ArtifactRules, TheFirstThatIsBrokenIsNamedWithItsPlace) {
  PointsT points = three();
  points.points[2]->sigma.y() = -0.001;
  EXPECT_EQ(broken<Points>(points), "points[2] 'C': sigma holds [0.001, -0.001, 0.001], expected no negative number");
  points = three();
  points.points[1]->position.setConstant(std::nan(""));
  EXPECT_EQ(broken<Points>(points),
            "points[1] 'B': position holds [nan, nan, nan], expected at least one known component");
  points = three();
  points.points[1]->position.z() = INFINITY;
  EXPECT_EQ(broken<Points>(points), "points[1] 'B': position holds [1, 2, inf], expected no infinity");
  points = three();
  points.points[1]->id = "A";
  EXPECT_EQ(broken<Points>(points), "points[1] 'A': id holds 'A' a second time, expected each once");
  points = three();
  points.points[1]->id = "";
  EXPECT_EQ(broken<Points>(points), "points[1] '': id holds '', expected a name");
  points = three();
  points.covariance.assign(5, 0.0);
  EXPECT_EQ(broken<Points>(points),
            "covariance holds 5 values, expected none, or the 45 of the lower triangle of 9 rows");
}

/// Nobody noticed, or the node behind was blamed: "the covariances are singular in a direction".
TEST(ArtifactRules, ACovarianceIsOne) {
  PointsT points = three();
  const auto variance = [](size_t row) { return row * (row + 3) / 2; };
  points.covariance.assign(45, 0.0);
  for (size_t row = 0; row < 9; ++row) points.covariance[variance(row)] = 1e-6;
  EXPECT_EQ(broken<Points>(points), "");
  const std::vector<double> sound = points.covariance;
  for (size_t row = 0; row < 9; ++row) points.covariance[variance(row)] = -1e-6;
  EXPECT_EQ(broken<Points>(points),
            "covariance holds a variance of -1e-06 in row 1 (points[0] 'A'), expected none below zero, and none "
            "infinite");
  points.covariance = sound;
  points.covariance[variance(4) - 1] = 5e-6;
  EXPECT_EQ(broken<Points>(points),
            "covariance holds a covariance of 5e-06 between row 4 (points[1] 'B') and row 5 (points[1] 'B'), expected "
            "no correlation beyond 1, so at most 1e-06");
  points.covariance[variance(4) - 1] = 1e-6;
  points.covariance[variance(8)] = -1e-24;
  EXPECT_EQ(broken<Points>(points), "") << "the noise of an inverse";
  points.covariance = sound;
  points.covariance[variance(8)] = std::nan("");
  EXPECT_EQ(broken<Points>(points),
            "covariance holds a variance of nan in row 9 (points[2] 'C'), expected a number, as for all that is known");
  points.points[2]->sigma.z() = std::nan("");
  EXPECT_EQ(broken<Points>(points), "") << "nobody knows it";
  points.points[2]->sigma.z() = 0.001, points.points[2]->position.z() = std::nan("");
  EXPECT_EQ(broken<Points>(points), "") << "it has none";
  points.covariance[1] = std::nan("");
  EXPECT_TRUE(broken<Points>(points).starts_with(
      "covariance holds a covariance of nan between row 1 (points[0] 'A') and row 2 (points[0] 'A')"))
      << broken<Points>(points);
}

/// survey.adjust was blamed for a reading without a value, and nobody for what stands twice.
TEST(ArtifactRules, AReadingHasAValueAndASetUpStandsOnce) {
  SurveyObservationsT survey;
  survey.info = std::make_unique<SurveyInfoT>();
  for (const char* id : {"S1", "S2"}) {
    survey.set_ups.push_back(std::make_unique<SurveySetUpT>());
    survey.set_ups.back()->id = id, survey.set_ups.back()->station = "P";
  }
  for (const char* to : {"Q", "R"}) {
    survey.observations.push_back(std::make_unique<SurveyObservationT>());
    survey.observations.back()->from = "P", survey.observations.back()->to = to;
  }
  EXPECT_EQ(broken<SurveyObservations>(survey), "") << "planned";
  survey.observations[1]->value = 1;
  EXPECT_EQ(broken<SurveyObservations>(survey),
            "observations[0]: value holds nan, expected a number, as others of its list have");
  survey.observations[0]->value = INFINITY;
  EXPECT_EQ(broken<SurveyObservations>(survey), "observations[0]: value holds inf, expected no infinity");
  survey.observations[0]->value = 1, survey.set_ups[1]->id = "S1";
  EXPECT_EQ(broken<SurveyObservations>(survey), "set_ups[1] 'S1': id holds 'S1' a second time, expected each once");
}

TEST(ArtifactRules, ARotationIsOne) {
  PosesT poses;
  poses.poses.push_back(std::make_unique<PoseT>());
  poses.poses[0]->path = "a.jpg";
  poses.poses[0]->cam_from_world = {Eigen::Quaterniond::Identity(), Eigen::Vector3d(1, 2, 3)};
  EXPECT_EQ(broken<Poses>(poses), "");
  poses.poses[0]->cam_from_world.rotation.coeffs() *= 2;
  EXPECT_EQ(broken<Poses>(poses),
            "poses[0] 'a.jpg': cam_from_world holds [2, 0, 0, 0], expected a rotation as a unit quaternion");
  poses.poses[0]->cam_from_world = {Eigen::Quaterniond::Identity(), Eigen::Vector3d(1, std::nan(""), 3)};
  EXPECT_EQ(broken<Poses>(poses),
            "poses[0] 'a.jpg': cam_from_world holds [1, 0, 0, 0, 1, nan, 3], expected numbers only");
}

TEST(ArtifactRules, AMissingFieldIsNamedByTableAndField) {
  flatbuffers::FlatBufferBuilder builder;
  const auto id = builder.CreateString("a.jpg");
  FolderEntryBuilder entry(builder);
  entry.add_path(id);
  const flatbuffers::Offset<FolderEntry> made(builder.EndTable(entry.start_));  // Finish() would ask for sha256
  const auto files = builder.CreateVector(&made, 1);
  const auto uri = builder.CreateString("x");
  FolderBuilder folder(builder);
  folder.add_uri(uri);
  folder.add_files(files);
  builder.Finish(folder.Finish());
  const auto& type = artifact_traits<Folder>::type();
  EXPECT_EQ(runtime::verify_artifact(type, {builder.GetBufferPointer(), builder.GetSize()}),
            "plumbline.FolderEntry needs 'sha256' (files[0])");
  std::string cut(reinterpret_cast<const char*>(builder.GetBufferPointer()), builder.GetSize() / 2);
  EXPECT_EQ(runtime::verify_artifact(type, {cut.data(), cut.size()}), "is not a well-formed plumbline.Folder/1");
}

TEST(ArtifactRules, AnObjectThatLacksOneIsWrittenAndRefused) {
  // FolderT::files of a null entry: what an author forgot must not end in a sentence about FlatBuffers.
  FolderEntryT entry;
  entry.path = "a";
  FolderT folder;
  folder.uri = "x";
  folder.files.push_back(std::make_unique<FolderEntryT>(entry));
  EXPECT_EQ(broken<Folder>(folder), "") << "texts that are left out are empty ones";
}

}  // namespace test_rules
}  // namespace plumbline::test
