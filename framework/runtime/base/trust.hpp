// Whom files are believed: a plugin runs with the rights of who starts the program, and a stored result is delivered as
// one's own. Both are believed only if nobody else could have put them there.
#pragma once

#include <filesystem>
#include <string>

namespace plumbline::runtime {

/// Why a file or folder is not to be believed, as a sentence with what to do; empty if it is. Believed is what belongs
/// to this user, to root or to whoever owns the program, in a folder of such an owner, where nobody else may write. A
/// group that is the user's own is nobody else; a folder with the sticky bit (/tmp) protects what is in it. All is
/// believed where PLUMBLINE_TRUST_OTHERS is set and not 0 (`--trust-others`).
std::string distrust(const std::filesystem::path& path);

}  // namespace plumbline::runtime
