#include "partial_tiles.hpp"

#include <unistd.h>

#include <cstring>
#include <filesystem>
#include <fstream>
#include <string_view>

#include "base/text/whole_file.hpp"

namespace plumbline::surface {
namespace {

constexpr std::uint64_t kMagic = 0x31454c4954424c50;  // "PLBTILE1"

std::uint64_t check_of(const std::string& bytes) {  // FNV-1a
  std::uint64_t hash = 0xcbf29ce484222325;
  for (const char c : bytes) hash = (hash ^ static_cast<unsigned char>(c)) * 0x100000001b3;
  return hash;
}

template <typename T>
void put(std::string& bytes, const T* values, size_t count) {
  bytes.append(reinterpret_cast<const char*>(values), count * sizeof(T));
}

/// Takes values from the front; false if there are not enough.
template <typename T>
bool take(std::string_view& bytes, T* values, size_t count) {
  if (bytes.size() / sizeof(T) < count) return false;
  std::memcpy(static_cast<void*>(values), bytes.data(), count * sizeof(T));
  bytes.remove_prefix(count * sizeof(T));
  return true;
}

bool unpack_tile(std::string_view bytes, FacetTile& tile) {
  std::uint64_t sizes[3];
  if (!take(bytes, tile.measured.centre.data(), 3) || !take(bytes, tile.place.data(), 2) ||
      !take(bytes, tile.outcomes.data(), tile.outcomes.size()) || !take(bytes, sizes, 3))
    return false;
  if (sizes[0] > bytes.size() / sizeof(MeasuredPoint) || sizes[1] > 16 || sizes[2] > bytes.size()) return false;
  tile.measured.points.resize(sizes[0]);
  tile.sensitivity.resize(static_cast<Eigen::Index>(sizes[1]), static_cast<Eigen::Index>(sizes[2]));
  return take(bytes, tile.measured.points.data(), sizes[0]) &&
         take(bytes, tile.sensitivity.data(), sizes[1] * sizes[2]) && bytes.empty();
}

}  // namespace

PartialTiles::PartialTiles(const Context& context) {
  std::error_code error;
  try {
    const std::string path = context.resolve("partial:");
    if (std::filesystem::is_directory(path, error)) folder_ = path;
  } catch (const std::runtime_error&) {  // a host that keeps nothing
  }
}

std::string PartialTiles::path(size_t number) const { return folder_ + "/" + std::to_string(number) + ".tile"; }

bool PartialTiles::has(size_t number) const {
  std::error_code error;
  return !folder_.empty() && std::filesystem::is_regular_file(path(number), error);
}

bool PartialTiles::load(size_t number, FacetTile& tile) {
  if (folder_.empty()) return false;
  if (!has(number)) return false;
  const std::string bytes = text::read_whole(path(number));
  std::string_view rest = bytes;
  std::uint64_t head[2];
  FacetTile read;
  if (!take(rest, head, 2) || head[0] != kMagic || head[1] != check_of(std::string(rest)) || !unpack_tile(rest, read))
    return false;
  tile = std::move(read);
  ++found_;
  return true;
}

void PartialTiles::save(size_t number, const FacetTile& tile) const {
  if (folder_.empty()) return;
  std::string content;
  put(content, tile.measured.centre.data(), 3), put(content, tile.place.data(), 2);
  put(content, tile.outcomes.data(), tile.outcomes.size());
  const std::uint64_t sizes[3] = {tile.measured.points.size(), static_cast<std::uint64_t>(tile.sensitivity.rows()),
                                  static_cast<std::uint64_t>(tile.sensitivity.cols())};
  put(content, sizes, 3);
  put(content, tile.measured.points.data(), tile.measured.points.size());
  put(content, tile.sensitivity.data(), static_cast<size_t>(tile.sensitivity.size()));
  std::string bytes;
  const std::uint64_t head[2] = {kMagic, check_of(content)};
  put(bytes, head, 2);
  const std::string written = path(number) + "." + std::to_string(getpid());
  std::ofstream file(written, std::ios::binary | std::ios::trunc);
  file << bytes << content;
  file.close();
  std::error_code error;
  if (file) std::filesystem::rename(written, path(number), error);
  if (!file || error) std::filesystem::remove(written, error);
}

}  // namespace plumbline::surface
