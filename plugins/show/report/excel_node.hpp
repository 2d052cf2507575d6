// report.excel: the judgement as a workbook.
#pragma once

#include "artifacts/deviation.hpp"
#include "artifacts/file.hpp"
#include "plumbline/node.hpp"

namespace plumbline::report {

struct ReportExcel : Node {
  static constexpr Info info{
      "report.excel", "", 1,
      "A workbook (.xlsx): anchors and panels, first to mend first, floors, and what was asked for"};
  In<Deviation> deviation{"deviation", frame("frame=?F"), "as-built minus design, judged"};
  Param<std::string> language{"language", "en", one_of("en", "de"), "of heads and verdicts"};
  Out<File> out{"file", "deviations.xlsx"};

  void run(Context& context) override;
};

}  // namespace plumbline::report
