// A ZIP archive as BIM offices send designs in: ifcZIP, one model in one archive; and the files of any other (PKWARE
// APPNOTE 6.3, parts 4.3.7 to 4.3.16; stored or deflated, neither encrypted nor larger than 4 GiB).
#pragma once

#include <optional>
#include <string>
#include <string_view>

namespace plumbline::step {

bool is_zip(std::string_view bytes);

/// The one file of the archive whose name ends in .ifc (else in .ifcxml or .xml), and that name; what macOS adds
/// (__MACOSX) is passed over. Throws std::runtime_error that says what was found: no such file (or several, by name),
/// an archive that is cut off, encrypted, split or of another method, a file that is more than 1000 times as large as
/// it is packed or above 2 GiB, a checksum that is wrong.
struct ZippedIfc {
  std::string name, content;
};
ZippedIfc unzip_ifc(std::string_view archive);

/// The file `name` of any archive, with '/' between folders; empty if there is none of that name. Throws
/// std::runtime_error as unzip_ifc() does.
std::optional<std::string> unzip_file(std::string_view archive, std::string_view name);

}  // namespace plumbline::step
