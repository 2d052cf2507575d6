#include "runtime/base/trust.hpp"

#include <grp.h>
#include <pwd.h>
#include <sys/stat.h>
#include <unistd.h>

#include <cstdlib>
#include <cstring>
#include <vector>

namespace plumbline::runtime {

namespace fs = std::filesystem;

namespace {

bool all_are_believed() {
  const char* set = std::getenv("PLUMBLINE_TRUST_OTHERS");
  return set && *set && std::strcmp(set, "0") != 0;
}

/// Who owns the program could have changed the program itself.
uid_t owner_of_program() {
  struct stat info {};
  return stat("/proc/self/exe", &info) == 0 ? info.st_uid : geteuid();
}

std::string user_name(uid_t user) {
  passwd entry{}, *found = nullptr;
  std::vector<char> buffer(4096);
  if (getpwuid_r(user, &entry, buffer.data(), buffer.size(), &found) == 0 && found) return found->pw_name;
  return "number " + std::to_string(user);
}

/// The private group that many systems give every user.
bool is_own_group(gid_t group) {
  struct group entry {};
  struct group* found = nullptr;
  std::vector<char> buffer(16384);
  if (group != getegid() || getgrgid_r(group, &entry, buffer.data(), buffer.size(), &found) != 0 || !found)
    return false;
  if (user_name(geteuid()) != found->gr_name) return false;
  for (char** member = found->gr_mem; *member; ++member)
    if (user_name(geteuid()) != *member) return false;
  return true;
}

std::string writable_by_everybody(const fs::path& path, const struct stat& info) {
  if (!(info.st_mode & S_IWOTH)) return "";
  return path.string() + " may be written by everybody on this machine; take the right away with: chmod o-w " +
         path.string();
}

/// Of a file or folder itself.
std::string problem_of(const fs::path& path) {
  struct stat info {};
  if (stat(path.c_str(), &info) != 0) return "";
  if (const std::string problem = writable_by_everybody(path, info); !problem.empty()) return problem;
  if (info.st_uid != geteuid() && info.st_uid != 0 && info.st_uid != owner_of_program())
    return path.string() + " belongs to the user " + user_name(info.st_uid) + "; copy it to a folder of your own";
  // What root lets a group write is the system's own decision.
  if ((info.st_mode & S_IWGRP) && info.st_uid != 0 && !is_own_group(info.st_gid))
    return path.string() + " may be written by a group of users; take the right away with: chmod g-w " + path.string();
  return "";
}

/// Of a folder above: who may rename what is in it could put something else there.
std::string problem_of_parent(const fs::path& path) {
  struct stat info {};
  if (stat(path.c_str(), &info) != 0 || (info.st_mode & S_ISVTX)) return "";
  return writable_by_everybody(path, info);
}

}  // namespace

std::string distrust(const fs::path& path) {
  if (all_are_believed()) return "";
  std::error_code error;
  const fs::path real = fs::weakly_canonical(path, error);
  std::string problem = problem_of(real);
  for (fs::path parent = real.parent_path(); problem.empty(); parent = parent.parent_path()) {
    problem = problem_of_parent(parent);
    if (parent == parent.parent_path()) break;
  }
  return problem.empty() ? "" : problem + ", or believe everybody with --trust-others (PLUMBLINE_TRUST_OTHERS=1)";
}

}  // namespace plumbline::runtime
