#include "photo/detect/tag_pyramid.hpp"

#include <algorithm>
#include <cmath>
#include <memory>
#include <optional>
#include <tuple>

#include "photo/detect/corner_refinement.hpp"
#include "photo/detect/edge_lines.hpp"
#include "photo/detect/large_pages.hpp"
#include "photo/detect/level_search.hpp"
#include "photo/detect/likeness.hpp"
#include "plumbline/stop.hpp"

#define PLUMBLINE_CLONES __attribute__((target_clones("avx2", "default")))

namespace plumbline::detect {
namespace {

constexpr int kMargin = 40;  // around a tag for the fit of its edges [px]
constexpr int kLag = 16;     // rows of a level that its search lags behind
constexpr int kBlock = 64;   // rows that are decoded between two searches [px]
constexpr int kLevelFactor = 4;
constexpr double kApart = 0.2;  // threshold that takes the squares between the tags of Kalibr's grids off their corners

PLUMBLINE_CLONES void halve(const std::uint8_t* upper, const std::uint8_t* lower, std::size_t count,
                            std::uint8_t* out) {
  for (std::size_t i = 0; i < count; ++i)
    out[i] = static_cast<std::uint8_t>((upper[2 * i] + upper[2 * i + 1] + lower[2 * i] + lower[2 * i + 1] + 2) >> 2);
}

int window_rows(int height) { return std::min(height, std::max(1200, height / 5)); }

/// The last rows of the image.
class Window {
 public:
  Window(int width, int height, int rows)
      : width_(width),
        held_(rows),
        pixels_(std::make_unique_for_overwrite<std::uint8_t[]>(static_cast<std::size_t>(width) *
                                                               static_cast<std::size_t>(rows))),
        rows_(height) {
    prefer_large_pages(pixels_.get(), static_cast<std::size_t>(width) * rows);
  }
  std::uint8_t* next() {
    std::uint8_t* row = &pixels_[static_cast<std::size_t>(end_ % held_) * width_];
    rows_[end_++] = row;
    return row;
  }
  int end() const { return end_; }
  PixelRows view() const { return {0, width_, std::max(0, end_ - held_), end_, rows_.data()}; }

 private:
  int width_, held_, end_ = 0;
  std::unique_ptr<std::uint8_t[]> pixels_;
  std::vector<const std::uint8_t*> rows_;  // by row of the image; those that left the window are overwritten
};

/// One reduced level and its searches, for dark and, where a family wants it, for bright squares.
struct Level {
  int factor;
  std::vector<std::pair<bool, std::unique_ptr<LevelSearch>>> searches;  // bright inside?
};

/// Rows of the image in, rows of the reduced levels out: pairs of rows are halved again and again. A row that was added
/// has to stay until the next one was.
class Reducer {
 public:
  Reducer(int width, std::vector<Level>& levels) : levels_(levels) {
    for (int factor = 1; factor <= levels.back().factor; factor *= 2) {
      const std::vector<std::uint8_t> row(static_cast<std::size_t>(width / factor));
      reduced_.push_back({row, row});
      count_.push_back(0);
      upper_.push_back(nullptr);
    }
  }
  void add(const std::uint8_t* row) { add(0, row); }

 private:
  void add(std::size_t power, const std::uint8_t* row) {
    const int factor = 1 << power;
    for (Level& level : levels_)
      if (level.factor == factor)
        for (auto& search : level.searches) search.second->add_row(row);
    if (power + 1 == reduced_.size()) return;
    if (!upper_[power]) {
      upper_[power] = row;
      return;
    }
    // Of two buffers in turn, so that the upper row of a pair is there when its lower one comes.
    std::vector<std::uint8_t>& half = reduced_[power + 1][count_[power + 1]++ % 2];
    halve(upper_[power], row, half.size(), half.data());
    upper_[power] = nullptr;
    add(power + 1, half.data());
  }
  std::vector<Level>& levels_;
  std::vector<std::array<std::vector<std::uint8_t>, 2>> reduced_;  // rows of each power of two
  std::vector<std::size_t> count_;                                 // of the rows that there were
  std::vector<const std::uint8_t*> upper_;                         // of a pair whose lower row has not come
};

std::vector<const std::uint8_t*> rows_of(const GreyImage& image, int first, int end) {
  std::vector<const std::uint8_t*> rows(static_cast<std::size_t>(end));
  for (int y = first; y < end; ++y) rows[y] = &image.pixels[static_cast<std::size_t>(y - first) * image.width];
  return rows;
}

double shortest_side(const std::array<Eigen::Vector2d, 4>& c) {
  double shortest = (c[0] - c[3]).norm();
  for (std::size_t i = 0; i < 3; ++i) shortest = std::min(shortest, (c[i + 1] - c[i]).norm());
  return shortest;
}

/// A tag that was read, with the copy of its surroundings that its corners count from.
struct Candidate {
  DetectedTag tag;
  const SquareFamily* family = nullptr;
  LikenessLimit limit;
  Eigen::Vector2d origin = Eigen::Vector2d::Zero();
  std::unique_ptr<GreyImage> part;
};

bool same_tag(const Candidate& a, const Candidate& b) {
  if (a.tag.id != b.tag.id || a.tag.family != b.tag.family) return false;
  const auto centre = [](const Candidate& c) {
    return Eigen::Vector2d(0.25 * (c.tag.corners[0] + c.tag.corners[1] + c.tag.corners[2] + c.tag.corners[3]));
  };
  return (centre(a) - centre(b)).norm() < 0.5 * shortest_side(a.tag.corners);
}

/// Reads what the levels find, from the rows that are held.
class Reader {
 public:
  Reader(const std::vector<SquareDecoder>& decoders, const PyramidOptions& options)
      : decoders_(decoders), options_(options) {}

