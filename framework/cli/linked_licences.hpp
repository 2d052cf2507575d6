// Libraries under a licence that asks more of who passes a plugin on than the plugin's own does.
#pragma once

#include <string>
#include <vector>

#include "runtime/plugins/registry.hpp"

namespace plumbline::cli {

struct LinkedLicence {
  std::string library;  ///< "libcholmod.so.3"
  std::string licence;  ///< SPDX
};

/// Of the libraries that a plugin was linked with, also by others of them, those under the GPL. NOTICE.md lists all.
std::vector<LinkedLicence> copyleft_libraries(const runtime::Plugin& plugin);

/// "loads libcholmod.so.3 (GPL-2.0-or-later): who passes it on ..."; empty without any.
std::string licences_in_words(const runtime::Plugin& plugin);

}  // namespace plumbline::cli
