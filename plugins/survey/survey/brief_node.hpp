// survey.brief: a network result that grows with what is to be said of it, not with what was measured.
#pragma once

#include "artifacts/survey_network.hpp"
#include "plumbline/node.hpp"

namespace plumbline::survey {

/// Leaves out of a large result what other files have: covariances and ellipsoids, sightings that pass, and
/// observations beyond `most` of which nothing is to be said; and of points all but 500. A result with fewer stays as
/// it is but for the covariances.
void make_brief(SurveyNetworkT& network, std::size_t most);

struct BriefNode : Node {
  static constexpr Info info{
      "survey.brief", "", 2,
      "Keeps of a network result the observations that something is to be said of and those most "
      "suspect; all are in the tables of survey.tables"};
  In<SurveyNetwork> network{"network", frame("frame=?F"), "the whole result"};
  Param<int64_t> most{"most", 1000, between(0, 1000000),
                      "observations that are kept where more are neither flagged, removed nor uncontrolled"};
  Out<SurveyNetwork> result{"network", frame("frame=?F"), "the same with those observations only"};
  void run(Context& context) override;
};

}  // namespace plumbline::survey
