#include "build/evaluate/surface_errors_node.hpp"

#include <fmt/core.h>

#include "building/judgement/surface_errors.hpp"

namespace plumbline::judgement {

void EvaluateSurfaces::run(Context& context) {
  const SurfaceErrors errors = surface_errors(surfaces.unpack(), truth.unpack());
  for (const SurfaceErrorsOf& of : errors.of) {
    context.metric("rmse_" + of.quantity, of.rms, "m");
    context.metric("bias_" + of.quantity, of.bias, "m");
    context.metric("largest_" + of.quantity, of.largest, "m");
    context.metric(of.quantity + "_found", of.rms, "m");
    context.metric(of.quantity + "_predicted", of.predicted, "m");
    context.metric(of.quantity + "_nees", of.nees, "1");
    context.metric(of.quantity + "_freedom", of.freedom, "1");
    if (of.one_by_one)
      context.warn("the widths of joints say nothing of what they have in common: " + of.quantity +
                   "_nees takes each joint by itself, and errors that all share make it look untrue");
  }
  context.metric("panels_wanted", errors.wanted, "1");
  context.metric("panels_missing", errors.wanted - errors.measured, "1");
  context.metric("panels_invented", errors.invented, "1");
  context.metric("joints_beside_unmeasured", errors.joints_beside, "1");
  context.metric("joints_missing", errors.joints_wanted - errors.joints_measured, "1");
  context.metric("coverage", errors.coverage, "1");
  context.metric("beyond_3_sigma", errors.beyond_3_sigma, "1");
  std::string text = "where,quantity,found_mm,true_mm,error_mm,sigma_mm\n";
  for (const SurfaceError& one : errors.all)
    text += fmt::format("{},{},{:.4f},{:.4f},{:.4f},{:.4f}\n", one.where, one.quantity, 1e3 * one.found,
                        1e3 * one.truth, 1e3 * (one.found - one.truth), 1e3 * one.sigma);
  FileT file;
  file.name = "surface_errors.csv", file.media_type = "text/csv", file.content.assign(text.begin(), text.end());
  table.commit(file);
}

}  // namespace plumbline::judgement
