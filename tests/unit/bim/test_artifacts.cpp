// Between artifacts and plain structs nothing is lost or mixed up.
#include <gtest/gtest.h>

#include "artifacts.hpp"
#include "ifc/step.hpp"
#include "small_building.hpp"

namespace plumbline::bim {
namespace {

PointsT two_points() {
  PointsT points;
  for (const char* id : {"A", "B"}) {
    auto point = std::make_unique<PointT>();
    point->id = id;
    point->position = Eigen::Vector3d(1, 2, id[0]);
    point->sigma = Eigen::Vector3d(1e-3, 2e-3, 3e-3);
    points.points.push_back(std::move(point));
  }
  return points;
}

AccuracyT accuracy_of(std::initializer_list<const char*> ids) {
  AccuracyT accuracy;
  accuracy.tau = 0.004;
  accuracy.guard_factor = 1.6;
  for (const char* id : ids) {
    auto anchor = std::make_unique<AnchorAccuracyT>();
    anchor->id = id;
    anchor->floor = 1;
    anchor->use = id[0] == 'A' ? AnchorUse::control : AnchorUse::check;
    anchor->survey = std::make_unique<AnchorDifferenceT>();
    anchor->survey->dz = id[0] == 'A' ? 0.001 : -0.003;
    anchor->survey->verdict = ToleranceVerdict::fail;
    accuracy.anchors.push_back(std::move(anchor));
  }
  for (const AnchorUse use : {AnchorUse::control, AnchorUse::check}) {
    auto comparison = std::make_unique<AccuracyComparisonT>();
    comparison->use = use;
    comparison->reference = AccuracyReference::survey;
    comparison->evidence = use == AnchorUse::check;
    comparison->anchors = 1;
    auto floor = std::make_unique<FloorAccuracyT>();
    floor->floor = 1;
    floor->anchors = 1;
    floor->mean_dz = use == AnchorUse::check ? -0.003 : 0.001;
    comparison->floors.push_back(std::move(floor));
    for (const double tolerance : {0.002, 0.004}) {
      comparison->pass_rates.push_back(std::make_unique<PassRateT>());
      comparison->pass_rates.back()->tolerance = tolerance;
    }
    for (const int column : {0, 1}) {
      auto transfer = std::make_unique<HeightTransferT>();
      transfer->lower_floor = 1;
      transfer->upper_floor = 2;
      transfer->column = column;
      transfer->error = 0.002;
      transfer->difference = -0.002 - 0.001 * column;
      comparison->transfers.push_back(std::move(transfer));
    }
    auto drift = std::make_unique<ColumnDriftT>();
    drift->column = 1, drift->lowest_floor = 1, drift->highest_floor = 2;
    drift->relative_drift = -0.003, drift->relative_verdict = ToleranceVerdict::pass;
    comparison->columns.push_back(std::move(drift));
    accuracy.comparisons.push_back(std::move(comparison));
  }
  return accuracy;
}

TEST(BimArtifacts, DesignsSurviveTheRoundTrip) {
  const step::File file(test::small_building("IFC4"), "small.ifc");
  Design design = read_design(file, {});
  design.warnings = {"w"};
  design.map_conversion = MapConversion{1, 2, 3, 0.5, 0.25, 0.001, true, "EPSG:1"};
  design.elements[0].item_positions = {{1, 2, 3}};
  design.elements[0].anchor_guids = {"g"};
  flatbuffers::FlatBufferBuilder builder;
  const DesignT artifact = to_artifact(design);
  builder.Finish(plumbline::Design::Pack(builder, &artifact));
  DesignT unpacked;
  flatbuffers::GetRoot<plumbline::Design>(builder.GetBufferPointer())->UnPackTo(&unpacked);
  const Design back = from_artifact(unpacked);
  ASSERT_EQ(back.elements.size(), design.elements.size());
  for (std::size_t i = 0; i < design.elements.size(); ++i) {
    const Element &a = design.elements[i], &b = back.elements[i];
    EXPECT_EQ(std::tie(a.guid, a.name, a.tag, a.object_type, a.ifc_class, a.storey, a.storey_guid, a.parent_guid,
                       a.instance, a.anchor_guids),
              std::tie(b.guid, b.name, b.tag, b.object_type, b.ifc_class, b.storey, b.storey_guid, b.parent_guid,
                       b.instance, b.anchor_guids));
    EXPECT_EQ(std::tie(a.rule, a.is_anchor, a.is_panel, a.has_box),
              std::tie(b.rule, b.is_anchor, b.is_panel, b.has_box));
    EXPECT_EQ(a.position, b.position);
    EXPECT_EQ(a.box_high, b.box_high);
    EXPECT_EQ(a.item_positions, b.item_positions);
    EXPECT_EQ(a.project_from_element.rotation.coeffs(), b.project_from_element.rotation.coeffs());
  }
  EXPECT_EQ(back.storeys[1].name, "Level 2");
  EXPECT_EQ(artifact.storeys[1]->floor, 2);
  EXPECT_EQ(back.map_conversion->crs_name, "EPSG:1");
  EXPECT_EQ(back.map_conversion->scale, 0.001);
}

TEST(BimArtifacts, AnchorPointsAreNamedUniquely) {
  const step::File file(test::small_building("IFC4"), "small.ifc");
  Design design = read_design(file, {});
  EXPECT_EQ(anchor_points(design).points[0]->id, "F1-C1");
  for (Element& element : design.elements)
    if (element.is_anchor) element.name = "bolt";
  EXPECT_EQ(anchor_points(design).points[0]->id, "11vctVUKr0kugbFTf53O9L");
}

TEST(BimArtifacts, CovarianceBlocksComeFromTheirRows) {
  PointsT points = two_points();
  EXPECT_NEAR(as_built_from(points, accuracy_of({"B"})).anchors[0].covariance(1, 1), 4e-6, 1e-18);
  for (int i = 0; i < 21; ++i) points.covariance.push_back(i);
  const Eigen::Matrix3d block = as_built_from(points, accuracy_of({"B"})).anchors[0].covariance;
  Eigen::Matrix3d expected;  // rows 3 to 5, columns 3 to 5 of the packed triangle: 9, then 13 14, then 18 19 20
  expected << 9, 13, 18, 13, 14, 19, 18, 19, 20;
  EXPECT_EQ(block, expected);
  points.covariance.pop_back();
  EXPECT_THROW(as_built_from(points, accuracy_of({"B"})), std::runtime_error);
}

TEST(BimArtifacts, FloorsComeFromCheckAnchorsIfThereAreAny) {
  AccuracyT accuracy = accuracy_of({"A", "B", "C"});
  const AsBuilt as_built = as_built_from(two_points(), accuracy);
  ASSERT_EQ(as_built.anchors.size(), 3u);
  EXPECT_EQ(as_built.anchors[0].role, "control");
  EXPECT_EQ(as_built.anchors[1].survey->verdict, Verdict::fail);
  EXPECT_FALSE(as_built.anchors[2].position.allFinite());  // the model has no C
  EXPECT_EQ(as_built.tolerance_z, 0.004);
  ASSERT_EQ(as_built.floors.size(), 1u);
  EXPECT_EQ(as_built.floors[0].anchors_used, "check");
  EXPECT_EQ(as_built.floors[0].mean_dz, -0.003);
  // B and C are off by 3 mm
  EXPECT_EQ(as_built.floors[0].pass_rates, (std::vector<std::pair<double, double>>{{0.002, 0}, {0.004, 1}}));
  ASSERT_EQ(as_built.transfers.size(), 1u);  // of the floor means; the columns stand with it
  EXPECT_EQ(as_built.transfers[0].difference, -0.002);
  EXPECT_EQ(as_built.transfers[0].columns, (std::vector<std::pair<int, double>>{{1, -0.003}}));
  ASSERT_EQ(as_built.columns.size(), 1u);
  EXPECT_EQ(as_built.columns[0].anchors_used, "check");
  EXPECT_EQ(as_built.columns[0].highest_floor, 2);
  EXPECT_EQ(as_built.columns[0].relative_verdict, Verdict::pass);
  accuracy.comparisons[1]->anchors = 0;
  EXPECT_EQ(as_built_from(two_points(), accuracy).floors[0].anchors_used, "control");
}

}  // namespace
}  // namespace plumbline::bim
