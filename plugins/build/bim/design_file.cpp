#include "design_file.hpp"

#include <sys/stat.h>

#include <mutex>

namespace plumbline::ifc {
namespace {

/// What tells that a file is still the one that was indexed: all that changes when it is written.
std::string identity_of(const std::string& path) {
  struct stat info {};
  if (stat(path.c_str(), &info) != 0) return {};
  std::string identity;
  for (const auto number :
       {static_cast<long long>(info.st_dev), static_cast<long long>(info.st_ino), static_cast<long long>(info.st_size),
        static_cast<long long>(info.st_mtim.tv_sec), static_cast<long long>(info.st_mtim.tv_nsec),
        static_cast<long long>(info.st_ctim.tv_sec), static_cast<long long>(info.st_ctim.tv_nsec)})
    identity += std::to_string(number) + ' ';
  return identity;
}

}  // namespace

std::shared_ptr<const step::File> index_of(const plumbline::File& file, const Context& context) {
  const std::string name = file.name()->str();
  if (!file.uri() || file.uri()->size() == 0) {
    const auto* content = file.content();
    return std::make_shared<const step::File>(step::File::view(
        {reinterpret_cast<const char*>(content->data()), content->size()}, name.empty() ? "design.ifc" : name));
  }
  const std::string path = context.resolve(file.uri()->str());
  const std::string key = identity_of(path) + name;
  static std::mutex mutex;
  static std::string last_key;
  static std::shared_ptr<const step::File> last;
  const std::lock_guard lock(mutex);
  if (!last || key != last_key) {
    last.reset();  // before the next one: two indices of large files at a time would be one too many
    last = std::make_shared<const step::File>(step::File::read(path, name));
    last_key = key;
  }
  return last;
}

}  // namespace plumbline::ifc
