// bim.write_ids: what the as-built file has to hold, for whoever receives it.
#pragma once

#include "artifacts/design.hpp"
#include "artifacts/deviation.hpp"
#include "artifacts/file.hpp"
#include "plumbline/node.hpp"

namespace plumbline::ifc {

struct WriteIds : Node {
  static constexpr Info info{"bim.write_ids", "", 1,
                             "Information Delivery Specification (IDS 1.0) that the as-built IFC fulfils: a check for "
                             "whoever receives it"};
  In<Deviation> deviation{"deviation", frame("frame=?F"), "as-built minus design, judged"};
  In<plumbline::Design> design{"design", frame("frame=?F"), "what bim.read_ifc read"};
  Param<std::string> epoch{"epoch", "", "name of the campaign, as in bim.write_ifc"};
  Param<bool> must_pass{
      "must_pass", false,
      "also ask that every anchor and panel passes: acceptance of the work, which an as-built file with "
      "failures does not fulfil"};
  Out<File> out{"file", "asbuilt.ids"};

  void run(Context& context) override;
};

}  // namespace plumbline::ifc
