#include "building/judgement/group_shifts.hpp"

#include <fmt/core.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <map>

#include "building/judgement/moderated_variance.hpp"
#include "geometry/median.hpp"
#include "geometry/statistics.hpp"

namespace plumbline::judgement {
namespace {

using Eigen::Index;
using Eigen::Vector3d;

constexpr std::size_t kFewest = 4;
constexpr double kLevel = 1e-3;
constexpr double kFollows = 4.685;  ///< in scatters: what is farther off follows something else (Tukey)
/// Below this a scatter is rounding [m].
constexpr double kSmallestScatter = 2e-5;

/// Directions in which anchors scatter alike: a facade may be rough out of its plane and true in height.
enum Kind : std::size_t { up, right, out, level, kinds };

struct Direction {
  Kind kind;
  Vector3d along;
  const char *positive, *negative;
};

struct Group {
  std::string kind, name, facade;
  int floor = 0, column = 0;
  std::vector<std::size_t> members;
  std::vector<Direction> directions;
};

/// What the members' deviations are along one direction.
struct Sample {
  std::vector<std::size_t> following;  ///< that stay together
  double mean = 0;
  SampleVariance scatter;  ///< of one of them
  double variance = 0;     ///< of the mean, with the moderated scatter
  double t = 0, critical = 0;
};

/// The frame that all members share, if it is confirmed and level.
const ifc::FacadeFrame* common_frame(const std::vector<GroupMember>& members, const std::vector<std::size_t>& of) {
  const ifc::FacadeFrame& first = members[of.front()].frame;
  for (const std::size_t i : of) {
    const ifc::FacadeFrame& frame = members[i].frame;
    if (!frame.confirmed || !frame.known() || std::abs(frame.out.z()) > 0.5 || frame.out.dot(first.out) < 0.99)
      return nullptr;
  }
  return &first;
}

std::vector<Direction> directions_of(const std::vector<GroupMember>& members, const std::vector<std::size_t>& of) {
  std::vector<Direction> all = {{up, Vector3d::UnitZ(), "high", "low"}};
  if (const ifc::FacadeFrame* frame = common_frame(members, of)) {
    all.push_back({out, frame->out, "too far out", "too far in"});
    all.push_back({right, frame->right, "too far to the right", "too far to the left"});
  } else {
    all.push_back({level, Vector3d::UnitX(), "too far in +x", "too far in −x"});
    all.push_back({level, Vector3d::UnitY(), "too far in +y", "too far in −y"});
  }
  return all;
}

constexpr const char* kBuilding = "building";

std::vector<Group> groups_of(const std::vector<GroupMember>& members, bool whole) {
  std::map<int, Group> floors, columns;
  std::map<std::string, Group> facades, batches, axes;
  std::map<std::pair<std::string, int>, Group> both;
  const auto put = [](auto& map, const auto& key, std::size_t i, const char* kind, const std::string& name,
                      int floor = 0) -> Group& {
    Group& group = map[key];
    group.kind = kind, group.name = name, group.floor = floor, group.members.push_back(i);
    return group;
  };
  for (std::size_t i = 0; i < members.size(); ++i) {
    const GroupMember& m = members[i];
    const std::string floor = "Floor " + std::to_string(m.floor);
    if (m.floor > 0) put(floors, m.floor, i, "floor", floor, m.floor);
    if (m.column > 0) put(columns, m.column, i, "column", "Column " + std::to_string(m.column)).column = m.column;
    if (!m.facade.empty()) put(facades, m.facade, i, "facade", "Facade " + m.facade).facade = m.facade;
    if (!m.axis.empty()) put(axes, m.axis, i, "axis", "Axis " + m.axis);
    if (!m.batch.empty()) put(batches, m.batch, i, "batch", "Print batch " + m.batch);
    if (!m.facade.empty() && m.floor > 0)
      put(both, std::pair(m.facade, m.floor), i, "floor of a facade", floor + " of facade " + m.facade, m.floor)
          .facade = m.facade;
  }
  std::vector<Group> all;
  std::map<std::vector<std::size_t>, int> known;
  if (whole && members.size() >= kFewest) {  // first: of groups that say it as clearly, the larger one is told
    Group building;
    building.kind = kBuilding, building.name = "The building";
    for (std::size_t i = 0; i < members.size(); ++i) building.members.push_back(i);
    building.directions = directions_of(members, building.members);
    all.push_back(std::move(building));
  }
  // What is the whole building is told as the common shift; one that holds the same anchors as another is that.
  const auto add = [&](auto& map) {
    for (auto& [key, group] : map)
      if (group.members.size() >= kFewest && group.members.size() < members.size() && known[group.members]++ == 0) {
        group.directions = directions_of(members, group.members);
        all.push_back(group);
      }
  };
  add(facades), add(floors), add(axes), add(columns), add(batches), add(both);
  return all;
}

/// Mean and scatter of those that stay together; `scatter`: what a usual group has, 0 if that is not known yet.
Sample sample_of(const Group& group, const Direction& direction, const std::vector<Vector3d>& deviations,
                 double scatter) {
  std::vector<double> values, sizes;
  for (const std::size_t i : group.members) values.push_back(direction.along.dot(deviations[i]));
  const double middle = upper_median(values);
  for (const double value : values) sizes.push_back(std::abs(value - middle));
  const double reach = kFollows * std::max({1.4826 * upper_median(sizes), scatter, kSmallestScatter});
  Sample sample;
  for (std::size_t k = 0; k < values.size(); ++k)
    if (std::abs(values[k] - middle) <= reach) sample.following.push_back(group.members[k]);
  const double n = static_cast<double>(sample.following.size());
  if (sample.following.size() < kFewest) return sample;
  for (const std::size_t i : sample.following) sample.mean += direction.along.dot(deviations[i]) / n;
  double squares = 0;
  for (const std::size_t i : sample.following) squares += std::pow(direction.along.dot(deviations[i]) - sample.mean, 2);
  sample.scatter = {std::max(squares / (n - 1), kSmallestScatter * kSmallestScatter), n - 1};
  return sample;
}

/// Samples of all groups along all their directions, each held against its own scatter and that of its like.
class Examination {
 public:
  Examination(const std::vector<Group>& groups, const judgement::BlockCovariance& covariance)
      : groups_(groups), covariance_(covariance) {
    for (const Group& group : groups) tests_ += group.directions.size();
  }

