// What is said of cameras that change and of photographs that scatter.
#include <fmt/core.h>

#include <algorithm>
#include <cmath>

#include "base/text/words.hpp"
#include "photo/markers/camera_changes.hpp"
#include "photo/markers/camera_splits.hpp"

namespace plumbline::markers {
namespace {

using Split = CameraChange::Split;
using What = CameraChange::What;

std::string list_of(const std::vector<int>& members, const std::vector<std::string>& paths) {
  std::vector<std::string> names;
  for (const int member : members) names.push_back(paths[member]);
  return text::join(names, 4);
}

/// "from IMG_0015.JPG to IMG_0028.JPG and from IMG_0040.JPG on".
std::string stretches_in_words(const std::vector<int>& second, const std::vector<std::string>& paths) {
  std::string words;
  for (const auto& [first, last] : runs_of(second))
    words += (words.empty() ? "" : " and ") + (first == last ? "in " + paths[first]
                                               : last + 1 == std::ssize(paths)
                                                   ? "from " + paths[first] + " on"
                                                   : "from " + paths[first] + " to " + paths[last]);
  return words;
}

std::string where(const CameraChange& change, const CameraEvidence& evidence) {
  const std::string count = std::to_string(change.second.size());
  const std::string list = " (" + list_of(change.second, evidence.paths) + ")";
  switch (change.split) {
    case Split::from_on:
      return "from " + evidence.paths[change.second.front()] + " on";
    case Split::stretches:
      return stretches_in_words(change.second, evidence.paths);
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

std::string name_of(What what) {
  switch (what) {
    case What::focus:
      return "the principal distance";
    case What::aspect:
      return "fx against fy";
    case What::principal_point:
      return "the principal point";
    case What::distortion:
      return "the distortion";
    case What::undistorted:
      return "a program that took the distortion away";
    case What::turned:
      return "a program that turned the pictures";
    case What::several:
      return "several of its parameters";
  }
  return "";
}

/// "2.01 ± 0.05 % longer"; without its size where that is not known.
std::string longer(double by, double sigma, bool sized) {
  return (sized ? fmt::format("{:.2f} ± {:.2f} % ", 100 * std::abs(by), 100 * sigma) : "") +
         (by > 0 ? "longer" : "shorter");
}

std::string elsewhere(const CameraChange& change, Eigen::Index at, bool sized) {
  const auto& by = change.by;
  const auto& sigma = change.sigma;
  return sized ? fmt::format("elsewhere by {:.1f} ± {:.1f}, {:.1f} ± {:.1f} px", by(at), sigma(at), by(at + 1),
                             sigma(at + 1))
               : "elsewhere";
}

std::string by_k1(const CameraChange& change, Eigen::Index at, bool sized) {
  return sized ? fmt::format(" (k1 by {:+.3f} ± {:.3f})", change.by(at), change.sigma(at)) : "";
}

/// Those of several parameters that are more than three standard deviations.
std::string listed(const CameraChange& change, bool sized) {
  std::string list;
  const auto add = [&](const std::string& text) { list += (list.empty() ? "" : ", ") + text; };
  const auto is = [&](Eigen::Index k) { return std::abs(change.by(k)) > 3 * change.sigma(k); };
  if (is(0)) add("principal distance " + longer(change.by(0), change.sigma(0), sized));
  if (is(1) || is(2)) add("principal point " + elsewhere(change, 1, sized));
  if (is(3) || is(4)) add("another distortion" + by_k1(change, 3, sized));
  return list;
}

std::string what_changed(const CameraChange& change, bool sized) {
  const std::string point = "the principal point lies ";
  switch (change.what) {
    case What::focus:
      return "the principal distance is " + longer(change.by(0), change.sigma(0), sized) + ": focus or zoom";
    case What::aspect:
      return "fx is " + longer(change.by(0), change.sigma(0), sized) + " against fy: pictures that a program stretched";
    case What::principal_point:
      return point + elsewhere(change, 0, sized) +
             (change.or_turned     ? ": pictures that a program turned by 180 degrees, cropped or moved"
              : change.or_mirrored ? ": pictures that a program mirrored, cropped or moved"
                                   : ": pictures that a program cropped or moved") +
             ", a stabiliser, or a board that was bent otherwise";
    case What::distortion:
      return "the distortion is another" + by_k1(change, 0, sized) +
             ": another lens or setting of it, pictures that a program changed, or a board that was bent otherwise";
    case What::undistorted:
      return "the distortion is gone: pictures that a program freed of it";
    case What::turned:
      return point + elsewhere(change, 0, sized) + ": pictures that a program turned by 180 degrees";
    case What::several: {
      const std::string list = listed(change, sized);
      return "the camera is another" + (list.empty() ? "" : " (" + list + ")") +
             ": another body or lens, a zoom, or pictures that a program changed";
    }
  }
  return "";
}

}  // namespace

std::string in_words(const CameraChange& change, const CameraEvidence& evidence) {
  const std::string parts =
      change.split_is_clear
          ? where(change, evidence)
          : "in part of the photographs, which they do not tell clearly (most likely " + where(change, evidence) + ")";
  if (change.split == Split::upside_down)
    return parts + " the principal point lies " + elsewhere(change, 0, evidence.object_is_known) +
           ": pictures that a program turned by 180 degrees, or a board or tags that are not as the model has them";
  if (change.or_place)
    return parts +
           " the photographs tell another camera, and they were taken place after place in that order: either the "
           "camera "
           "changed, or the board or the tags are not as the model has them";
  if (change.what_is_clear) return parts + " " + what_changed(change, evidence.object_is_known);
  std::string causes;
  for (const auto& [what, probability] : change.causes)
    if (probability > 0.05 && what != What::several) causes += (causes.empty() ? "" : " or ") + name_of(what);
  return parts + " the camera is another; what of it changed these photographs do not tell" +
         (causes.empty() ? "" : " (" + causes + ")");
}

std::string in_words(const EmpiricalCovariance& empirical, const std::vector<Scatter>& causes) {
  // Sound photographs scatter by chance, too: 20 of them by 1.4 times in the mean, as no direction counts less than 1.
  const double told = causes.empty() ? 3 : 1.5;
  if (!empirical.judged || !(empirical.factor > told)) return "";
  std::string words = fmt::format(
      "the {} photographs scatter {:.1f} times as far as their corners allow: the standard deviations of the "
      "camera are made of that scatter",
      empirical.photographs, empirical.factor);
  std::string list;
  const auto add = [&](const std::string& text) { list += (list.empty() ? "" : "; and of ") + text; };
  for (const Scatter& cause : causes) switch (cause.kind) {
      case Strengths::focus:
        add(
            fmt::format("a principal distance that differs by {:.2f} % rms from photograph to photograph (an "
                        "autofocus, a zoom, or photographs of another camera among them)",
                        100 * cause.rms));
        break;
      case Strengths::principal_point:
        add(
            fmt::format("a principal point that moves by {:.1f} px rms from photograph to photograph (a stabiliser, or "
                        "a lens that is loose: switch it off; or pictures of which a program turned some by 180 "
                        "degrees)",
                        cause.rms));
        break;
      case Strengths::rows:
        add(cause.or_point
                ? "rows that are read one after another while the camera moves, or of a principal point that moves (a "
                  "rolling shutter, a stabiliser, or pictures of which a program turned some by 180 degrees)"
                : fmt::format("rows read one after another while the camera moves, by {:.1f} px rms from the first to "
                              "the last (a rolling shutter: hold the camera still)",
                              cause.rms));
        break;
      case Strengths::place:
        add("places: photographs from one side tell another camera than those from the other (a board or tags that are "
            "not as the model has them, or a lens that is not)");
        break;
      default:
        break;
    }
  constexpr double much = 1.3;
  if (std::max(empirical.by_order, empirical.by_place) > much)
    words += empirical.by_order > empirical.by_place
                 ? fmt::format(" (of that {:.1f} times because photographs that follow one another err alike)",
                               empirical.by_order)
                 : fmt::format(" (of that {:.1f} times because photographs from places near to each other err alike)",
                               empirical.by_place);
  return words + (list.empty() ? ". None of the causes that are tried stands out; tags or a board that are bent, and "
                                 "photographs of which a "
                                 "program enlarged some, are not among them"
                               : ". It is that of " + list);
}

double hidden_focus_change(const CameraTruth& truth) {
  const auto& parameters = truth.evidence.parameters;
  const auto fx = std::find(parameters.begin(), parameters.end(), 0) - parameters.begin();
  if (!truth.empirical.judged || !(truth.focal_length > 0) || fx == std::ssize(parameters)) return 0;
  // Between halves fx has twice the standard deviation that it has of all; the odds asked for (150 to 1, against a
  // change of any plausible size) need four of these.
  constexpr double of_halves = 2, asked_for = 4;
  return of_halves * asked_for * std::sqrt(truth.empirical.written(fx, fx)) / truth.focal_length;
}

std::vector<std::string> warnings_of(const CameraTruth& truth) {
  if (truth.change) return {in_words(*truth.change, truth.evidence)};
  if (const int n = truth.empirical.photographs; n > 0 && n < 3 && !truth.evidence.parameters.empty())
    return {fmt::format(
        "how {} scatter{} cannot be told: the standard deviations of the camera are those of the corners alone, which "
        "the scatter of photographs exceeds 1.1 to 7 times",
        n == 1 ? "one photograph" : "two photographs", n == 1 ? "s" : "")};
  const std::string scatter = in_words(truth.empirical, truth.scatter);
  const double hidden = hidden_focus_change(truth);
  constexpr double worth_telling = 0.02;
  if (!scatter.empty() && hidden > 0)
    return {scatter +
            fmt::format(". A focus or zoom that changed among them by less than about {:.2g} % is hidden by it",
                        100 * hidden)};
  if (!scatter.empty()) return {scatter};
  if (hidden < worth_telling) return {};
  return {
      fmt::format("the photographs do not tell whether focus or zoom changed among them by less than about {:.2g} %",
                  100 * hidden)};
}

}  // namespace plumbline::markers
