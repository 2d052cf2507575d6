#include "photo/bundle/parts.hpp"

#include <numeric>

#include "base/text/words.hpp"
#include "least_squares/problem/defects.hpp"

namespace plumbline::bundle {
namespace {

/// Disjoint sets with path halving.
class Sets {
 public:
  explicit Sets(std::size_t count) : parent_(count) { std::iota(parent_.begin(), parent_.end(), std::size_t{0}); }
  std::size_t of(std::size_t i) {
    for (; parent_[i] != i; i = parent_[i]) parent_[i] = parent_[parent_[i]];
    return i;
  }
  void join(std::size_t a, std::size_t b) { parent_[of(b)] = of(a); }

 private:
  std::vector<std::size_t> parent_;
};

}  // namespace

std::vector<std::vector<int>> image_parts(const Problem& problem) {
  const std::size_t points = problem.images.size(), plates = points + problem.points.size();
  Sets sets(plates + problem.plates.size());
  const auto body = [&](const Ref& ref) {
    return static_cast<std::size_t>(ref.index) + (ref.kind == Kind::image   ? 0
                                                  : ref.kind == Kind::point ? points
                                                                            : plates);
  };
  for (int i = 0; i < static_cast<int>(points); ++i)
    sets.join(static_cast<std::size_t>(i), static_cast<std::size_t>(problem.pose_of(i)));
  for (const auto& o : problem.image_points) sets.join(static_cast<std::size_t>(o.image), body({Kind::point, o.point}));
  for (const auto& o : problem.image_tags) sets.join(static_cast<std::size_t>(o.image), body({Kind::plate, o.plate}));
  for (const auto& d : problem.distances) sets.join(body(d.from), body(d.to));
  std::vector<std::vector<int>> parts;
  std::vector<std::size_t> number(plates + problem.plates.size(), problem.images.size());
  for (std::size_t i = 0; i < problem.images.size(); ++i) {
    std::size_t& part = number[sets.of(i)];
    if (part == problem.images.size()) part = parts.size(), parts.emplace_back();
    parts[part].push_back(static_cast<int>(i));
  }
  return parts;
}

std::string words_of_parts(const Problem& problem) {
  const auto parts = image_parts(problem);
  if (parts.size() < 2) return {};
  constexpr std::size_t most = 4;
  std::vector<std::string> words;
  for (std::size_t k = 0; k < std::min(parts.size(), most); ++k) {
    const auto name = [&](int i) { return problem.images[i].name; };
    const auto& part = parts[k];
    words.push_back(part.size() == 1 ? name(part[0])
                                     : name(part.front()) + " … " + name(part.back()) + " (" +
                                           std::to_string(part.size()) + " images)");
  }
  if (parts.size() > most) words.push_back(std::to_string(parts.size() - most) + " others");
  return "the block falls into " + std::to_string(parts.size()) +
         " parts that share no tag and no point: " + text::enumerate(words) +
         "; take photographs that show both sides of the gap, or give each part control";
}

}  // namespace plumbline::bundle
