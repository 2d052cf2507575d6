// report.calibration: the page of a calibration.
#pragma once

#include "artifacts/file.hpp"
#include "plumbline/node.hpp"

namespace plumbline::report {

struct ReportCalibration : Node {
  static constexpr Info info{"report.calibration", "", 1, "HTML page of a camera calibration"};
  In<File> calibration{"calibration", "the calibration.json of calibrate.board"};
  Param<std::string> title{"title", "Camera calibration", "heading"};
  Param<std::string> subtitle{"subtitle", "", "line below the heading"};
  Param<std::string> name{"name", "calibration.html", "base name of the file"};
  Out<File> out{"file", "one HTML file that needs no network"};

  void run(Context& context) override;
};

}  // namespace plumbline::report
