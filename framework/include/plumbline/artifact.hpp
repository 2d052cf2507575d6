// FlatBuffers as artifacts use it. Included before any generated header, because of the assertion below.
#pragma once

#include <stdexcept>

// Left to itself, FlatBuffers aborts in Debug when a required field is missing and writes an invalid buffer in Release.
#ifndef FLATBUFFERS_ASSERT
#define FLATBUFFERS_ASSERT(condition)                                                                         \
  do {                                                                                                        \
    if (!(condition)) throw std::logic_error("an artifact is not complete: FlatBuffers expects " #condition); \
  } while (false)
#endif
#include <flatbuffers/flatbuffers.h>

namespace plumbline {

/// Specialised by the generated header of every artifact: name, fingerprint, schema and the type of its object form.
template <typename Table>
struct artifact_traits;

}  // namespace plumbline
