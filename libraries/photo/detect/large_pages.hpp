#pragma once

#include <cstddef>

namespace plumbline::detect {

/// Asks for pages of 2 MB in memory that was reserved and not written yet. The first touch of each page of 4 KB costs
/// about as much as decoding the pixels that it holds. Advice: where the system has no such pages nothing happens.
void prefer_large_pages(void* memory, std::size_t bytes) noexcept;

}  // namespace plumbline::detect
