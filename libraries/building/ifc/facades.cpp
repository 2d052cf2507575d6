// What continues what: from the frames of anchors and panels to facades.
#include "building/ifc/facades.hpp"

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <map>
#include <numbers>
#include <numeric>

namespace plumbline::ifc {
namespace {

/// Neighbours on one facade are no farther apart than this in plan [m].
constexpr double kFarthestNeighbour = 8;
/// Two elements of one facade face alike within 20°; a bent facade turns by less from one to the next.
const double kSameFacing = std::cos(20 * std::numbers::pi / 180);
/// Plates are true to a few degrees: within 30° they say the same as what is more exact.
const double kPlateAlike = std::cos(30 * std::numbers::pi / 180);

/// Elements above one another count as one place.
struct Place {
  Eigen::Vector3d position, out;
  std::vector<std::size_t> elements;
};

bool continues(const Place& a, const Place& b) {
  if (a.out.dot(b.out) < kSameFacing) return false;
  const Eigen::Vector3d d = b.position - a.position;
  const double apart = d.head<2>().norm();
  if (apart > kFarthestNeighbour) return false;
  // A bent facade leaves the plane of either element by less than half of what lies between them.
  const bool steep = std::abs(a.out.z()) > 0.7;
  const double step_a = steep ? std::abs(d.z()) : std::abs(a.out.head<2>().normalized().dot(d.head<2>()));
  const double step_b = steep ? std::abs(d.z()) : std::abs(b.out.head<2>().normalized().dot(d.head<2>()));
  return std::max(step_a, step_b) <= std::max(kFacadeStep, 0.3 * apart);
}

class Groups {
 public:
  explicit Groups(std::size_t n) : parent_(n) { std::iota(parent_.begin(), parent_.end(), 0u); }
  std::size_t find(std::size_t i) {
    while (parent_[i] != i) i = parent_[i] = parent_[parent_[i]];
    return i;
  }
  /// The lower number stays, so that groups come in the order of their first element.
  void join(std::size_t a, std::size_t b) {
    a = find(a), b = find(b);
    parent_[std::max(a, b)] = std::min(a, b);
  }

