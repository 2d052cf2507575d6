// survey.epoch_series: three epochs and more, each adjusted by itself, to movements, velocities and levels.
#pragma once

#include "artifacts/file.hpp"
#include "artifacts/input_files.hpp"
#include "artifacts/survey_observations.hpp"
#include "map_parameters.hpp"
#include "survey/model/network_result.hpp"

namespace plumbline::survey {

struct EpochSeriesNode : MappedNode {
  static constexpr Info info{"survey.epoch_series", "", 8,
                             "Adjusts the epochs of a network one by one and finds what stays, what moves, how fast, "
                             "and what reaches a level"};
  List<plumbline::SurveyObservations> epochs{"epochs", frame("frame=?S"), "readings of one epoch each, oldest first"};
  Optional<InputFiles> inputs{"inputs", "the files that were read: the last lines of the verdict count them"};
  Optional<InputFiles> unread{"unread", "what else lay in their folder"};
  Param<std::vector<double>> days{"days", std::vector<double>{}, "d", between(-1e6, 1e6),
                                  "when each epoch was measured, from any day on; empty: the dates of the files, or "
                                  "1, 2, 3 where they name none"};
  Param<std::vector<std::string>> stable{"stable", std::vector<std::string>{},
                                         "points that carry the datum; empty: those that are found to stay"};
  Param<std::string> datum{"datum", "free", one_of("free", "file"),
                           "free: each epoch is a free network; file: known points of the files hold them"};
  Param<double> warning_level{"warning_level", 0.0, "m", between(0, 100), "length of a movement; 0: none"};
  Param<double> alarm_level{"alarm_level", 0.0, "m", between(0, 100), "length of a movement; 0: none"};
  Param<double> alpha{"alpha", 0.05, "1", between(1e-6, 0.5), "error of the first kind of tests of the whole"};
  Param<double> alpha0{"alpha0", 0.001, "1", between(1e-9, 0.5), "error of the first kind of the test of a point"};
  Out<File> series{"series", "epochs, stable points and every point with its movements, velocity and levels, as JSON"};
  Out<File> table{"table", "one row a point and epoch, as CSV"};
  Out<File> page{"page", "what moves, and a chart of each point over time, as HTML in English"};
  Out<File> verdict{"verdict", "what moves, in a few lines"};
  void run(Context& context) override;

 private:
  /// What took part, and what did not; empty where `inputs` is not connected.
  std::string words_of_evidence() const;
  /// One epoch by itself. Throws where it is no result, or says less than a series needs.
  NetworkResult adjusted(Context& context, const plumbline::survey::SurveyObservations& survey,
                         const std::string& name) const;
};

}  // namespace plumbline::survey
