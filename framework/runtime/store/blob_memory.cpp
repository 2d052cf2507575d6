#include "runtime/store/blob_memory.hpp"

#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <mutex>
#include <new>

namespace plumbline::runtime {

namespace {

/// Pages of a file in memory, mapped for reading. What is written goes through the file, so that no address of this
/// process leads to it, and a new blob costs a call and not a change of protection.
class Chunk {
 public:
  static constexpr size_t usual_size = size_t{256} << 10, alignment = 16;

  explicit Chunk(size_t least)
      : size_(std::max(least, usual_size)), file_(memfd_create("plumbline-blobs", MFD_CLOEXEC)) {
    void* mapped = MAP_FAILED;
    if (file_ >= 0 && ftruncate(file_, static_cast<off_t>(size_)) == 0)
      mapped = mmap(nullptr, size_, PROT_READ, MAP_SHARED, file_, 0);
    if (mapped != MAP_FAILED) {
      start_ = static_cast<const unsigned char*>(mapped);
      return;
    }
    if (file_ >= 0) close(file_);
    throw std::bad_alloc();
  }
  ~Chunk() {
    munmap(const_cast<unsigned char*>(start_), size_);
    end_writing();
  }
  Chunk(const Chunk&) = delete;
  Chunk& operator=(const Chunk&) = delete;

  bool has_room_for(size_t bytes) const { return bytes <= size_ - used_; }
  /// What lies here stays; the descriptor goes, of which a process has a thousand.
  void end_writing() {
    if (file_ >= 0) close(file_);
    file_ = -1;
  }

  const void* add(const void* data, size_t bytes) {
    const auto* from = static_cast<const char*>(data);
    for (size_t done = 0; done < bytes;) {
      const ssize_t count = pwrite(file_, from + done, bytes - done, static_cast<off_t>(used_ + done));
      if (count < 0 && errno == EINTR) continue;
      if (count <= 0) throw std::bad_alloc();
      done += static_cast<size_t>(count);
    }
    const void* const place = start_ + used_;
    used_ = std::min(size_, used_ + (bytes + alignment - 1) / alignment * alignment);
    return place;
  }

 private:
  const size_t size_;
  int file_;
  const unsigned char* start_ = nullptr;
  size_t used_ = 0;
};

}  // namespace

std::shared_ptr<const void> read_only_copy(const void* data, size_t size) {
  if (size == 0) return nullptr;
  static std::mutex mutex;
  static auto* const current = new std::shared_ptr<Chunk>;  // never destroyed: blobs may outlive what is static
  const std::scoped_lock lock(mutex);
  if (!*current || !(*current)->has_room_for(size)) {
    auto fresh = std::make_shared<Chunk>(size);
    if (*current) (*current)->end_writing();
    *current = std::move(fresh);
  }
  return {*current, (*current)->add(data, size)};
}

}  // namespace plumbline::runtime