 private:
  std::vector<std::size_t> parent_;
};

/// One place for what stands above one another and faces alike; storeys of soffits stay apart.
std::vector<Place> places_of(const std::vector<Facing>& elements) {
  std::map<std::array<std::int64_t, 6>, std::size_t> index;
  std::vector<Place> places;
  for (std::size_t i = 0; i < elements.size(); ++i) {
    const Eigen::Vector3d &p = elements[i].position, &out = elements[i].frame->out;
    if (!out.allFinite() || !p.allFinite()) continue;
    const auto cell = [](double value, double step) { return static_cast<std::int64_t>(std::llround(value / step)); };
    const std::array<std::int64_t, 6> key = {
        cell(p.x(), 0.05),   cell(p.y(), 0.05),   std::abs(out.z()) > 0.7 ? cell(p.z(), 0.5) : 0,
        cell(out.x(), 0.02), cell(out.y(), 0.02), cell(out.z(), 0.02)};
    const auto [found, added] = index.try_emplace(key, places.size());
    if (added) places.push_back({p, out, {}});
    places[found->second].elements.push_back(i);
  }
  return places;
}

Groups join_places(const std::vector<Place>& places) {
  Groups groups(places.size());
  std::map<std::pair<std::int64_t, std::int64_t>, std::vector<std::size_t>> cells;
  const auto cell = [](double v) { return static_cast<std::int64_t>(std::floor(v / kFarthestNeighbour)); };
  for (std::size_t i = 0; i < places.size(); ++i)
    cells[{cell(places[i].position.x()), cell(places[i].position.y())}].push_back(i);
  for (const auto& [key, members] : cells)
    for (int dx = -1; dx <= 1; ++dx)
      for (int dy = -1; dy <= 1; ++dy) {
        const auto other = cells.find({key.first + dx, key.second + dy});
        if (other == cells.end()) continue;
        for (const std::size_t a : members)
          for (const std::size_t b : other->second)
            if (a < b && continues(places[a], places[b])) groups.join(a, b);
      }
  return groups;
}

/// A, B, …, Z, AA, …
std::string letters(std::size_t i) {
  std::string text;
  for (++i; i > 0; i = (i - 1) / 26) text.insert(text.begin(), static_cast<char>('A' + (i - 1) % 26));
  return text;
}

std::string name_of(std::size_t number, const Facade& facade) {
  std::string words = facing_words(facade.out);
  if (facade.bend > 0.02) words = "bent about " + words;
  return letters(number) + " (" + words + ")";
}

}  // namespace

std::vector<Facade> group_facades(const std::vector<Facing>& elements) {
  const std::vector<Place> places = places_of(elements);
  Groups groups = join_places(places);
  std::map<std::string, std::vector<std::size_t>> named;  // by the name that a rule gave
  std::map<std::size_t, std::vector<std::size_t>> found;
  for (std::size_t i = 0; i < places.size(); ++i)
    for (const std::size_t element : places[i].elements) {
      const FacadeFrame& frame = *elements[element].frame;
      if (frame.named)
        named[frame.facade].push_back(element);
      else
        found[groups.find(i)].push_back(element);
    }
  std::vector<std::pair<std::string, std::vector<std::size_t>>> all;
  for (auto& [name, members] : named) all.emplace_back(name, std::move(members));
  for (auto& [group, members] : found) all.emplace_back("", std::move(members));
  for (auto& [name, members] : all) std::sort(members.begin(), members.end());
  std::stable_sort(all.begin(), all.end(),
                   [](const auto& a, const auto& b) { return a.second.front() < b.second.front(); });
  std::vector<Facade> facades;
  for (auto& [name, members] : all) {
    Facade facade;
    facade.source = FacadeSource::rule;
    for (const std::size_t i : members) {
      const Facing& element = elements[i];
      facade.out += element.frame->out, facade.centre += element.position / static_cast<double>(members.size());
      ++(element.is_panel ? facade.panels : facade.anchors);
      facade.source = std::min(facade.source, element.frame->source);
      if (!element.frame->confirmed && facade.confirmed) facade.confirmed = false, facade.note = element.frame->note;
    }
    facade.out = facade.out.norm() > 1e-6 ? Eigen::Vector3d(facade.out.normalized()) : elements[members[0]].frame->out;
    for (const std::size_t i : members)
      facade.bend = std::max(facade.bend, std::acos(std::clamp(facade.out.dot(elements[i].frame->out), -1.0, 1.0)));
    facade.name = name.empty() ? name_of(facades.size(), facade) : name;
    for (const std::size_t i : members) elements[i].frame->facade = facade.name;
    facades.push_back(std::move(facade));
  }
  return facades;
}

namespace {

/// Where a plate faces if its azimuth is that of a compass.
Eigen::Vector3d by_compass(const Eigen::Vector3d& out, double true_north) {
  if (!std::isfinite(true_north)) return Eigen::Vector3d::Zero();
  return Eigen::AngleAxisd(-true_north, Eigen::Vector3d::UnitZ()) * out;
}

/// Within 10 degrees what somebody read from a compass is the facade's own direction.
const double kByCompass = std::cos(10 * std::numbers::pi / 180);
/// Within 15 degrees of along or across it a plate corrects what was guessed: the side, or at a corner the face.
const double kSquare = std::sin(15 * std::numbers::pi / 180);

bool corrects_guess(const FacadeFrame& frame, double along) {
  const double across = std::sqrt(std::max(0.0, 1 - along * along));
  return !frame.confirmed && std::min(std::abs(along), across) < kSquare;
}

}  // namespace

void add_plate(FacadeFrame& frame, const Eigen::Vector3d& out, double true_north) {
  // A plate that lies flat has no azimuth, and a table that gives none leaves it so.
  if (frame.source == FacadeSource::rule || !out.allFinite() || out.head<2>().norm() < 0.7 * out.norm()) return;
  const Eigen::Vector3d level = Eigen::Vector3d(out.x(), out.y(), 0).normalized();
  const auto replace = [&](const Eigen::Vector3d& direction, bool confirmed, const std::string& note) {
    FacadeFrame made = frame_facing(direction, FacadeSource::plate, confirmed);
    made.facade = frame.facade, made.named = frame.named, made.note = note;
    frame = std::move(made);
  };
  if (!frame.known()) return replace(level, true, "");
  const double along = frame.out.dot(level);
  if (along > kPlateAlike) return replace(frame.out, true, "");
  if (!corrects_guess(frame, along) && by_compass(level, true_north).dot(frame.out) > kByCompass)
    return replace(frame.out, false,
                   "its plates face " + facing_words(level) + " by the plate table, which is " +
                       facing_words(frame.out) +
                       " if the table has azimuths from TrueNorth of the design, by a "
                       "compass: there they count from its y axis");
  if (!frame.confirmed && along < -kPlateAlike) return replace(-frame.out, true, "");
  if (!frame.confirmed) return replace(level, true, "");
  replace(level, false,
          "its plates face " + facing_words(level) + " by the plate table, and " + facing_words(frame.out) + " by " +
              (frame.source == FacadeSource::own_axes ? "the axes of the elements"
               : frame.source == FacadeSource::panel  ? "the panels"
                                                      : "the wall behind it"));
}

}  // namespace plumbline::ifc
