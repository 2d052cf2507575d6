// evaluate.epochs: this campaign against the one before.
#pragma once

#include "artifacts/as_built_changes.hpp"
#include "artifacts/design.hpp"
#include "artifacts/deviation.hpp"
#include "artifacts/file.hpp"
#include "plumbline/node.hpp"

namespace plumbline::judgement {

struct EvaluateEpochs : Node {
  static constexpr Info info{
      "evaluate.epochs", "", 7,
      "What was mended, opened again and moved since the campaign before, and the record for the "
      "next one"};
  In<Deviation> deviation{"deviation", frame("frame=?F"), "as-built minus design, judged"};
  Optional<Design> design{"design", frame("frame=?F"),
                          "the design: panels and joints that it has no more are closed; without it they stay open"};
  Param<FilePath> before{"before", FilePath{},
                         "as_built.json that the campaign before left; none: nothing is compared"};
  Param<std::string> epoch{"epoch", "", "name of this campaign, such as 2026-05"};
  Out<AsBuiltChanges> changes{"changes", frame("frame=?F"), "what became of every anchor and panel"};
  Out<Deviation> judgement{"judgement", frame("frame=?F"),
                           "the deviation, with what was open before and was not measured again as not judged: what is "
                           "shown and written is this"};
  Out<File> record{"record", "as_built.json: what the next campaign takes as 'before'"};

  void run(Context& context) override;
};

}  // namespace plumbline::judgement
