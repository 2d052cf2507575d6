#include "file_axes_node.hpp"

#include <stdexcept>

#include "file_axes.hpp"

namespace plumbline::survey {

void FileAxesNode::run(Context&) {
  std::string axes, first_file;
  for (size_t i = 0; i < observations.size(); ++i) {
    const SurveyObservationsT survey = observations.unpack(i);
    const std::string own = survey.info->axes_xy.empty() ? "en" : survey.info->axes_xy;
    const std::string file = survey.files.empty() ? "survey " + std::to_string(i + 1) : survey.files.front();
    if (axes.empty()) {
      axes = own;
      first_file = file;
    } else if (own != axes) {
      throw std::runtime_error("the axes of the files differ: " + first_file + " has '" + axes + "', " + file +
                               " has '" + own + "'; leave this node out to get E, N, H");
    }
  }
  if (axes.empty()) throw std::runtime_error("'observations' holds no survey file");
  SurveyNetworkT turned = network.unpack();
  if (!turned.axes.empty() && turned.axes != "en")
    throw std::runtime_error("the network is in axes '" + turned.axes + "' already, expected 'en' (E, N, H)");
  turn_to_file_axes(turned, axes);
  result.commit(turned);
}

}  // namespace plumbline::survey
