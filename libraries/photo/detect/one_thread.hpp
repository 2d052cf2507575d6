// OpenCV without threads of its own.
#pragma once

#include <opencv2/core/utility.hpp>

namespace plumbline::detect {

/// Images are the unit of parallel work. Only once: setting the number ends the threads that another image may be
/// working with at that moment.
inline void keep_opencv_to_one_thread() {
  [[maybe_unused]] static const bool done = [] {
    cv::setNumThreads(1);
    return true;
  }();
}

}  // namespace plumbline::detect
