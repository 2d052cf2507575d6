// The words in which a node declares itself: what it is, bounds, choices, frames, paths.
#pragma once

#include <cstdint>
#include <limits>
#include <string>
#include <vector>

namespace plumbline {

struct Info {
  const char* kind;
  const char* role;
  uint32_t version;
  const char* summary;
  bool deterministic = true;
  const char* lacks = "";  ///< what its role promises and it does not give: "covariance"
};

/// Frame binding of a port: "frame=?S" binds the type's parameter `frame` to the variable S, "frame=building" to a
/// name.
struct Frames {
  const char* text = "";
};
constexpr Frames frame(const char* text) { return {text}; }

struct Bounds {
  double minimum = -std::numeric_limits<double>::infinity();
  double maximum = std::numeric_limits<double>::infinity();
};
constexpr Bounds between(double minimum, double maximum) { return {minimum, maximum}; }
constexpr Bounds at_least(double minimum) { return {minimum, std::numeric_limits<double>::infinity()}; }

struct Choices {
  std::vector<const char*> values;
};
template <typename... Text>
Choices one_of(Text... texts) {
  return {{texts...}};
}

/// In place of a default: the pipeline must give the parameter.
struct Required {};
inline constexpr Required required{};

/// Path parameters; the host makes them absolute and puts the content they name into the cache key.
struct FilePath {
  std::string path;
};
struct FolderPath {
  std::string path;
};

}  // namespace plumbline
