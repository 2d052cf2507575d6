// evaluate.surface_deviation: the judgement of a building of which nobody measured anchors.
#include <cmath>

#include "artifacts/accuracy.hpp"
#include "artifacts/design.hpp"
#include "artifacts/deviation.hpp"
#include "artifacts/surface_judgement.hpp"
#include "artifacts/survey_observations.hpp"
#include "node_harness.hpp"

namespace test_surface_deviation {

using namespace plumbline;
using namespace plumbline::test;

/// So many verdicts of each kind, and a rule that was judged everywhere, or was not for this reason.
SurfaceJudgementT judged(int passed, int undecided, int failed, int not_judged,
                         const std::string& rule_not_judged = "") {
  SurfaceJudgementT surfaces;
  surfaces.risk = 0.03, surfaces.covariance_factor = 1.7;
  surfaces.passed = passed, surfaces.undecided = undecided, surfaces.failed = failed, surfaces.not_judged = not_judged;
  const auto add = [&](int count, ToleranceVerdict which, const std::string& why) {
    for (int i = 0; i < count; ++i) {
      auto verdict = std::make_unique<SurfaceVerdictT>();
      verdict->quantity = "bow", verdict->panel = "P1", verdict->rule = "*: bow=4mm", verdict->verdict = which;
      verdict->not_judged = why;
      surfaces.verdicts.push_back(std::move(verdict));
    }
  };
  add(passed, ToleranceVerdict::pass, ""), add(undecided, ToleranceVerdict::undecided, "");
  add(failed, ToleranceVerdict::fail, ""), add(not_judged, ToleranceVerdict::not_measured, "glass");
  surfaces.requests.push_back(std::make_unique<JudgementRequestT>());
  surfaces.requests.back()->asked = "*: bow=4mm", surfaces.requests.back()->by = "rule";
  surfaces.requests.back()->panels = 3, surfaces.requests.back()->not_judged = rule_not_judged;
  return surfaces;
}

DesignT design_of(const std::string& file) {
  DesignT design;
  design.project_guid = "0123456789012345678901", design.file_name = file;
  return design;
}

struct Judged {
  NodeHarness node{"evaluate.surface_deviation"};
  explicit Judged(const SurfaceJudgementT& surfaces, const std::string& file = "tower.ifc") {
    node.input<Design>("design", design_of(file)), node.input<SurfaceJudgement>("surface_judgement", surfaces);
    node.run();
  }
  DeviationT deviation() const { return node.output<Deviation>("deviation"); }
  bool is_invalid() const {
    try {
      return node.metric("invalid") == 1;
    } catch (const std::out_of_range&) {
      return false;
    }
  }
};

TEST(SurfaceDeviation, TheWorstVerdictIsThatOfTheWhole) {
  EXPECT_EQ(Judged(judged(4, 0, 0, 0)).deviation().verdict, ToleranceVerdict::pass);
  EXPECT_EQ(Judged(judged(4, 1, 0, 0)).deviation().verdict, ToleranceVerdict::undecided);
  EXPECT_EQ(Judged(judged(0, 1, 0, 0)).deviation().verdict, ToleranceVerdict::undecided);
  EXPECT_EQ(Judged(judged(4, 0, 0, 1)).deviation().verdict, ToleranceVerdict::undecided)
      << "a panel that was not judged may be the one that is wrong";
  EXPECT_EQ(Judged(judged(4, 1, 1, 1)).deviation().verdict, ToleranceVerdict::fail);
  EXPECT_EQ(Judged(judged(0, 0, 1, 0)).deviation().verdict, ToleranceVerdict::fail);
  EXPECT_EQ(Judged(judged(0, 0, 0, 2)).deviation().verdict, ToleranceVerdict::not_measured) << "nothing was";
  EXPECT_EQ(Judged(judged(0, 0, 0, 0)).deviation().verdict, ToleranceVerdict::not_measured);
}

TEST(SurfaceDeviation, ARuleThatWasNotJudgedIsSaidAndMakesItInvalid) {
  const Judged all(judged(4, 0, 0, 0)), one(judged(4, 0, 0, 0, "it selects nothing"));
  EXPECT_FALSE(all.is_invalid());
  EXPECT_EQ(all.deviation().not_judged, 0);
  EXPECT_TRUE(one.is_invalid());
  const DeviationT deviation = one.deviation();
  EXPECT_EQ(deviation.verdict, ToleranceVerdict::undecided);
  EXPECT_EQ(deviation.not_judged, 1);
  ASSERT_EQ(deviation.requests.size(), 1U);
  EXPECT_EQ(deviation.requests[0]->asked, "surfaces, *: bow=4mm");
  EXPECT_EQ(deviation.requests[0]->by, "rule");
  EXPECT_EQ(deviation.requests[0]->panels, 3);
  EXPECT_EQ(deviation.requests[0]->not_judged, "it selects nothing");
}

TEST(SurfaceDeviation, CarriesTheVerdictsAndNothingOfAnchorsOrFloors) {
  const Judged all(judged(1, 1, 2, 1));
  const DeviationT deviation = all.deviation();
  EXPECT_EQ(deviation.design_file, "tower.ifc");
  EXPECT_EQ(deviation.risk, 0.03);
  EXPECT_TRUE(deviation.anchors.empty());
  EXPECT_TRUE(deviation.floors.empty());
  EXPECT_TRUE(deviation.warnings.empty()) << "that verdicts count in no floor is no news without floors";
  ASSERT_TRUE(deviation.surfaces);
  ASSERT_EQ(deviation.surfaces->verdicts.size(), 5U);
  EXPECT_EQ(deviation.surfaces->verdicts[2]->verdict, ToleranceVerdict::fail) << "in their order";
  EXPECT_EQ(deviation.surfaces->verdicts[4]->not_judged, "glass");
  EXPECT_EQ(deviation.surfaces->failed, 2);
  EXPECT_EQ(deviation.surfaces->covariance_factor, 1.7);
  EXPECT_EQ(Judged(judged(1, 0, 0, 0), "").deviation().design_file, "");
  EXPECT_NO_THROW(all.node.output<Accuracy>("accuracy"));
}

/// Who has a scan has no campaign.yaml.
TEST(SurfaceDeviation, WhereTheDateIsMissingItIsAskedForWhereItCanBeSaid) {
  const Judged all(judged(1, 0, 1, 0));
  const auto warning = [&](bool with_survey, const std::string& date) {
    NodeHarness issues("bim.write_bcf");
    issues.input<Deviation>("deviation", all.deviation()), issues.input<Design>("design", design_of("tower.ifc"));
    if (with_survey) {
      SurveyObservationsT survey;
      survey.info = std::make_unique<SurveyInfoT>();
      issues.input<SurveyObservations>("survey", survey);
    }
    issues.set("date", date), issues.run();
    std::string words;
    for (const std::string& line : issues.warnings()) words += line;
    return words;
  };
  EXPECT_NE(warning(true, "").find("'date' in campaign.yaml or 'date' says it"), std::string::npos)
      << warning(true, "");
  EXPECT_EQ(warning(false, "").find("campaign.yaml"), std::string::npos) << warning(false, "");
  EXPECT_NE(warning(false, "").find("'date' says it (of scan_surfaces measured=2026-05-12T10:30:00)"),
            std::string::npos);
  EXPECT_EQ(warning(false, "2026-05-12").find("when it was measured"), std::string::npos);
}

}  // namespace test_surface_deviation
