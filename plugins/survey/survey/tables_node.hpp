// survey.tables: what a surveyor opens in a spreadsheet.
#pragma once

#include "artifacts/file.hpp"
#include "artifacts/input_files.hpp"
#include "artifacts/points.hpp"
#include "artifacts/survey_network.hpp"
#include "plumbline/node.hpp"

namespace plumbline::survey {

struct TablesNode : Node {
  static constexpr Info info{"survey.tables", "", 4,
                             "Writes adjusted coordinates, and what neighbouring markers are known relative to each "
                             "other, as CSV for a spreadsheet"};
  In<Points> points{"points", frame("frame=?S"), "the adjusted points in E, N, H, with covariance"};
  In<SurveyNetwork> network{"network", frame("frame=?F"),
                            "the same adjustment, in E, N, H or in the axes of the file: the table has those"};
  Optional<InputFiles> inputs{"inputs", "the files that were read, and what was set aside, for the verdict"};
  Optional<InputFiles> unread{"unread", "what else lay in the folder, for the verdict"};
  Param<std::vector<std::string>> pairs{"pairs", std::vector<std::string>{},
                                        "further pairs for the relative table, each as 'A B' or 'A;B'"};
  Param<int64_t> neighbours{"neighbours", 4, between(0, 1000),
                            "every marker is paired with so many of its nearest ones in the relative table"};
  Param<std::string> decimal{"decimal", "point", one_of("point", "comma"),
                             "decimal separator; with a comma the cells are separated by semicolons"};
  Out<File> coordinates{"coordinates", "one row a point: coordinates, standard deviations, 95 % ellipse"};
  Param<bool> full_covariance{
      "full_covariance", false,
      "`covariance` holds the whole covariance of all points; otherwise nothing but its header"};
  Out<File> relative{"relative", "one row a pair of points: difference, its covariance, 95 % relative ellipse"};
  Out<File> observations{"observations", "one row an observation: reading, residual, tests, where it stands"};
  Out<File> verdict{"verdict", "the verdict, the worst five readings and what to measure again, as text"};
  Out<File> blocks{"blocks", "every point with its 3 x 3 covariance, as JSON"};
  Out<File> covariance{"covariance",
                       "the 3n x 3n covariance [m^2] of all points in the order of `blocks`, as NumPy .npy"};
  void run(Context& context) override;
};

}  // namespace plumbline::survey
