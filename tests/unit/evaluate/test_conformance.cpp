// Conformance probability against integrals worked out by other means, the promise of its risk, and what was asked for.
#include <gtest/gtest.h>

#include <numbers>

#include "../bim/facing.hpp"
#include "building/judgement/conformance.hpp"
#include "building/judgement/deviation.hpp"
#include "geometry/statistics.hpp"
#include "small_building.hpp"

namespace plumbline::judgement {
namespace test_conformance {

using judgement::test::isotropic;
using judgement::test::mm;
using judgement::test::Normal;

const ifc::FacadeFrame kSouth = ifc::frame_facing({0, -1, 0}, ifc::FacadeSource::rule, true);

AnchorDeviationT judge(const Eigen::Vector3d& deviation, double u, const std::vector<std::string>& rules,
                       const ifc::FacadeFrame& frame = kSouth) {
  ToleranceTable table;
  for (const std::string& rule : rules) table.rules.push_back(parse_rule(rule));
  AnchorDeviationT out;
  judge_anchor(deviation, u * u * Eigen::Matrix3d::Identity(), frame, tolerances_of(table, {}), {}, out);
  return out;
}

TEST(Conformance, OfOneSignedLengthIsThatOfTheNormalDistribution) {
  const Limited both{Eigen::MatrixXd::Ones(1, 1), 5 * mm, 2 * mm, false};
  const auto p = [&](double d, double u) {
    return conformance(Eigen::VectorXd::Constant(1, d), Eigen::MatrixXd::Constant(1, 1, u * u), {both}, 0.05, 0.005)
        .probability;
  };
  EXPECT_NEAR(p(1 * mm, 1 * mm), normal_probability(4) - normal_probability(-3), 1e-12);
  EXPECT_NEAR(p(-2 * mm, 1 * mm), 0.5, 1e-9);
  EXPECT_EQ(p(-2 * mm, 0), 1) << "at the limit itself";
  EXPECT_EQ(p(-2.001 * mm, 0), 0);
}

TEST(Conformance, OfALengthInSpaceIsThatOfMaxwell) {
  // P(r <= t) of three axes of u: erf(t/u√2) − √(2/π) (t/u) exp(−t²/2u²).
  const double t = 5.0 / 3.0;
  const double maxwell = std::erf(t / std::sqrt(2.0)) - std::sqrt(2 / std::numbers::pi) * t * std::exp(-t * t / 2);
  const AnchorDeviationT judged = judge({0, 0, 0}, 3 * mm, {"*: space=5mm, horizontal=0mm, vertical=0mm"});
  EXPECT_NEAR(judged.pass_probability, maxwell, 3e-3);
  EXPECT_EQ(judged.verdict, ToleranceVerdict::undecided) << "57 % are no pass: k on the length of a vector said so";
}

TEST(Conformance, ThePassHasTheProbabilityThatIsSaid) {
  // Each axis by itself is within with more than 95 %; both at once with 91 %.
  const AnchorDeviationT judged = judge({0, 0, 0}, 2.1 * mm, {});
  ASSERT_EQ(judged.axes[1]->axis, "vertical");
  EXPECT_EQ(judged.axes[1]->verdict, ToleranceVerdict::pass);
  EXPECT_LT(judged.pass_probability, 0.95);
  EXPECT_EQ(judged.verdict, ToleranceVerdict::undecided);
  Normal normal(7);
  for (int trial = 0; trial < 300; ++trial) {
    const AnchorDeviationT some =
        judge({4 * normal() * mm, 3 * normal() * mm, 4 * normal() * mm}, (0.1 + std::abs(normal())) * mm,
              {trial % 2 ? "*: out_of_plane=+5/-2mm" : "*: space=6mm"});
    const ToleranceVerdict expected = some.pass_probability >= 0.95   ? ToleranceVerdict::pass
                                      : some.pass_probability <= 0.05 ? ToleranceVerdict::fail
                                                                      : ToleranceVerdict::undecided;
    EXPECT_EQ(some.verdict, expected);
    EXPECT_EQ(some.verdict == ToleranceVerdict::pass, 5 * mm >= some.tau_pass - 1e-12);
    EXPECT_EQ(some.verdict == ToleranceVerdict::fail, 5 * mm < some.tau_fail - 1e-12);
  }
}

/// False passes of items whose true deviation is drawn from a building (2.5 mm an axis), for u up to half the
/// tolerance.
TEST(Conformance, AtMostTheRiskOfThePassesIsFalse) {
  for (const double share : {0.1, 0.3, 0.5})
    for (const char* rule :
         {"*: horizontal=5mm", "*: horizontal=0mm, vertical=0mm, space=5mm", "*: out_of_plane=5mm"}) {
      Normal normal(11);
      const double u = share * 5 * mm;
      int passed = 0, wrong = 0;
      for (int trial = 0; trial < 800; ++trial) {
        const Eigen::Vector3d truth = 2.5 * mm * Eigen::Vector3d(normal(), normal(), normal());
        const Eigen::Vector3d seen = truth + u * Eigen::Vector3d(normal(), normal(), normal());
        if (judge(seen, u, {rule}).verdict != ToleranceVerdict::pass) continue;
        ++passed, wrong += judge(truth, 0, {rule}).verdict == ToleranceVerdict::fail;
      }
      EXPECT_LE(wrong, 0.05 * passed + 3 * std::sqrt(0.05 * passed)) << rule << " at u = " << share << " tau";
    }
}

TEST(Tolerances, HaveTwoSidesWhereTheLengthHasASign) {
  EXPECT_EQ(judge({0, -4 * mm, 0}, 0.1 * mm, {"*: out_of_plane=+5/-2mm"}).verdict, ToleranceVerdict::pass);
  const AnchorDeviationT inward = judge({0, 4 * mm, 0}, 0.1 * mm, {"*: out_of_plane=+5/-2mm"});
  EXPECT_EQ(inward.verdict, ToleranceVerdict::fail);
  EXPECT_EQ(inward.decided_by, "out_of_plane");
  EXPECT_EQ(judge({0, 0, -1 * mm}, 0.1 * mm, {"*: vertical=-0/+3mm"}).verdict, ToleranceVerdict::fail);
  EXPECT_EQ(judge({0, 0, 2.5 * mm}, 0.1 * mm, {"*: vertical=-0/+3mm"}).verdict, ToleranceVerdict::pass);
  for (const char* wrong : {"*: horizontal=+5/-2mm", "*: vertical=5/2mm", "*: vertical=+5/+2mm", "*: vertical=+5/-2",
                            "*: vertical=+0.5mm/-0.002m", "*: vertical=+0/-0mm", "*: vertical=+0.005m/-2mm",
                            "*: vertical=2mm, horizontal=5mm, vertical=4mm"})
    EXPECT_THROW(parse_rule(wrong), std::runtime_error) << wrong;
}

TEST(Facade, AnAxisThatCannotBeToldIsNoPass) {
  const AnchorDeviationT unknown =
      judge({0, 30 * mm, 0}, 0.3 * mm, {"*: out_of_plane=4mm, vertical=4mm, horizontal=0mm"}, {});
  EXPECT_EQ(unknown.verdict, ToleranceVerdict::undecided);
  EXPECT_EQ(unknown.decided_by, "out_of_plane");
  EXPECT_NE(unknown.note.find("nothing says which way it faces"), std::string::npos);
  const auto guess = ifc::frame_facing({0, -1, 0}, ifc::FacadeSource::guess, false);
  EXPECT_EQ(judge({0, 0, 0}, 0.3 * mm, {"*: out_of_plane=4mm"}, guess).verdict, ToleranceVerdict::undecided);
  const AnchorDeviationT fails = judge({0, 0, 30 * mm}, 0.3 * mm, {"*: out_of_plane=4mm"}, guess);
  EXPECT_EQ(fails.verdict, ToleranceVerdict::fail) << "the height does not ask which way it faces";
}

ifc::Property property(const std::string& set, const std::string& name, const std::string& text, double number,
                       const std::string& measure) {
  ifc::Property p{set, name, text, number};
  p.measure = measure;
  return p;
}

TEST(ToleranceRules, WhatTheDesignAsksForIsAppliedOrRefusedWithItsReason) {
  const auto found = [](const ifc::Property& p, ToleranceFindings& findings,
                        const std::vector<std::string>& rules = {}) {
    const std::vector<ifc::Property> properties = {p};
    ifc::ElementFacts element;
    element.properties = &properties;
    ToleranceTable table;
    for (const std::string& rule : rules) table.rules.push_back(parse_rule(rule));
    return tolerances_of(table, element, &findings);
  };
  const std::string set = "Pset_Tolerance", out = "OrthogonalTolerance";
  ToleranceFindings findings;
  EXPECT_EQ(found(property(set, out, "4 mm", NAN, "IFCLABEL"), findings)[Axis::out_of_plane].value, 4 * mm);
  EXPECT_EQ(
      found(property("Pset_tolerance", out, "0.004", 4 * mm, "IFCPOSITIVELENGTHMEASURE"), findings)[Axis::out_of_plane]
          .value,
      4 * mm);
  ifc::Property bounded = property(set, out, "-2. to 4.", NAN, "IFCPROPERTYBOUNDEDVALUE");
  bounded.lower = -2 * mm, bounded.upper = 4 * mm;
  const Tolerance sides = found(bounded, findings)[Axis::out_of_plane];
  EXPECT_EQ(sides.value, 4 * mm);
  EXPECT_EQ(sides.lower(), 2 * mm);
  EXPECT_TRUE(findings.refused.empty());
  EXPECT_FALSE(found(property(set, out, "4.", 4, "IFCREAL"), findings).contains(Axis::out_of_plane));
  ASSERT_EQ(findings.refused.size(), 1u);
  EXPECT_EQ(findings.refused[0].asked, "Pset_Tolerance.OrthogonalTolerance '4.'");
  EXPECT_EQ(findings.refused[0].reason, "it is an IFCREAL, a number without a unit; expected a length");
  findings = {};
  bounded.name = "HorizontalTolerance";
  found(bounded, findings);
  found(property(set, "PlanarFlatness", "0.002", 2 * mm, "IFCPOSITIVELENGTHMEASURE"), findings);
  found(property(set, "ToleranceDescription", "as drawn", NAN, "IFCTEXT"), findings);
  EXPECT_EQ(findings.refused.size(), 2u);
  // What is no single value has no length, even where a reader left a number or a text with a unit in it.
  for (const char* kind : {"IFCPROPERTYLISTVALUE", "IFCPROPERTYTABLEVALUE", "IFCPROPERTYENUMERATEDVALUE",
                           "IFCPROPERTYREFERENCEVALUE", "IFCCOMPLEXPROPERTY"}) {
    for (const auto& [text, number] : {std::pair{"4 mm", static_cast<double>(NAN)}, {"", 4 * mm}}) {
      findings = {};
      EXPECT_FALSE(found(property(set, out, text, number, kind), findings).contains(Axis::out_of_plane))
          << kind << " '" << text << "'";
      ASSERT_EQ(findings.refused.size(), 1u) << kind;
      EXPECT_NE(findings.refused[0].reason.find(kind), std::string::npos) << findings.refused[0].reason;
    }
  }
  findings = {};
  found(property(set, out, "4.", 4, "IFCREAL"), findings, {"*: out_of_plane=4mm"});
  EXPECT_TRUE(findings.refused.empty()) << "a rule takes its place";
}

/// Once every one of these was NOT JUDGED as "a text without a length and its unit".
TEST(ToleranceRules, TextsAreReadAsPeopleWriteThem) {
  const auto vertical = [](const std::string& text) {
    const std::vector<ifc::Property> properties = {
        property("Pset_Tolerance", "VerticalTolerance", text, NAN, "IFCLABEL")};
    ifc::ElementFacts element;
    element.properties = &properties;
    ToleranceFindings findings;
    const Tolerances found = tolerances_of({}, element, &findings);
    return findings.refused.empty() ? found.at(Axis::vertical).value : NAN;
  };
  EXPECT_NEAR(vertical("±10 mm"), 10 * mm, 1e-12);
  EXPECT_NEAR(vertical("+/- 13 mm"), 13 * mm, 1e-12);
  EXPECT_NEAR(vertical("10,5 mm"), 10.5 * mm, 1e-12);
  EXPECT_NEAR(vertical("1.0 cm"), 10 * mm, 1e-12);
  EXPECT_NEAR(vertical("3/8 in"), 9.525 * mm, 1e-12);
  EXPECT_NEAR(vertical("0.40\""), 10.16 * mm, 1e-12);
  EXPECT_NEAR(vertical("+3/-2mm"), 3 * mm, 1e-12);
  for (const char* unclear : {"10", "1,000 mm", "1,0.5 mm", "10 pt", "mm", "3/0 mm", "10 mm or 12 mm", "--5 mm"})
    EXPECT_TRUE(std::isnan(vertical(unclear))) << unclear << ": " << vertical(unclear);
}

/// Once an anchor 3.2 mm high passed though its assembly, its storey or a set called Pset_Tolerances asked for 1 mm.
TEST(ToleranceRules, WhatIsAskedOfWhatHoldsAnElementNarrowsItsTolerancesOrIsTold) {
  const auto found = [](const std::vector<ifc::Property>& properties, ToleranceFindings& findings,
                        const std::vector<std::string>& rules = {}) {
    ifc::ElementFacts element;
    element.properties = &properties;
    ToleranceTable table;
    for (const std::string& rule : rules) table.rules.push_back(parse_rule(rule));
    return tolerances_of(table, element, &findings);
  };
  const auto of = [](const std::string& holder, double value, const std::string& set = "Pset_Tolerance") {
    ifc::Property p = property(set, "VerticalTolerance", "v", value, "IFCLENGTHMEASURE");
    p.holder = holder;
    return p;
  };
  const std::string storey = "IfcBuildingStorey 'Floor 2'", assembly = "IfcElementAssembly 'A1'";
  ToleranceFindings findings;
  const Tolerance narrow = found({of(storey, 1 * mm)}, findings)[Axis::vertical];
  EXPECT_EQ(narrow.value, 1 * mm);
  EXPECT_EQ(narrow.source, "design: Pset_Tolerance.VerticalTolerance of IfcBuildingStorey 'Floor 2'");
  EXPECT_TRUE(findings.refused.empty());
  EXPECT_EQ(found({of(storey, 1 * mm), of("", 8 * mm)}, findings)[Axis::vertical].value, 8 * mm)
      << "its own goes before";
  EXPECT_EQ(found({of(assembly, 2 * mm), of(storey, 1 * mm)}, findings)[Axis::vertical].value, 1 * mm);
  EXPECT_TRUE(findings.refused.empty());
  EXPECT_EQ(found({of(storey, 20 * mm)}, findings)[Axis::vertical].value, 5 * mm)
      << "nothing is widened from elsewhere";
  EXPECT_TRUE(findings.refused.empty()) << "the narrower limit is safe: once every anchor was undecided for it";
  EXPECT_EQ(findings.wider,
            std::vector<std::string>{"Pset_Tolerance.VerticalTolerance of IfcBuildingStorey 'Floor 2'"});
  findings = {};
  EXPECT_EQ(found({of(assembly, 3 * mm), of(storey, 4 * mm)}, findings)[Axis::vertical].value, 3 * mm);
  EXPECT_TRUE(findings.wider.empty()) << "a nearer one gave the axis";
  EXPECT_EQ(found({of("", 3 * mm), of(storey, 20 * mm)}, findings)[Axis::vertical].value, 3 * mm);
  EXPECT_EQ(found({of(storey, 20 * mm)}, findings, {"*: vertical=20mm"})[Axis::vertical].value, 20 * mm);
  EXPECT_TRUE(findings.refused.empty() && findings.wider.empty()) << "a rule says that it is meant";
  EXPECT_EQ(found({of("", 1 * mm, "PSet_tolerance ")}, findings)[Axis::vertical].value, 1 * mm);
  found({of("", 1 * mm, "Pset_Tolerances")}, findings);
  ASSERT_EQ(findings.refused.size(), 1u);
  EXPECT_NE(findings.refused[0].reason.find("expected Pset_Tolerance"), std::string::npos);
  findings = {};
  found({property("Pset_FireRating", "VerticalTolerance", "v", 1 * mm, "IFCLENGTHMEASURE")}, findings);
  EXPECT_TRUE(findings.refused.empty()) << "other sets say nothing of tolerances";
  found({property("Pset_Tolerance", "VerticalTolerance", "0.01", 10 * mm, "IFCLENGTHMEASURE"),
         property("Pset_Tolerance", "VerticalTolerance", "0.003", 3 * mm, "IFCLENGTHMEASURE")},
        findings);
  ASSERT_EQ(findings.refused.size(), 1u) << "of two that differ nobody knows which is meant";
  findings = {};
  found({property("Pset_Tolerance", "VerticalTolerance", "", NAN, "IFCQUANTITYLENGTH")}, findings);
  ASSERT_EQ(findings.refused.size(), 1u);
  findings = {};
  ifc::Property about = property("Pset_Tolerance", "VerticalTolerance", "-4 to 10 about 3", NAN,
                                 "IFCPROPERTYBOUNDEDVALUE with a set point");
  about.lower = -4 * mm, about.upper = 10 * mm;
  found({about}, findings);
  ASSERT_EQ(findings.refused.size(), 1u) << "the bounds are about another value than zero";
}

/// A facade of floors and columns, as built as designed.
DeviationInputs grid(int columns, int rows) {
  DeviationInputs inputs;
  inputs.design_file = "d.ifc";
  for (int row = 0; row < rows; ++row)
    for (int column = 0; column < columns; ++column) {
      AnchorCase anchor;
      anchor.id = "A" + std::to_string(row) + "." + std::to_string(column);
      anchor.element.guid = "g" + anchor.id, anchor.storey_guid = "s" + std::to_string(row);
      anchor.floor = row + 1, anchor.column = column + 1, anchor.use = "check";
      anchor.design = {2.0 * column, 0, 3.0 * row};
      anchor.tolerances = tolerances_of({}, {});
      inputs.model.ids.push_back(anchor.id);
      inputs.model.positions.push_back(anchor.design);
      inputs.anchors.push_back(anchor);
    }
  inputs.model.covariance = isotropic(inputs.model.ids.size(), 0.4 * mm);
  plumbline::test::face(inputs, {0, -1, 0});
  return inputs;
}

/// Of a survey that is too large for a joint covariance only the anchors' own are known: taken as independent, a floor
/// would be known eight times as well as it is, and "hang low" by what is one error of the control.
TEST(Requests, WithoutAJointCovarianceNoMeanIsBetterKnownThanOneAnchor) {
  DeviationInputs inputs = grid(8, 8);
  const auto u_of_floor = [&] {
    const DeviationT result = judge_deviations(inputs, {});
    for (const auto& group : result.group_shifts)
      if (group->kind == "floor") return group->u.z();
    return 0.0;
  };
  EXPECT_LT(u_of_floor(), 0.25 * mm);
  inputs.common_unknown = true;
  EXPECT_GE(u_of_floor(), 0.4 * mm);
  EXPECT_EQ(judge_deviations(inputs, {}).passed, 64) << "each anchor is as well known as before";
}

TEST(Requests, WhatIsNotJudgedForbidsReady) {
  DeviationInputs inputs = grid(3, 3);
  ASSERT_EQ(judge_deviations(inputs, {}).verdict, ToleranceVerdict::pass);
  inputs.requests.push_back(
      {"class=IfcMechanicalFastenr: vertical=1mm", "rule", 0, 0, "it selects no anchor and no panel"});
  DeviationT result = judge_deviations(inputs, {});
  EXPECT_EQ(result.verdict, ToleranceVerdict::undecided);
  EXPECT_EQ(result.not_judged, 1);
  EXPECT_EQ(result.passed, 9);
  inputs.requests.clear();
  inputs.anchors[4].refused = {{"Pset_Tolerance.OrthogonalTolerance '4.'", "design", "it is an IFCREAL"}};
  result = judge_deviations(inputs, {});
  EXPECT_EQ(result.anchors[4]->verdict, ToleranceVerdict::undecided);
  EXPECT_NE(result.anchors[4]->note.find("IFCREAL"), std::string::npos);
  EXPECT_EQ(result.passed, 8);
  ASSERT_EQ(result.requests.size(), 1u);
  EXPECT_EQ(result.requests[0]->anchors, 1);
}

}  // namespace test_conformance
}  // namespace plumbline::judgement
