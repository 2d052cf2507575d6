// What a Blob holds on to; for the store's own files.
//
// Nodes read inputs where the store has them, and several nodes may read one blob. So it lies where this process can
// read and not write: a node that writes into its input ends there, by name, and changes nothing that another reads.
#pragma once

#include <sys/mman.h>

#include "runtime/store/store.hpp"

namespace plumbline::runtime {

/// A copy of the bytes in pages that cannot be written, beside those of other small blobs. Throws std::bad_alloc.
std::shared_ptr<const void> read_only_copy(const void* data, size_t size);

struct Blob::Memory {
  std::shared_ptr<const void> kept;
  void* mapped = nullptr;
  size_t size = 0;
  Memory() = default;
  Memory(const void* data, size_t bytes) : kept(read_only_copy(data, bytes)), size(bytes) {}
  Memory(const Memory&) = delete;
  Memory& operator=(const Memory&) = delete;
  ~Memory() {
    if (mapped) munmap(mapped, size);
  }
  const void* data() const { return mapped ? mapped : kept.get(); }
};

}  // namespace plumbline::runtime
