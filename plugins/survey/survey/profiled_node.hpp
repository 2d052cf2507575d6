// What the nodes that need an instrument profile have in common.
#pragma once

#include "plumbline/node.hpp"
#include "survey/model/instrument_profile.hpp"
#include "survey/model/several_instruments.hpp"

namespace plumbline::survey {

struct ProfiledNode : Node {
  Param<std::string> profile{
      "profile", "automatic", choices(),
      "instrument profile for readings whose file gives no standard deviation; automatic: the one that the "
      "observations name, each file's own where they differ, or ics50_assumed"};
  Param<FilePath> profile_file{"profile_file", FilePath{},
                               "YAML file of a profile of your own, in place of `profile`; `instruments` in it are "
                               "those that the files name (STAR*NET's .INST)"};

 protected:
  /// Profiles of those that the observations name one by one.
  std::map<std::string, InstrumentProfile> further_instruments(const std::vector<std::string>& names) const {
    return choose_instruments(*profile, profile_file->path, names);
  }
  /// `instrument` as the observations name it, or ""; `remark`: what the user should know about the choice, or "".
  InstrumentProfile chosen_profile(const std::string& instrument, std::string& remark) const {
    // A file of one instrument names it once; `instruments` of a profile_file may have it all the same.
    const auto own = further_instruments({instrument});
    if (const auto found = own.find(instrument); !profile_file->path.empty() && found != own.end())
      return found->second;
    return choose_profile(*profile, profile_file->path, instrument, remark);
  }

 private:
  static Choices choices() {
    Choices result{{"automatic"}};
    for (const char* name : profile_names()) result.values.push_back(name);
    return result;
  }
};

}  // namespace plumbline::survey