  void read(const LevelQuad& quad, int factor, bool bright_inside, const PixelRows& image) {
    std::array<Eigen::Vector2d, 4> rough;
    for (std::size_t i = 0; i < 4; ++i) rough[i] = quad.corners[i] * factor - Eigen::Vector2d(0.5, 0.5);
    for (const SquareDecoder& decoder : decoders_) {
      if (decoder.family().bright_inside != bright_inside || !looks_coded(image, rough, decoder.family())) continue;
      const int modules = decoder.family().modules;
      const double cell = shortest_side(rough) / modules, reach = std::min(factor + 1.0, std::max(1.0, 0.6 * cell));
      const auto edges = on_edges(image, rough, reach, bright_inside);
      CodeReading reading = decoder.read(image, edges ? *edges : rough);
      if (!reading.code && edges) reading = decoder.read(image, rough);
      if (reading.mirrored) count_mirrored(rough, decoder.chance());
      if (reading.code && reading.code->decision_margin >= options_.min_decision_margin)
        keep(*reading.code, decoder, image);
    }
  }
  std::vector<Candidate>& candidates() { return candidates_; }
  bool mirrored() const { return mirrored_; }

 private:
  /// In a photograph of many squares a family of few cells reads some of them in a mirror by chance: four then.
  void count_mirrored(const std::array<Eigen::Vector2d, 4>& corners, double chance) {
    constexpr double weak = 1e-4;
    constexpr std::size_t enough = 4;
    const Eigen::Vector2d centre = 0.25 * (corners[0] + corners[1] + corners[2] + corners[3]);
    const double near = 0.5 * shortest_side(corners);
    for (const Eigen::Vector2d& other : mirrored_places_)
      if ((other - centre).norm() < near) return;  // of another level, or its border's other side
    mirrored_places_.push_back(centre);
    mirrored_ = mirrored_ || chance < weak || mirrored_places_.size() >= enough;
  }

  /// Cells along both diagonals differ as much as black and white do around the square: plain bricks and windows end
  /// here.
  bool looks_coded(const PixelRows& image, const std::array<Eigen::Vector2d, 4>& c, const SquareFamily& family) const {
    float low = 255, high = 0;
    const int modules = family.modules;
    for (std::size_t i = 0; i < 4; ++i)
      for (int k = 0; k < modules; ++k) {
        const double u = (k + 0.5) / modules;
        const Eigen::Vector2d p =
            i < 2 ? Eigen::Vector2d(c[i] + (c[i + 2] - c[i]) * u)
                  : Eigen::Vector2d(0.5 * (c[i - 2] + c[i - 1]) * (1 - u) + 0.5 * (c[i] + c[(i + 1) % 4]) * u);
        if (!image.holds(p.x(), p.y())) return false;
        const float value = image.at(p.x(), p.y());
        low = std::min(low, value), high = std::max(high, value);
      }
    return high - low >= static_cast<float>(options_.min_contrast);
  }

  void keep(const ReadCode& code, const SquareDecoder& decoder, const PixelRows& image) {
    const SquareFamily& family = decoder.family();
    Candidate found;
    found.family = &family;
    found.limit = likeness_limit(decoder.chance());
    found.tag.family = family.name;
    found.tag.id = code.id;
    found.tag.hamming = code.hamming;
    found.tag.decision_margin = code.decision_margin;
    found.tag.corners = code.corners;
    for (auto& c : found.tag.covariances)
      c = Eigen::Matrix2d::Identity() * options_.unrefined_sigma * options_.unrefined_sigma;
    for (Candidate& other : candidates_) {
      if (!same_tag(other, found)) continue;
      if (std::tuple(found.tag.hamming, -found.tag.decision_margin) <
          std::tuple(other.tag.hamming, -other.tag.decision_margin)) {
        copy_surroundings(image, found);
        other = std::move(found);
      }
      return;
    }
    copy_surroundings(image, found);
    candidates_.push_back(std::move(found));
  }