  std::vector<std::vector<Sample>> run(const std::vector<Vector3d>& deviations) {
    std::array<SampleVariance, kinds> priors;
    std::vector<std::vector<Sample>> all;
    for (int pass = 0; pass < 2; ++pass) {  // who stays together needs to know how much is usual
      std::array<std::vector<SampleVariance>, kinds> scatters;
      all.clear();
      for (const Group& group : groups_) {
        auto& samples = all.emplace_back();
        for (const Direction& direction : group.directions) {
          samples.push_back(sample_of(group, direction, deviations, std::sqrt(priors[direction.kind].variance)));
          // What is usual is that of its parts: a floor that stands out makes the building scatter.
          if (group.kind != kBuilding) scatters[direction.kind].push_back(samples.back().scatter);
        }
      }
      for (std::size_t kind = 0; kind < kinds; ++kind) priors[kind] = variance_prior(scatters[kind]);
    }
    for (std::size_t g = 0; g < groups_.size(); ++g)
      for (std::size_t k = 0; k < all[g].size(); ++k) test(groups_[g].directions[k], priors, all[g][k]);
    return all;
  }

 private:
  void test(const Direction& direction, const std::array<SampleVariance, kinds>& priors, Sample& sample) const {
    if (sample.following.size() < kFewest) return;
    const double n = static_cast<double>(sample.following.size());
    const SampleVariance known = moderated(sample.scatter, priors[direction.kind]);
    double own = 0, all = 0;  // errors of the measurement: each anchor's, and of their mean
    if (covariance_.size() != 0) {
      Eigen::SparseVector<double> weights(covariance_.size());
      for (const std::size_t i : sample.following) {
        const auto k = static_cast<Index>(i);
        own += direction.along.dot(covariance_.block(k, k) * direction.along);
        for (Index c = 0; c < 3; ++c) weights.insert(3 * k + c) = direction.along[c];
      }
      all = covariance_.quadratic(weights);
    }
    // Anchors that happen to lie alike were not measured better for that.
    sample.variance = std::max(known.variance, own / n) / n + std::max(0.0, all - own) / (n * n);
    sample.t = std::abs(sample.mean) / std::sqrt(sample.variance);
    sample.critical = student_t_quantile(1 - 0.5 * kLevel / static_cast<double>(tests_), known.freedom);
  }

