// Detectors that are free, kept between images: the decoding table of a family takes longer to build than an image to
// search.
#pragma once

#include <map>
#include <memory>
#include <mutex>
#include <vector>

#include "photo/detect/tag_detector.hpp"

namespace plumbline::detect {

/// Every call of with_detector() has a detector to itself, from any number of threads; there are never more detectors
/// of one kind than calls at the same time. What a detector finds does not depend on what it saw before, so the pool
/// has no influence on results.
class DetectorPool {
 public:
  /// `key` names the options: two different sets of options must have different keys.
  template <typename Work>
  auto with_detector(const std::string& key, const DetectorOptions& options, Work&& work) {
    std::unique_ptr<TagDetector> detector = take(key);
    if (!detector) detector = std::make_unique<TagDetector>(options);
    auto result = work(*detector);
    const std::lock_guard lock(mutex_);
    free_[key].push_back(std::move(detector));
    return result;
  }

 private:
  std::unique_ptr<TagDetector> take(const std::string& key) {
    const std::lock_guard lock(mutex_);
    auto& list = free_[key];
    if (list.empty()) return nullptr;
    auto detector = std::move(list.back());
    list.pop_back();
    return detector;
  }

  std::mutex mutex_;
  std::map<std::string, std::vector<std::unique_ptr<TagDetector>>> free_;
};

}  // namespace plumbline::detect
