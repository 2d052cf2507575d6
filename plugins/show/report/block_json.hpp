// What the page of an image block reads from block.json; what is missing or of another type counts as not given.
#pragma once

#include <Eigen/Core>
#include <cmath>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

namespace plumbline::report::block_json {

using Json = nlohmann::ordered_json;

inline double number(const Json& object, const char* key) {
  return object.contains(key) && object[key].is_number() ? object[key].get<double>() : std::nan("");
}
inline std::string text(const Json& object, const char* key) {
  return object.contains(key) && object[key].is_string() ? object[key].get<std::string>() : "";
}
inline bool flag(const Json& object, const char* key) {
  return object.contains(key) && object[key].is_boolean() && object[key].get<bool>();
}
inline const Json& list(const Json& object, const char* key) {
  static const Json empty = Json::array();
  return object.contains(key) && object[key].is_array() ? object[key] : empty;
}
inline Eigen::Vector3d vector(const Json& object, const char* key) {
  const Json& v = list(object, key);
  if (v.size() != 3) return Eigen::Vector3d::Constant(std::nan(""));
  return {v[0].get<double>(), v[1].get<double>(), v[2].get<double>()};
}
inline std::vector<Eigen::Vector2d> pixels(const Json& object, const char* key) {
  std::vector<Eigen::Vector2d> result;
  for (const Json& p : list(object, key)) result.emplace_back(p.at(0).get<double>(), p.at(1).get<double>());
  return result;
}

}  // namespace plumbline::report::block_json
