// What a Blob holds on to; for the store's own files.
#pragma once

#include <sys/mman.h>

#include <vector>

#include "runtime/store/store.hpp"

namespace plumbline::runtime {

struct Blob::Memory {
  std::vector<unsigned char> owned;
  void* mapped = nullptr;
  size_t size = 0;
  Memory() = default;
  explicit Memory(std::vector<unsigned char> bytes) : owned(std::move(bytes)), size(owned.size()) {}
  Memory(const Memory&) = delete;
  Memory& operator=(const Memory&) = delete;
  ~Memory() {
    if (mapped) munmap(mapped, size);
  }
  const void* data() const { return mapped ? mapped : owned.data(); }
};

}  // namespace plumbline::runtime
