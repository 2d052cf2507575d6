// Settings of a bench that contradict each other, and settings that hold nowhere.
//
// A cell stands under the names of all that was set for it. Where command line, seeds, scenario, matrix and
// alternatives set one key to different values, only one of them holds, and the cell would stand under a name that it
// has nothing of.
#pragma once

#include <filesystem>
#include <map>
#include <string>
#include <utility>

#include "runtime/sweep/sweep_places.hpp"
#include "runtime/sweep/sweep_settings.hpp"

namespace plumbline::runtime {

class SettingConflicts {
 public:
  SettingConflicts(const SweepFile& file, const Overrides& overrides) : file_(file), overrides_(overrides) {}

  /// What holds for a combination, as it is put together.
  struct Held {
    std::map<std::string, std::pair<std::string, std::string>> around;  ///< by key: by whom it is set, and to what
    std::map<std::string, std::string> groups;                          ///< by key: the group whose alternative sets it
  };

  /// Command line, seeds, scenario and variables, of which each is noted where it sets what another one has set.
  Held around(const Combination& way);

  /// An alternative's overrides and pipeline; throws std::runtime_error where another group sets one of them.
  void add(Held& held, const std::string& group, const SweepAlternative& choice);

  /// An alternative of a list of kinds, which fills `node`; throws like add().
  void add_kind(Held& held, const std::string& group, const SweepAlternative& choice, const std::string& node);

  /// Variables that feed parameters of which each is set by somebody else, too: the cells would stand under their names
  /// and have nothing of them. `all` are the combination's overrides in order.
  void add_unreached(const Combination& way, const std::filesystem::path& pipeline, const Overrides& all,
                     SettingReach& reach);

  /// Throws InvalidPipeline with all that was noted, by its place.
  void refuse() const;

 private:
  void note(const Held& held, const std::string& text, Position at = {});
  std::map<std::string, std::string> setters_of(const Combination& way) const;

  const SweepFile& file_;
  const Overrides& overrides_;
  std::map<std::string, Problem> conflicts_;  ///< by "KEY=VALUE" and who set the key otherwise
};

/// How often each setting stood in a combination, and how often it was what was wrong there: what is wrong in every
/// combination is a slip of the pen, what is wrong in some is shown with their cells.
class SettingTries {
 public:
  SettingTries(const SweepFile& file, const Overrides& overrides) : file_(file), overrides_(overrides) {}

  /// `error` is null where the combination made a pipeline.
  void count(const Overrides& overrides, const InvalidPipeline* error);

  /// Throws InvalidPipeline with the place of each setting that holds in no combination.
  void refuse_what_never_holds() const;

 private:
  struct Tried {
    size_t times = 0, wrong = 0;
    std::string message;
  };
  bool was_written(const std::string& text) const;

  const SweepFile& file_;
  const Overrides& overrides_;
  std::map<std::string, Tried> tried_;  ///< by "KEY=VALUE"
};

}  // namespace plumbline::runtime