  const std::vector<Group>& groups_;
  const judgement::BlockCovariance& covariance_;
  std::size_t tests_ = 0;
};

/// What of a group's samples is a shift: its directions that are beyond chance, and that two thirds follow.
struct Shift {
  std::vector<std::size_t> directions;
  Vector3d vector = Vector3d::Zero();
  double clear = 0;  ///< the largest t over its limit
};

Shift shift_of(const Group& group, const std::vector<Sample>& samples) {
  Shift shift;
  for (std::size_t k = 0; k < samples.size(); ++k) {
    const Sample& sample = samples[k];
    if (!(sample.t > sample.critical) || 3 * sample.following.size() < 2 * group.members.size()) continue;
    shift.directions.push_back(k);
    shift.vector += sample.mean * group.directions[k].along;
    shift.clear = std::max(shift.clear, sample.t / sample.critical);
  }
  return shift;
}

/// Members that follow the shift in all of its directions.
std::vector<std::size_t> followers(const Shift& shift, const std::vector<Sample>& samples) {
  std::vector<std::size_t> all = samples[shift.directions.front()].following;
  for (const std::size_t k : shift.directions)
    std::erase_if(all, [&](std::size_t i) {
      return !std::binary_search(samples[k].following.begin(), samples[k].following.end(), i);
    });
  return all;
}

std::string mm(double metres) { return fmt::format("{:.1f} mm", 1e3 * std::abs(metres)); }

/// "12.0 mm ± 0.4 mm low, 3.1 mm ± 0.5 mm too far out"
std::string way_of(const Group& group, const Shift& shift, const std::vector<Sample>& samples) {
  std::string text;
  for (const std::size_t k : shift.directions)
    text += (text.empty() ? "" : ", ") + mm(samples[k].mean) + " ± " + mm(std::sqrt(samples[k].variance)) + " " +
            (samples[k].mean > 0 ? group.directions[k].positive : group.directions[k].negative);
  return text;
}

std::unique_ptr<GroupShiftT> row_of(const Group& group, const std::vector<Sample>& samples) {
  auto row = std::make_unique<GroupShiftT>();
  row->kind = group.kind, row->name = group.name, row->floor = group.floor;
  row->facade = group.facade, row->column = group.column;
  row->anchors = static_cast<int>(group.members.size());
  row->following = row->anchors;
  Vector3d variance = Vector3d::Zero(), scatter = Vector3d::Zero();
  row->shift.setZero(), row->statistic = 0, row->critical = 0;
  for (std::size_t k = 0; k < samples.size(); ++k) {
    const Vector3d& along = group.directions[k].along;
    row->shift += samples[k].mean * along;
    variance += samples[k].variance * along.cwiseAbs2(), scatter += samples[k].scatter.variance * along.cwiseAbs2();
    row->following = std::min(row->following, static_cast<int>(samples[k].following.size()));
    if (samples[k].t * row->critical >= row->statistic * samples[k].critical)
      row->statistic = samples[k].t, row->critical = samples[k].critical;
  }
  row->u = variance.cwiseSqrt(), row->spread = scatter.cwiseSqrt();
  return row;
}

}  // namespace

std::vector<std::unique_ptr<GroupShiftT>> group_shifts(const std::vector<GroupMember>& members,
                                                       const judgement::BlockCovariance& covariance,
                                                       double smallest_tolerance, const WouldPass& would_pass,
                                                       std::vector<Vector3d>* remainder, bool whole) {
  const std::vector<Group> groups = groups_of(members, whole);
  std::vector<Vector3d> left;
  for (const GroupMember& member : members) left.push_back(member.deviation);
  Examination examination(groups, covariance);
  std::vector<std::unique_ptr<GroupShiftT>> told;
  std::vector<bool> taken(groups.size());
  for (std::size_t round = 0; round <= groups.size(); ++round) {
    const auto samples = examination.run(left);
    if (round == 0)
      for (std::size_t g = 0; g < groups.size(); ++g) told.push_back(row_of(groups[g], samples[g]));
    std::size_t best = groups.size();
    Shift strongest;
    for (std::size_t g = 0; g < groups.size(); ++g) {
      if (taken[g]) continue;
      Shift shift = shift_of(groups[g], samples[g]);
      // Of groups that say it as clearly, the larger one: it comes first.
      if (!shift.directions.empty() && shift.vector.norm() >= 0.5 * smallest_tolerance &&
          shift.clear > strongest.clear * 1.0001)
        best = g, strongest = std::move(shift);
    }
    if (best == groups.size()) break;
    taken[best] = true;
    const Group& group = groups[best];
    auto row = row_of(group, samples[best]);
    const std::vector<std::size_t> following = followers(strongest, samples[best]);
    row->significant = true, row->following = static_cast<int>(following.size());
    for (const std::size_t i : following) {
      const Vector3d corrected = left[i] - strongest.vector;
      row->would_pass += would_pass && !would_pass(i, left[i]) && would_pass(i, corrected);
      left[i] = corrected;
      row->members.push_back(static_cast<int>(i));
    }
    row->finding =
        row->name + (row->kind.starts_with("floor") ? " hangs " : " stands ") + way_of(group, strongest, samples[best]);
    row->words = row->finding + " (" + std::to_string(row->following) + " of its " + std::to_string(row->anchors) +
                 " anchors share it" +
                 (row->would_pass > 0 ? "; without it " + std::to_string(row->would_pass) + " more would pass" : "") +
                 "): one cause to look for, before single anchors are reset.";
    told[best] = std::move(row);
  }
  if (remainder) *remainder = left;
  std::erase_if(told, [](const auto& row) { return row->kind == kBuilding && !row->significant; });
  const auto clear = [](const auto& row) { return row->statistic / std::max(row->critical, 1e-12); };
  std::stable_sort(told.begin(), told.end(), [&](const auto& a, const auto& b) {
    return a->significant != b->significant ? a->significant : a->significant && clear(a) > clear(b);
  });
  return told;
}

}  // namespace plumbline::judgement