  static void copy_surroundings(const PixelRows& image, Candidate& found) {
    Eigen::Vector2d low = found.tag.corners[0], high = low;
    for (const auto& c : found.tag.corners) low = low.cwiseMin(c), high = high.cwiseMax(c);
    const int left = std::max(image.left, static_cast<int>(std::floor(low.x())) - kMargin);
    const int right = std::min(image.right, static_cast<int>(std::ceil(high.x())) + kMargin + 1);
    const int top = std::max(image.first, static_cast<int>(std::floor(low.y())) - kMargin);
    const int bottom = std::min(image.end, static_cast<int>(std::ceil(high.y())) + kMargin + 1);
    found.origin = {left, top};
    found.part = std::make_unique<GreyImage>(GreyImage{right - left, bottom - top, {}});
    found.part->pixels.reserve(static_cast<std::size_t>(right - left) * static_cast<std::size_t>(bottom - top));
    for (int y = top; y < bottom; ++y)
      found.part->pixels.insert(found.part->pixels.end(), image.rows[y] + (left - image.left),
                                image.rows[y] + (right - image.left));
  }

  const std::vector<SquareDecoder>& decoders_;
  const PyramidOptions& options_;
  std::vector<Candidate> candidates_;
  std::vector<Eigen::Vector2d> mirrored_places_;
  bool mirrored_ = false;
};

/// Reads a quadrilateral that is taller than the window from a part of the file.
void read_tall(Reader& reader, const LevelQuad& quad, int factor, bool bright_inside, int height,
               const TagPyramid::ReadPart& part) {
  Eigen::Vector2d low = quad.corners[0], high = low;
  for (const auto& c : quad.corners) low = low.cwiseMin(c), high = high.cwiseMax(c);
  const int border = 2 * kMargin + static_cast<int>(0.15 * factor * (high - low).maxCoeff());
  const int left = std::max(0, static_cast<int>(low.x() * factor) - border);
  const int top = std::max(0, static_cast<int>(low.y() * factor) - border);
  const GreyImage held = part(left, top, static_cast<int>(high.x() * factor) + border - left,
                              static_cast<int>(high.y() * factor) + border - top);
  std::vector<const std::uint8_t*> rows = rows_of(held, top, top + held.height);
  rows.resize(height);
  reader.read(quad, factor, bright_inside, {left, left + held.width, top, top + held.height, rows.data()});
}

void measure(std::vector<Candidate>& candidates, const PyramidOptions& options) {
  std::vector<Quadrilateral> found;
  for (const Candidate& c : candidates) {
    Quadrilateral q{c.tag.corners, c.family->modules, c.part.get()};
    for (auto& corner : q.corners) corner -= c.origin;
    q.origin = c.origin.cast<int>(), q.border = c.family->border;
    found.push_back(q);
  }
  const Measurement measured = measure_corners(found, options.edge);
  for (std::size_t k = 0; k < candidates.size(); ++k) {
    if (!measured.corners[k]) continue;
    DetectedTag& tag = candidates[k].tag;
    for (std::size_t i = 0; i < 4; ++i) {
      tag.corners[i] = measured.corners[k]->corners[i] + candidates[k].origin;
      tag.covariances[i] =
          measured.corners[k]->covariances[i] + Eigen::Matrix2d::Identity() * options.sigma_floor * options.sigma_floor;
    }
    tag.refined = true, tag.inset_sigma = measured.quality.inset_sigma;
  }
}

/// Whether the tag looks like its drawing; see likeness_limit().
bool alike(const Candidate& c) {
  if (!c.limit.checks()) return true;
  const auto& ids = c.family->ids;
  const auto index = static_cast<std::size_t>(std::find(ids.begin(), ids.end(), c.tag.id) - ids.begin());
  std::array<Eigen::Vector2d, 4> corners = c.tag.corners;
  for (auto& corner : corners) corner -= c.origin;
  const auto rows = rows_of(*c.part, 0, c.part->height);
  return c.limit.holds(likeness({0, c.part->width, 0, c.part->height, rows.data()}, corners, *c.family, index));
}

}  // namespace

TagPyramid::TagPyramid(std::vector<SquareFamily> families, const PyramidOptions& options) : options_(options) {
  if (families.empty())
    throw std::runtime_error("tag pyramid: no tag family is given; name at least one, such as tag36h11");
  for (const SquareFamily& family : families) decoders_.emplace_back(family, options.max_hamming);
}

double TagPyramid::memory(int width, int height) {
  return 1.4 * static_cast<double>(width) * window_rows(height) + 4e6;
}

PyramidResult TagPyramid::detect(const GreyImage& image) const {
  return detect(*plumbline::rows_of(image),
                [&](int left, int top, int width, int height) { return part_of(image, left, top, width, height); });
}

PyramidResult TagPyramid::detect(GreyRows& rows, const ReadPart& part) const {
  const int width = rows.width(), height = rows.height();
  PyramidResult result;
  if (width < 16 || height < 16) return result;
  const bool small = 1e-6 * width * height <= 30;
  int finest = (options_.smallest_tag > 0 ? options_.smallest_tag < 24 : small) ? 1 : 2;
  while (width / finest > 32000 || height / finest > 32000) finest *= 2;  // outlines have 16-bit coordinates
  const int held = window_rows(height);

  std::vector<Level> levels;
  for (const int factor : {finest, finest * kLevelFactor}) {
    if (width / factor < 16 || height / factor < 16) break;
    Level level{factor, {}};
    for (const auto& [bright, border] : {std::pair(false, 1), {false, 2}, {true, 1}}) {
      if (std::none_of(decoders_.begin(), decoders_.end(), [&](const auto& d) {
            return d.family().bright_inside == bright && d.family().border == border;
          }))
        continue;
      LevelSearchOptions search;
      search.bright = bright;
      if (border > 1) search.threshold = kApart;
      search.min_contrast = options_.min_contrast;
      search.keep_all = factor > finest;
      level.searches.emplace_back(
          bright, std::make_unique<LevelSearch>(width / factor, height / factor, held / factor, search));
    }
    levels.push_back(std::move(level));
  }

  Window window(width, height, held);
  Reducer reducer(width, levels);
  Reader reader(decoders_, options_);
  std::vector<std::array<int, 4>> tall;  // level, search, first pixel
  // Rows below a figure's first one that have to be known before it is followed.
  const int depth = held - kBlock - 2 * kMargin - kLag * levels.back().factor;
  while (window.end() < height) {
    stop_point();
    for (int i = 0; i < kBlock && window.end() < height; ++i) {
      std::uint8_t* row = window.next();
      rows.next(row);
      reducer.add(row);
    }
    const bool last = window.end() == height;
    for (std::size_t l = 0; l < levels.size(); ++l) {
      const int factor = levels[l].factor;
      const int ready = last ? height / factor : (window.end() - depth) / factor;
      for (std::size_t s = 0; s < levels[l].searches.size(); ++s) {
        Outlines found;
        levels[l].searches[s].second->follow(ready, found);
        for (const LevelQuad& quad : found.quads) reader.read(quad, factor, levels[l].searches[s].first, window.view());
        if (l + 1 == levels.size())
          for (const auto& first : found.unfinished)
            tall.push_back({static_cast<int>(l), static_cast<int>(s), first[0], first[1]});
      }
    }
  }
  for (const auto& [l, s, x, y] : tall) {
    Outlines found;
    const Level& level = levels[l];
    const auto& search = level.searches[s];
    search.second->follow_again({x, y}, found);
    for (const LevelQuad& quad : found.quads) read_tall(reader, quad, level.factor, search.first, height, part);
  }
  for (Candidate& c : reader.candidates()) {
    const bool cut = std::any_of(c.tag.corners.begin(), c.tag.corners.end(), [&](const Eigen::Vector2d& p) {
      return p.x() < 1 || p.y() < 1 || p.x() > width - 2 || p.y() > height - 2;
    });
    if (cut) c.tag.covariances.fill(Eigen::Matrix2d::Identity() * std::max(1.0, std::pow(options_.unrefined_sigma, 2)));
  }
  if (options_.refinement == Refinement::edges) measure(reader.candidates(), options_);
  for (Candidate& c : reader.candidates())
    if (alike(c)) result.tags.push_back(std::move(c.tag));
  std::sort(result.tags.begin(), result.tags.end(), [](const DetectedTag& a, const DetectedTag& b) {
    const auto key = [](const DetectedTag& t) {
      return std::make_tuple(t.family, t.id, t.corners[0].x(), t.corners[0].y());
    };
    return key(a) < key(b);
  });
  result.mirrored = reader.mirrored();
  return result;
}

}  // namespace plumbline::detect
