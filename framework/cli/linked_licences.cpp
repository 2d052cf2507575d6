#include "linked_licences.hpp"

#include <array>
#include <string_view>
#include <utility>

namespace plumbline::cli {
namespace {

// As in NOTICE.md, which tests/integration/licences holds against the programs and against this list.
constexpr std::array<std::pair<std::string_view, std::string_view>, 6> kCopyleft = {{
    {"libcholmod", "GPL-2.0-or-later"},
    {"libspqr", "GPL-2.0-or-later"},
    {"libumfpack", "GPL-2.0-or-later"},
    {"libjbig", "GPL-2.0-or-later"},
    {"libexiv2", "GPL-2.0-or-later"},
    {"libgsl", "GPL-3.0-or-later"},
}};

}  // namespace

std::vector<LinkedLicence> copyleft_libraries(const runtime::Plugin& plugin) {
  std::vector<LinkedLicence> found;
  for (const std::string& id : plugin.linked_build_ids) {
    const std::string library = id.substr(0, id.find(':'));
    for (const auto& [name, licence] : kCopyleft)
      if (library.starts_with(std::string(name) + ".")) found.push_back({library, std::string(licence)});
  }
  return found;
}

std::string licences_in_words(const runtime::Plugin& plugin) {
  std::string text;
  for (const LinkedLicence& l : copyleft_libraries(plugin))
    text += (text.empty() ? "loads " : ", ") + l.library + " (" + l.licence + ")";
  return text.empty() ? text : text + ": who passes it on with that does so under that licence; see NOTICE.md";
}

}  // namespace plumbline::cli
