// Whole pages of small inputs, element by element: every number of a drawing, every word and their order
// (pages/NAME.txt). What is on them is recomputed in the other tests; here it is held.
#include <gtest/gtest.h>

#include <cmath>
#include <nlohmann/json.hpp>

#include "example.hpp"
#include "geometry/packed_symmetric.hpp"
#include "record.hpp"
#include "show/report/image_block_page.hpp"
#include "show/report/network_page.hpp"
#include "show/report/report.hpp"
#include "show/report/sections.hpp"
#include "show/report/sheets_page.hpp"
#include "show/report/surface_page.hpp"

namespace plumbline::report {
namespace test_golden_pages {

void expect_page(const std::string& name, const std::string& html) {
  plumbline::test::expect_recorded("unit/report/pages/" + name + ".txt", plumbline::test::elements_of(html));
}

TEST(GoldenPages, BuildingOfTwoFloors) {
  ReportInput input = test::example(2);
  input.grid = {{"A", "u", {0, 0, 0}, {1, 0, 0}}, {"1", "v", {2, -5, 0}, {0, 1, 0}}};
  AsBuiltChangesT changes;
  changes.compared = true, changes.before = "2026-05", changes.measured_twice = 3;
  for (const ChangeKind kind : {ChangeKind::mended, ChangeKind::opened_again, ChangeKind::unseen}) {
    auto change = std::make_unique<AsBuiltChangeT>();
    change->kind = "anchor", change->id = "F01-C01-R1", change->floor = 1, change->before = ToleranceVerdict::fail;
    change->after = ToleranceVerdict::pass, change->change = kind, change->moved = kind == ChangeKind::mended;
    change->movement = {0.004, -0.0012, 0}, change->u = 0.0005;
    changes.changes.push_back(std::move(change));
  }
  input.changes = std::move(changes);
  expect_page("building", render_report(input));
}

TEST(GoldenPages, SheetsOfAFloor) {
  ReportInput input = test::example(1);
  input.grid = {{"A", "u", {0, 0, 0}, {1, 0, 0}}, {"1", "v", {2, -5, 0}, {0, 1, 0}}};
  // Of one of them nobody knows which way is right.
  for (const auto& anchor : input.deviation->anchors)
    if (anchor->id == "F01-C02-R1" && anchor->facade) anchor->facade->confirmed = false;
  expect_page("sheets", render_sheets(input));
}

TEST(GoldenPages, Network) {
  SurveyNetworkT network;
  const auto add = [&](const std::string& id, const Eigen::Vector3d& position, double sigma) {
    auto point = std::make_unique<PointT>();
    point->id = id, point->position = position, point->sigma = {sigma, 2 * sigma, 3 * sigma};
    network.points.push_back(std::move(point));
    auto ellipsoid = std::make_unique<NetworkEllipsoidT>();
    ellipsoid->id = id, ellipsoid->semi_axes = {5 * sigma, 2 * sigma, sigma};
    ellipsoid->first_axis = {0.6, 0.8, 0}, ellipsoid->second_axis = {0, 0, 1};
    network.ellipsoids.push_back(std::move(ellipsoid));
  };
  add("A1", {1, 2, 3}, 0.001), add("A2", {9, 14, 6}, 0.0015), add("A3", {1.02, 2.03, 9}, 0.002);
  add("S1", {4, -5, 0}, 0.001), add("S2", {-3, -6, 0.5}, 0.001);
  for (const char* station : {"S1", "S2"}) {
    auto set_up = std::make_unique<NetworkSetUpT>();
    set_up->id = set_up->station = station, set_up->orientation = station[1] - 48.5, set_up->instrument_height = 1.603;
    set_up->constant = 0.0344, set_up->constant_sigma = 0.0004;
    network.set_ups.push_back(std::move(set_up));
    int line = 7;
    for (const char* to : {"A1", "A2", "A3"})
      for (const char* kind : {"direction", "zenith_angle", "slope_distance"}) {
        auto o = std::make_unique<NetworkObservationT>();
        o->kind = kind, o->from = station, o->to = to, o->file = "a.gsi", o->line = line++;
        o->value = 1.25 + 0.01 * line, o->residual = 1e-5 * (line % 5 - 2), o->sigma = 2e-5;
        o->redundancy_number = 0.1 * (line % 9), o->w = line % 5 - 2.0, o->flagged = line == 9;
        network.observations.push_back(std::move(o));
      }
  }
  network.datum = "weighted", network.datum_points = {"A1", "A2"};
  PointsT points;
  for (const auto& p : network.points) points.points.push_back(std::make_unique<PointT>(*p));
  Eigen::MatrixXd covariance = Eigen::MatrixXd::Identity(15, 15) * 9e-6;
  covariance(2, 8) = covariance(8, 2) = 4.5e-6, covariance(0, 3) = covariance(3, 0) = -2e-6;
  points.covariance = pack_symmetric(covariance);
  expect_page("network",
              render_page("t", [&](Markup& html) { write_network(html, network_page(network, nullptr, &points)); }));
}

TEST(GoldenPages, ImageBlock) {
  const auto block = nlohmann::ordered_json::parse(R"({
    "statistics": {"rms_px": 0.25}, "datum": "control",
    "cameras": [{"id": "c", "source": "camera.yaml", "width": 100, "height": 80, "images": 2, "rms_px": 0.25, "pixel_pitch_um": 4.0}],
    "images": [
      {"path": "1.jpg", "oriented": true, "camera": "c", "centre": [0, 0, 5], "sigma": [0.001, 0.001, 0.001],
       "rotation": [0, 1, 0, 0], "tags": 3, "rms_px": 0.25, "coverage": 0.5},
      {"path": "2.jpg", "oriented": true, "camera": "c", "centre": [2, 0.5, 4], "sigma": [0.001, 0.002, 0.003],
       "rotation": [0.1, 0.99, 0, 0.0995], "tags": 2, "rms_px": 0.2, "coverage": 0.25}],
    "points": [
      {"id": "P1", "role": "check", "position": [0, 0, 0], "sigma": [0.001, 0.002, 0.003], "surveyed": [0, 0, 0],
       "surveyed_sigma": [0.002, 0.002, 0.002], "difference": [0.003, -0.004, 0], "w": [0, 0, 0], "rays": 2, "largest_angle_deg": 41},
      {"id": "P2", "role": "control", "position": [1, 0.3, 0], "sigma": [0.001, 0.001, 0.001], "surveyed": [1, 0, 0],
       "difference": [0, 0, 0.001], "w": [0.5, -3.6, 0], "rays": 2, "largest_angle_deg": 12},
      {"id": "P3", "position": [0, 1, 0.2], "sigma": [0.001, 0.001, 0.001], "rays": 2, "largest_angle_deg": 5}],
    "observations": [
      {"image": "1.jpg", "point": "P1", "corners": [[10, 20]], "residuals": [[0.1, 0.2]], "rms_px": 0.16},
      {"image": "1.jpg", "point": "P2", "corners": [[70, 30]], "residuals": [[-0.3, 0.1]], "rms_px": 0.22},
      {"image": "2.jpg", "point": "P2", "corners": [[35, 60]], "residuals": [[0.2, -0.4]], "rms_px": 0.3}],
    "rejected": [{"image": "2.jpg", "point": "P3", "corners": [[1, 1]], "reason": "it disagrees"}]})");
  Markup m;
  write_image_block(m, block, "Title", "", {});
  expect_page("image_block", m.str());
}

TEST(GoldenPages, Surfaces) {
  SurfacesT surfaces;
  for (const double u : {0.0, 1.02}) {
    auto panel = std::make_unique<PanelSurfaceFiguresT>();
    panel->face = std::make_unique<SurfaceFaceT>();
    SurfaceFaceT& face = *panel->face;
    face.id = u > 0 ? "A2" : "A1", face.out = {0, -1, 0}, face.up = {0, 0, 1}, face.right = {1, 0, 0};
    face.origin = u * face.right, face.width = 1, face.height = 2;
    panel->offset = 0.004, panel->coefficients = {0.004, 0.001, -0.002, 0.0015, 0, -0.0005};
    surfaces.panels.push_back(std::move(panel));
  }
  surfaces.panels[1]->coefficients[0] = -0.003;
  auto joint = std::make_unique<JointFiguresT>();
  joint->first = "A1", joint->second = "A2", joint->nominal_width = 0.012, joint->looked_at = 9, joint->upright = true;
  for (const double width : {0.0101, 0.0132, 0.0117}) {
    joint->places.push_back(std::make_unique<JointPlaceT>());
    joint->places.back()->width = width, joint->places.back()->width_sigma = 2e-4;
    joint->places.back()->along = 10 * width, joint->places.back()->step = 0.1 * width;
  }
  joint->narrowest = 0, joint->widest = 1, joint->largest_step = 2;
  surfaces.joints.push_back(std::move(joint));
  expect_page("surfaces", render_surface_page(surfaces, nullptr, "Surfaces"));
}

TEST(GoldenPages, Epochs) {
  SurveyComparisonT c;
  int number = 0;
  for (const char* id : {"A", "B", "M12"}) {
    auto p = std::make_unique<PointMovementT>();
    const bool moved = id[0] == 'M';
    ++number;
    p->id = id, p->position = {1.0 * number, 2.0 * number * number, 3}, p->movement = {1e-4, -2e-4, moved ? -0.002 : 0};
    p->sigma = {0.0005, 0.0004, 0.0003}, p->statistic = 12, p->moved = moved, p->stable = !moved;
    p->detectable_height = 0.002, p->ellipsoid = std::make_unique<NetworkEllipsoidT>();
    p->ellipsoid->id = id, p->ellipsoid->semi_axes = {0.0006, 0.0005, 0.0004};
    p->ellipsoid->first_axis = {0.6, 0.8, 0}, p->ellipsoid->second_axis = {-0.8, 0.6, 0};
    c.points.push_back(std::move(p));
  }
  c.statistic = 88.8, c.critical = 11.1, c.rank = 5, c.alpha = 0.05, c.alpha0 = 0.001, c.power = 0.8;
  c.critical_point = 16.3, c.free_motions = 4;
  auto e = std::make_unique<PointExclusionT>();
  e->id = "M12", e->statistic = 1.5, e->critical = 6, e->alternatives = {"A"};
  c.excluded.push_back(std::move(e));
  expect_page("epochs", render_page("t", [&](Markup& html) { write_epochs(html, c); }));
}

}  // namespace test_golden_pages
}  // namespace plumbline::report
