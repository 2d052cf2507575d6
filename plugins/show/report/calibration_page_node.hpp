// report.calibration: the page of a calibration.
#pragma once

#include "artifacts/file.hpp"
#include "plumbline/node.hpp"

namespace plumbline::report {

struct ReportCalibration : Node {
  static constexpr Info info{"report.calibration", "", 2, "HTML page of a camera calibration"};
  In<File> calibration{"calibration", "the calibration.json of calibrate.board"};
  Param<std::string> title{"title", "Camera calibration", "heading"};
  Param<std::string> subtitle{"subtitle", "", "line below the heading"};
  Param<std::string> name{"name", "calibration.html", "base name of the file"};
  Param<std::string> language{"language", "en", one_of("en", "de"), "of the page"};
  Param<std::string> units{"units", "mm", one_of("mm", "in"), "of lengths on the page; data files keep theirs"};
  Out<File> out{"file", "one HTML file that needs no network"};

  void run(Context& context) override;
};

}  // namespace plumbline::report
