// How a port binds the frame parameters of its type: "to=?T,from=survey".
#pragma once

#include <algorithm>
#include <string>
#include <utility>
#include <vector>

namespace plumbline::runtime {

/// {"to", "?T"}, {"from", "survey"}; an item without '=' has an empty value.
inline std::vector<std::pair<std::string, std::string>> split_frames(const std::string& text) {
  std::vector<std::pair<std::string, std::string>> frames;
  for (size_t at = 0; at < text.size();) {
    const size_t end = std::min(text.find(',', at), text.size());
    const std::string item = text.substr(at, end - at);
    const size_t equals = std::min(item.find('='), item.size());
    frames.emplace_back(item.substr(0, equals), equals < item.size() ? item.substr(equals + 1) : "");
    at = end + 1;
  }
  return frames;
}

inline bool is_frame_variable(const std::string& frame) { return !frame.empty() && frame[0] == '?'; }

}  // namespace plumbline::runtime
