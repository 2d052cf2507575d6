#include "tables_node.hpp"

#include <optional>
#include <string>

#include "artifacts/input_files_text.hpp"
#include "artifacts/joint_memory.hpp"
#include "point_files.hpp"
#include "tables.hpp"
#include "verdict_text.hpp"

namespace plumbline::survey {

namespace {

FileT file_of(const char* name, const char* media_type, const std::string& text) {
  FileT file;
  file.name = name;
  file.media_type = media_type;
  file.content.assign(text.begin(), text.end());
  return file;
}

}  // namespace

void TablesNode::run(Context& context) {
  announce_joint(context, joint_size(points), 4);
  const PointsT all = points.unpack();
  const SurveyNetworkT result = network.unpack();
  const TableFormat format = *decimal == "comma" ? TableFormat{',', ';'} : TableFormat{};
  if (all.covariance.empty() && *neighbours != 0 && *neighbours != 4)
    context.warn("'neighbours' is " + std::to_string(*neighbours) +
                 ", and 'points' has no joint covariance: the relative table has each marker with its nearest four and "
                 "the pairs that the adjustment was asked for; give covariance=full to the adjustment");
  coordinates.commit(file_of("coordinates.csv", "text/csv", coordinate_table(result, all, format)));
  relative.commit(
      file_of("relative.csv", "text/csv", relative_table(result, all, *pairs, static_cast<int>(*neighbours), format)));
  observations.commit(file_of("observations.csv", "text/csv", observation_table(result, format)));
  std::optional<InputFilesT> read, left;
  if (inputs) read = inputs.unpack();
  if (unread) left = unread.unpack();
  const UsedInputs used{-1, result.readings_left_out, result.exclusions};
  std::string text = verdict_text(result);
  if (!read && result.readings > 0)
    text += "Took part: " + counted_readings(result.readings, result.readings_left_out) + ", " +
            counted(static_cast<long>(result.files.size()), "file", "files") + ".\n";
  text += words_of_inputs(read ? &*read : nullptr, left ? &*left : nullptr, used);
  verdict.commit(file_of("verdict.txt", "text/plain", text));
  if (*full_covariance && all.covariance.empty())
    throw std::runtime_error(
        "'full_covariance' is wanted, and 'points' has no joint covariance: give covariance=full to the adjustment");
  blocks.commit(file_of("points.json", "application/json", points_as_json(all, result)));
  covariance.commit(file_of("covariance.npy", "application/octet-stream", covariance_as_npy(all, *full_covariance)));
}

}  // namespace plumbline::survey
