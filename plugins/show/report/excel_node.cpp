#include "show/report/excel_node.hpp"

#include "show/report/deviation_workbook.hpp"

namespace plumbline::report {

void ReportExcel::run(Context&) {
  FileT file;
  file.name = "deviations.xlsx";
  file.media_type = "application/vnd.openxmlformats-officedocument.spreadsheetml.sheet";
  const std::string bytes = write_workbook(deviation_sheets(deviation.unpack(), speech_of(*language, "mm").language));
  file.content.assign(bytes.begin(), bytes.end());
  out.commit(file);
}

}  // namespace plumbline::report
