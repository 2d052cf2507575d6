// Profiles of the instruments that the readings of a network name one by one.
#pragma once

#include <algorithm>
#include <map>
#include <string>
#include <vector>

#include "survey/model/instrument_profile.hpp"

namespace plumbline::survey {

/// By name, for AdjustOptions::instruments; `profile` and `profile_file` as of choose_profile(). A profile file has its
/// own; a profile chosen by name is meant for all; for "automatic" an instrument that is called as a built-in profile
/// has that one. What is not in the answer is adjusted with the profile of the whole.
inline std::map<std::string, InstrumentProfile> choose_instruments(const std::string& profile,
                                                                   const std::string& profile_file,
                                                                   const std::vector<std::string>& names) {
  if (!profile_file.empty()) return read_instruments(profile_file);
  std::map<std::string, InstrumentProfile> found;
  if (profile != "automatic") return found;
  const std::vector<const char*> known = profile_names();
  for (const std::string& name : names)
    if (std::find(known.begin(), known.end(), name) != known.end()) found[name] = built_in_profile(name);
  return found;
}

/// A sentence for each of `names` that has no profile of its own: it is adjusted with `whole`, that of the network.
inline std::vector<std::string> instruments_without_profile(const std::vector<std::string>& names,
                                                            const std::map<std::string, InstrumentProfile>& own,
                                                            const InstrumentProfile& whole) {
  std::vector<std::string> sentences;
  for (const std::string& name : names)
    if (!own.contains(name))
      sentences.push_back("the files name the instrument " + name + ": the profile " + whole.name +
                          " is used for it; give its own under `instruments` in a profile_file");
  return sentences;
}

}  // namespace plumbline::survey
