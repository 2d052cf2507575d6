#include "tables_node.hpp"

#include "tables.hpp"

namespace plumbline::survey {

namespace {

FileT csv(const char* name, const std::string& text) {
  FileT file;
  file.name = name;
  file.media_type = "text/csv";
  file.content.assign(text.begin(), text.end());
  return file;
}

}  // namespace

void TablesNode::run(Context&) {
  const PointsT all = points.unpack();
  const SurveyNetworkT result = network.unpack();
  const TableFormat format = *decimal == "comma" ? TableFormat{',', ';'} : TableFormat{};
  coordinates.commit(csv("coordinates.csv", coordinate_table(result, all, format)));
  relative.commit(csv("relative.csv", relative_table(result, all, *pairs, static_cast<int>(*neighbours), format)));
}

}  // namespace plumbline::survey
