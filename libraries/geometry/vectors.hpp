// Vectors of the compiler, not of the instruction set: what a processor lacks is done in halves, with the same bits.
#pragma once

#include <cmath>

#if defined(__SANITIZE_THREAD__) || defined(__SANITIZE_ADDRESS__) || !defined(__x86_64__)
#define PLUMBLINE_CLONES
#else
#define PLUMBLINE_CLONES __attribute__((target_clones("avx2", "default")))
#endif
#define PLUMBLINE_INLINE inline __attribute__((always_inline))

namespace plumbline {

#pragma GCC diagnostic ignored "-Wpsabi"  // everything that takes or returns one is inlined
typedef double V4 __attribute__((vector_size(32)));
typedef double V2 __attribute__((vector_size(16)));

template <typename V>
PLUMBLINE_INLINE V load(const double* from) {  // from any address
  V value;
  __builtin_memcpy(&value, from, sizeof value);
  return value;
}

template <typename V>
PLUMBLINE_INLINE void store(double* to, const V& value) {
  __builtin_memcpy(to, &value, sizeof value);
}

PLUMBLINE_INLINE double root(double v) { return std::sqrt(v); }
PLUMBLINE_INLINE double arc_tangent(double v) { return std::atan(v); }
PLUMBLINE_INLINE V4 root(const V4& v) { return V4{std::sqrt(v[0]), std::sqrt(v[1]), std::sqrt(v[2]), std::sqrt(v[3])}; }
PLUMBLINE_INLINE V4 arc_tangent(const V4& v) {
  return V4{std::atan(v[0]), std::atan(v[1]), std::atan(v[2]), std::atan(v[3])};
}

}  // namespace plumbline
