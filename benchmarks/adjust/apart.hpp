// An engine in a process of its own: what it takes of processor and memory is nobody else's, and it can be ended.
#pragma once

#include <functional>

namespace plumbline {

struct Taken {
  double seconds = 0;    ///< of the processor, with programs it started
  double megabytes = 0;  ///< peak, of the largest process among it and those
  bool ended = false;    ///< of itself and without an error; what it has to tell it has printed
};

/// Runs `work` in a copy of this process, which ends when it has had `limit` seconds of the processor. An exception's
/// text is printed behind `name`, and so is what ended it.
Taken run_apart(const char* name, double limit, const std::function<void()>& work);

}  // namespace plumbline
