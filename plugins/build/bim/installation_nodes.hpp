// bim.write_installation and bim.write_installation_bcf: the state of an execution loop for BIM programs.
#pragma once

#include "artifacts/design.hpp"
#include "artifacts/file.hpp"
#include "artifacts/installation_plan.hpp"
#include "artifacts/loop_state.hpp"
#include "plumbline/node.hpp"

namespace plumbline::ifc {

struct WriteInstallation : Node {
  static constexpr Info info{
      "bim.write_installation", "", 1,
      "Writes what was set and hung into a copy of the design or as-built IFC: a property set and a "
      "task for each bracket and panel, in their order"};
  In<plumbline::File> file{"file", "the design IFC, or the as-built one of bim.write_ifc; its lines stay as they are"};
  In<plumbline::Design> design{"design", frame("frame=?F"), "what bim.read_ifc read from the design"};
  In<InstallationPlan> plan{"plan", frame("frame=?F"), "the plan of the last round"};
  In<LoopState> state{"state", frame("frame=?F"), "the state after it"};
  Param<std::string> epoch{"epoch", "",
                           "name of the round or campaign; several of different names can stand in one file"};
  Param<int64_t> timestamp{"timestamp", 0, "s", at_least(0),
                           "date of the additions since 1970; 0: the latest date of the file"};
  Param<std::string> file_name{"file_name", "as_built.ifc", "name of the file"};
  Out<plumbline::File> out{"file", "the IFC, by reference"};
  void run(Context& context) override;
};

struct WriteInstallationBcf : Node {
  static constexpr Info info{"bim.write_installation_bcf", "", 2,
                             "Issues of an execution loop in BCF 2.1: open for what a person is to look at, closed for "
                             "what was mended, with what the journal says as comments"};
  In<plumbline::Design> design{"design", frame("frame=?F"), "the design, for the ids"};
  In<InstallationPlan> plan{"plan", frame("frame=?F"), "the plan of the last round"};
  In<LoopState> state{"state", frame("frame=?F"), "the state after it"};
  Param<std::string> date{"date", "", "of the topics, ISO 8601; empty: 1970"};
  Param<std::string> author{"author", "plumbline", "of the topics"};
  Param<std::string> assigned_to{"assigned_to", "", "of the topics; empty: nobody"};
  Out<plumbline::File> out{"file", "installation.bcf"};
  void run(Context& context) override;
};

}  // namespace plumbline::ifc
