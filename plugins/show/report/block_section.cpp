// The image block behind the model: groups of observations, images, what was rejected or left out.
#include <algorithm>
#include <cmath>
#include <map>

#include "base/text/words.hpp"
#include "show/report/format.hpp"
#include "show/report/plot.hpp"
#include "show/report/sections.hpp"

namespace plumbline::report {

namespace {

void write_groups(Markup& html, const BlockT& block) {
  Scope wide(html, "div", {{"class", "wide"}});
  Scope table(html, "table");
  table_head(html, {"Observations", "Number", "Redundancy", "Weighted squares", "Variance factor"});
  Scope body(html, "tbody");
  for (const auto& group : block.groups)
    table_row(html, {group->name, std::to_string(group->observations), fixed(group->redundancy, 1),
                     fixed(group->weighted_sum_of_squares, 1), fixed(group->variance_factor, 2)});
}

void write_tests(Markup& html, const BlockT& block) {
  if (block.tests.empty()) return;
  Scope wide(html, "div", {{"class", "wide"}});
  Scope table(html, "table");
  table_head(html, {"Test of the image block", "Test value", "At most", "Result"});
  Scope body(html, "tbody");
  for (const auto& test : block.tests)
    table_row(html, {test->group, fixed(test->variance_factor, 2), fixed(test->limit, 2),
                     test->passed ? "passed" : "failed: " + test->words});
}

void write_images(Markup& html, const BlockT& block) {
  Scope wide(html, "div", {{"class", "wide"}});
  Scope table(html, "table", {{"class", "sortable"}});
  table_head(html, {"Image", "Tags", "RMS [px]", "Largest |w|", "Smallest redundancy"});
  Scope body(html, "tbody");
  for (const auto& image : block.images)
    table_row(html, {image->path, std::to_string(image->tags), fixed(image->rms, 3), fixed(image->largest_w, 1),
                     fixed(image->smallest_redundancy_number, 2)});
}

/// Value and standard deviation, with two digits of this.
std::string with_sigma(const InteriorParameterT& parameter, bool pixels) {
  if (!parameter.estimated || !(parameter.sigma > 0))
    return fixed(parameter.value, pixels ? 2 : 5) + (parameter.name[0] == 'Z' ? "" : " (held)");
  const int digits = std::clamp(1 - static_cast<int>(std::floor(std::log10(parameter.sigma))), 0, 9);
  return fixed(parameter.value, digits) + " ± " + fixed(parameter.sigma, digits);
}

/// One column a camera.
void write_cameras(Markup& html, const BlockT& block) {
  std::vector<std::string> cameras, names;
  std::map<std::pair<std::string, std::string>, std::string> cells;
  for (const auto& parameter : block.interior_orientation) {
    if (!parameter->image.empty()) continue;
    const std::string &name = parameter->name, &camera = parameter->camera;
    if (std::find(cameras.begin(), cameras.end(), camera) == cameras.end()) cameras.push_back(camera);
    if (std::find(names.begin(), names.end(), name) == names.end()) names.push_back(name);
    cells[{camera, name}] = with_sigma(*parameter, name[0] == 'f' || name[0] == 'c');
  }
  if (cameras.empty()) return;
  Scope wide(html, "div", {{"class", "wide"}});
  Scope table(html, "table");
  std::vector<Cell> head = {"Interior orientation"};
  for (const std::string& camera : cameras) head.push_back(camera.empty() ? std::string("camera") : camera);
  table_head(html, head);
  Scope body(html, "tbody");
  for (const std::string& name : names) {
    std::vector<Cell> row = {name + (name[0] == 'f' || name[0] == 'c' ? " [px]" : "")};
    for (const std::string& camera : cameras) row.push_back(cells[{camera, name}]);
    table_row(html, row);
  }
}

}  // namespace

void write_block(Markup& html, const ReportInput& input) {
  if (!input.block && input.images.empty()) return;
  Scope part(html, "section", {{"id", "block"}});
  html.element("h2", "Image block");
  if (!input.images.empty()) {
    Scope table(html, "table", {{"class", "facts"}});
    Scope body(html, "tbody");
    for (const auto& [name, value] : input.images) {
      Scope row(html, "tr");
      html.element("th", {{"scope", "row"}}, name);
      html.element("td", value);
    }
  }
  if (!input.block) return;
  const BlockT& block = *input.block;
  html.element(
      "p", "Adjusted with datum “" + block.datum + "”, weights by " + block.weighting +
               (std::isfinite(block.lambda) ? ", λ " + fixed(block.lambda, 1) + " px²/m², which believes σ " +
                                                  mm_unit(block.lambda_control_sigma, 2) + " of a surveyed coordinate"
                                            : "") +
               "; σ0 " + fixed(block.statistics->sigma0, 3) + " with " +
               std::to_string(block.statistics->degrees_of_freedom) + " degrees of freedom, " +
               std::to_string(block.statistics->observations) + " observations, " +
               std::to_string(block.statistics->unknowns) + " unknowns; variance factor of the images before scaling " +
               fixed(block.image_variance_factor, 2) + ".");
  write_groups(html, block);
  write_tests(html, block);
  write_cameras(html, block);
  if (block.rejected.empty()) {
    html.element("p", "No sighting of a tag was rejected.");
  } else {
    std::vector<std::string> rejected;
    for (const auto& item : block.rejected) rejected.push_back(item->anchor + " in " + item->path);
    html.element("p", count(static_cast<long>(rejected.size()), "sighting of a tag was", "sightings of tags were") +
                          " rejected by its tests: " + text::join(rejected) + ".");
  }
  if (!block.left_out.empty()) html.element("p", "Left out: " + text::join(block.left_out) + ".");
  if (!block.weak_datum.empty()) html.element("p", "Weak geometry: " + text::join(block.weak_datum) + ".");
  folded(html, count(static_cast<long>(block.images.size()), "image", "images"), [&] { write_images(html, block); });
}

}  // namespace plumbline::report
