// report.dxf: the judgement as a drawing.
#pragma once

#include "artifacts/deviation.hpp"
#include "artifacts/file.hpp"
#include "building/judgement/deviation_dxf.hpp"
#include "plumbline/node.hpp"

namespace plumbline::report {

struct ReportDxf : Node {
  static constexpr Info info{
      "report.dxf", "", 1,
      "A drawing for CAD (DXF R12): anchors and panels by verdict, deviations as arrows and words"};
  In<Deviation> deviation{"deviation", frame("frame=?F"), "as-built minus design, judged"};
  Param<double> exaggeration{"exaggeration", 100, "1", between(1, 1e4), "how many times too long deviations are drawn"};
  Out<File> out{"file", "deviations.dxf"};

  void run(Context&) override {
    FileT file;
    file.name = "deviations.dxf", file.media_type = "image/vnd.dxf";
    const std::string text = judgement::deviation_dxf(deviation.unpack(), *exaggeration);
    file.content.assign(text.begin(), text.end());
    out.commit(file);
  }
};

}  // namespace plumbline::report
