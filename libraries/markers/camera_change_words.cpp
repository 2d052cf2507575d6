// What is said of cameras that change and of photographs that scatter.
#include <algorithm>
#include <cmath>
#include <cstdio>

#include "markers/camera_changes.hpp"

namespace plumbline::markers {
namespace {

using Split = CameraChange::Split;
using What = CameraChange::What;

std::string list_of(const std::vector<int>& members, const std::vector<std::string>& paths) {
  constexpr std::size_t most = 4;
  std::string list;
  for (std::size_t k = 0; k < std::min(most, members.size()); ++k)
    list += (k ? ", " : "") + paths[static_cast<std::size_t>(members[k])];
  return list + (members.size() > most ? ", ..." : "");
}

std::string where(const CameraChange& change, const CameraEvidence& evidence) {
  const std::string count = std::to_string(change.second.size());
  const std::string list = " (" + list_of(change.second, evidence.paths) + ")";
  switch (change.split) {
    case Split::from_on:
      return "from " + evidence.paths[static_cast<std::size_t>(change.second.front())] + " on";
    case Split::drift:
      return "from " + evidence.paths.front() + " to " + evidence.paths.back() + ", bit by bit,";
    case Split::every:
      return std::string("in every ") +
             (change.period == 2   ? "second"
              : change.period == 3 ? "third"
                                   : "fourth") +
             " photograph" + list;
    case Split::some:
      return "in " + count + " photographs" + list;
    case Split::upside_down:
      return "in the " + count + " photographs that are held upside down against the others" + list;
  }
  return "";
}

}  // namespace

std::string in_words(const CameraChange& change, const CameraEvidence& evidence) {
  char text[200];
  std::string cause;
  switch (change.what) {
    case What::focus:
      std::snprintf(text, sizeof text, " the principal distance is %.2f %% %s", 100 * std::abs(change.by.x()),
                    change.by.x() > 0 ? "longer" : "shorter");
      cause = "focus or zoom";
      break;
    case What::aspect:
      std::snprintf(text, sizeof text, " fx is %.2f %% %s against fy", 100 * std::abs(change.by.x()),
                    change.by.x() > 0 ? "longer" : "shorter");
      cause = "pictures that a program stretched";
      break;
    case What::principal_point:
      std::snprintf(text, sizeof text, " the principal point lies elsewhere by %.1f, %.1f px", change.by.x(),
                    change.by.y());
      cause = change.split == Split::upside_down ? "pictures that a program turned by 180 degrees"
                                                 : "pictures that a program cropped or turned, or a stabiliser";
      break;
    case What::distortion:
      std::snprintf(text, sizeof text, " the distortion is another (k1 by %+.3f)", change.by.x());
      cause = "focus, another lens, or pictures that a program freed of distortion";
      break;
  }
  return where(change, evidence) + text + ": " + cause;
}

std::vector<std::string> warnings_of(const CameraTruth& truth) {
  std::vector<std::string> words;
  if (truth.change) words.push_back(in_words(*truth.change, truth.evidence));
  // What changes explains the scatter.
  const std::string scatter = in_words(truth.empirical, truth.change ? Scatter{} : truth.scatter);
  if (!scatter.empty()) words.push_back(scatter);
  return words;
}

}  // namespace plumbline::markers
