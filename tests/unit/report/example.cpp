#include "example.hpp"

#include <cmath>

#include "../bim/facing.hpp"
#include "building/judgement/accuracy.hpp"
#include "building/judgement/deviation.hpp"

namespace plumbline::report::test {

namespace {

constexpr double mm = 1e-3;

/// Splitmix64 and Box-Muller: the same numbers on every machine.
class Normal {
 public:
  explicit Normal(std::uint64_t seed) : state_(seed) {}
  double operator()() { return std::sqrt(-2 * std::log(uniform())) * std::cos(2 * M_PI * uniform()); }

 private:
  double uniform() {
    std::uint64_t z = (state_ += 0x9e3779b97f4a7c15u);
    z = (z ^ (z >> 30)) * 0xbf58476d1ce4e5b9u;
    z = (z ^ (z >> 27)) * 0x94d049bb133111ebu;
    return (static_cast<double>((z ^ (z >> 31)) >> 11) + 0.5) * 0x1p-53;
  }
  std::uint64_t state_;
};

std::string id_of(int floor, int column, int row) {
  return "F0" + std::to_string(floor) + "-C0" + std::to_string(column) + "-R" + std::to_string(row);
}

judgement::Inputs campaign(int floors, judgement::PointSet& designed) {
  judgement::Inputs inputs;
  inputs.truth.emplace();
  Normal normal(4);
  const auto noise = [&](double sigma) {
    return Eigen::Vector3d(sigma * normal(), sigma * normal(), sigma * normal());
  };
  for (int floor = 1, i = 0; floor <= floors; ++floor)
    for (int row = 1; row <= 2; ++row)
      for (int column = 1; column <= 4; ++column, ++i) {
        const std::string id = id_of(floor, column, row);
        const Eigen::Vector3d design(2.0 * column, 0, 3.0 * floor - 2.5 + 2.0 * (row - 1));
        const bool check = (column + row) % 3 == 0;
        const Eigen::Vector3d truth = design + noise(3 * mm);
        inputs.anchors.push_back({id, floor, column, row, check ? AnchorUse::check : AnchorUse::control});
        const auto add = [&](judgement::PointSet& set, const Eigen::Vector3d& p) {
          set.ids.push_back(id);
          set.positions.push_back(p);
        };
        add(designed, design);
        add(*inputs.truth, truth);
        add(inputs.survey, truth + noise(0.7 * mm));
        const double blunder = i == 18 ? 7 * mm : i == 9 ? 3.6 * mm : 0;
        if (i != 24) add(inputs.model, truth + noise(0.4 * mm) + Eigen::Vector3d(0, 0, 0.25 * mm * floor + blunder));
      }
  const auto isotropic = [](std::size_t n, double sigma) -> Eigen::MatrixXd {
    return sigma * sigma *
           Eigen::MatrixXd::Identity(static_cast<Eigen::Index>(3 * n), static_cast<Eigen::Index>(3 * n));
  };
  inputs.model.covariance = isotropic(inputs.model.ids.size(), 0.4 * mm);
  inputs.survey.covariance = isotropic(inputs.survey.ids.size(), 0.7 * mm);
  return inputs;
}

/// The same anchors against their design, with a panel between every four.
DeviationT built(const judgement::Inputs& inputs, const judgement::PointSet& designed) {
  judgement::DeviationInputs cases;
  cases.model = inputs.model, cases.design_file = "tower.ifc";
  for (std::size_t i = 0; i < inputs.anchors.size(); ++i) {
    judgement::AnchorCase anchor;
    anchor.id = inputs.anchors[i].id, anchor.floor = inputs.anchors[i].floor, anchor.column = inputs.anchors[i].column;
    anchor.use = inputs.anchors[i].use == AnchorUse::check ? "check" : "control";
    anchor.element.guid = "guid of " + anchor.id, anchor.element.ifc_class = "IfcMechanicalFastener";
    anchor.found_by = "name", anchor.reference_point_rule = "placement", anchor.instance = i + 1;
    anchor.storey_guid = "storey" + std::to_string(anchor.floor),
    anchor.element.storey = "Level " + std::to_string(anchor.floor);
    anchor.design = designed.positions[i], anchor.tolerances = judgement::tolerances_of({}, {});
    cases.anchors.push_back(anchor);
  }
  for (std::size_t i = 0; i + 5 < inputs.anchors.size(); i += 8)  // eight anchors a floor in two rows
    for (std::size_t column = 0; column < 3; ++column) {
      judgement::PanelCase panel;
      panel.guid = "panel" + std::to_string(i + column), panel.name = "P" + std::to_string(cases.panels.size() + 1);
      panel.anchors = {i + column, i + column + 1, i + column + 4, i + column + 5};
      panel.low = designed.positions[i + column] + Eigen::Vector3d(0.01, -0.1, 0);
      panel.high = designed.positions[i + column + 5] + Eigen::Vector3d(-0.01, 0, 0);
      panel.tolerances = judgement::tolerances_of({}, {});
      cases.panels.push_back(panel);
    }
  plumbline::test::face(cases, {0, -1, 0});
  return judgement::judge_deviations(cases, {});
}

NetworkPage network(const judgement::Inputs& inputs) {
  NetworkPage page;
  Normal normal(5);
  for (std::size_t i = 0; i < inputs.survey.ids.size(); ++i) {
    const double height = inputs.survey.positions[i].z();
    Eigen::Matrix3d s = Eigen::Vector3d(0.5, 0.9, 0.4 + 0.03 * height).cwiseAbs2().asDiagonal();
    s(0, 1) = s(1, 0) = 0.2;
    page.points.push_back({inputs.survey.ids[i], inputs.survey.positions[i], s * mm * mm, false, height < 3});
  }
  for (int i = 0; i < 4; ++i)
    page.points.push_back({"S" + std::to_string(i + 1),
                           {1.0 + 3 * i, -9.0 - i % 2, 1.6},
                           0.3 * mm * mm * Eigen::Matrix3d::Identity(),
                           true,
                           false});
  const char* kinds[] = {"direction", "zenith_angle", "slope_distance"};
  for (int station = 0; station < 4; ++station)
    for (std::size_t i = 0; i < inputs.survey.ids.size(); ++i)
      for (int kind = 0; kind < 3; ++kind) {
        NetworkPage::Observation o;
        o.kind = kinds[kind], o.angular = kind < 2;
        o.from = "S" + std::to_string(station + 1), o.to = inputs.survey.ids[i];
        o.sigma = kind < 2 ? 2.4e-5 : 2 * mm;
        o.redundancy_number = 0.05 + 0.11 * static_cast<double>((i + static_cast<std::size_t>(kind)) % 8);
        o.w = normal();
        o.residual = o.w * o.sigma * std::sqrt(o.redundancy_number);
        o.mdb = 4.13 * o.sigma / std::sqrt(o.redundancy_number);
        o.external_effect = 1.3 * mm;
        o.source = "station" + std::to_string(station + 1) + ".gsi:" + std::to_string(12 + 3 * i);
        page.observations.push_back(o);
      }
  auto& bad = page.observations[77];
  bad.w = 9.2, bad.removed = bad.flagged = true, bad.estimated_blunder = 31 * mm, bad.angular = false,
  bad.kind = "slope_distance";
  page.steps.push_back({77, "removed", 9.2, 31 * mm});
  page.groups = {
      {"direction", 1.04, 110.2, 160}, {"zenith_angle", 0.97, 121.9, 160}, {"slope_distance", 1.01, 100.0, 160}};
  page.findings.push_back({"note", "Points F05-C01-R1 and F05-C02-R1 are seen from two set-ups only."});
  page.datum = "weighted";
  page.sigma0 = 1.012, page.degrees_of_freedom = 348, page.unknowns = 132;
  page.statistic = 356.4, page.lower = 298.1, page.upper = 401.6, page.alpha = 0.05, page.verdict = "pass";
  page.critical_w = 3.29, page.alpha0 = 0.001, page.power = 0.8;
  return page;
}

}  // namespace

ReportInput example(int floors) {
  judgement::PointSet designed;
  const judgement::Inputs inputs = campaign(floors, designed);
  ReportInput report;
  report.title = "Facade anchors, full height";
  report.subtitle = "Example building, south facade, 5 floors. Campaign of 12 May 2025";
  report.accuracy = judgement::evaluate_accuracy(inputs, {});
  report.deviation = built(inputs, designed);
  report.network = network(inputs);
  report.provenance = {
      {"Pipeline", "full_height"}, {"Plumbline", "0.1.0"}, {"Seed", "1"}, {"Design", "tower.ifc (IFC4)"}};
  report.files = {
      {"campaign.yaml", "9f86d081884c7d659a2feaa0c55ad015a3bf4f1b2b0b822cd15d6c15b0f00a08", 1250, ""},
      {"survey/station1.gsi", "60303ae22b998861bce3b28f33eec1be758a213c86c93c076dbe9f558c11c752", 48213, ""}};
  return report;
}

}  // namespace plumbline::report::test
