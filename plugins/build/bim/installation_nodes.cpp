#include "installation_nodes.hpp"

#include "artifacts.hpp"
#include "artifacts/file_artifact.hpp"
#include "building/ifc/installation_bcf.hpp"
#include "building/ifc/installation_ifc.hpp"
#include "design_file.hpp"
#include "instant.hpp"

namespace plumbline::ifc {

void WriteInstallation::run(Context& context) {
  const auto index = index_of(*file, context);
  const AsBuiltIfc result =
      write_installation(*index, from_artifact(design.unpack()), plan.unpack(), state.unpack(), {*epoch, *timestamp});
  for (const std::string& warning : result.warnings) context.warn(warning);
  const auto folder = out.make_folder();
  const std::string path = folder.path + "/as_built.ifc";
  write_enriched(*index, result, path);
  out.commit(file_reference(*file_name, "application/x-step", folder.uri + "/as_built.ifc", context.digest(path)));
}

void WriteInstallationBcf::run(Context& context) {
  BcfOptions options;
  options.project_guid = design->project_guid()->str();
  options.author = *author, options.assigned_to = *assigned_to;
  if (!date->empty()) {
    const auto instant = instant_of(*date);
    if (!instant)
      throw std::runtime_error("parameter 'date' is '" + *date + "', expected a date such as 2026-05-12T10:30:00");
    options.date = instant->text;
  } else {
    context.warn("the topics are dated 1970: 'date' says when they were written");
  }
  FileT to;
  to.name = "installation.bcf", to.media_type = "application/zip";
  const std::string bytes = write_installation_bcf(plan.unpack(), state.unpack(), options);
  to.content.assign(bytes.begin(), bytes.end());
  out.commit(to);
}

}  // namespace plumbline::ifc
