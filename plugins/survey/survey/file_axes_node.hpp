// survey.in_file_axes: a network result for whoever knows the points by the coordinates of the file.
#pragma once

#include "artifacts/survey_network.hpp"
#include "artifacts/survey_observations.hpp"
#include "plumbline/node.hpp"

namespace plumbline::survey {

/// The output has a frame of its own, so that it cannot be connected where E, N, H are meant.
struct FileAxesNode : Node {
  static constexpr Info info{"survey.in_file_axes", "", 1,
                             "Writes a network result in the axes of its survey file (gama-local: axes-xy), for "
                             "comparison with that file; all other nodes speak E, N, H"};
  In<SurveyNetwork> network{"network", frame("frame=?S"), "the result in E, N, H"};
  List<plumbline::SurveyObservations> observations{"observations", frame("frame=?S"),
                                                   "the files it was computed from; their axes must agree"};
  Out<SurveyNetwork> result{"network", frame("frame=file"), "the same in the axes of the files"};
  void run(Context& context) override;
};

}  // namespace plumbline::survey
