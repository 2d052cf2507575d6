#include "photo/detect/level_search.hpp"

#include <algorithm>
#include <cmath>
#include <cstring>

#include "photo/detect/large_pages.hpp"

#define PLUMBLINE_CLONES __attribute__((target_clones("avx2", "default")))

namespace plumbline::detect {
namespace {

PLUMBLINE_CLONES void widen_range(const std::uint8_t* row, std::size_t count, std::uint8_t* low, std::uint8_t* high) {
  for (std::size_t i = 0; i < count; ++i) {
    low[i] = std::min(low[i], row[i]);
    high[i] = std::max(high[i], row[i]);
  }
}

/// Minima (or maxima) of four neighbours: out[i] over values[4 i ... 4 i + 3]. `values` is overwritten.
PLUMBLINE_CLONES void least_of_four(std::uint8_t* values, std::size_t count, std::uint8_t* out) {
  for (std::size_t i = 0; i + 1 < count; ++i) values[i] = std::min(values[i], values[i + 1]);
  for (std::size_t i = 0; i + 2 < count; ++i) values[i] = std::min(values[i], values[i + 2]);
  for (std::size_t i = 0; i < count / 4; ++i) out[i] = values[4 * i];
}
PLUMBLINE_CLONES void greatest_of_four(std::uint8_t* values, std::size_t count, std::uint8_t* out) {
  for (std::size_t i = 0; i + 1 < count; ++i) values[i] = std::max(values[i], values[i + 1]);
  for (std::size_t i = 0; i + 2 < count; ++i) values[i] = std::max(values[i], values[i + 2]);
  for (std::size_t i = 0; i < count / 4; ++i) out[i] = values[4 * i];
}

/// Threshold of each tile: `share` / 256 of its own and its two neighbours' range; 0 where there is no contrast.
PLUMBLINE_CLONES void thresholds(const std::uint8_t* low, const std::uint8_t* high, std::size_t count, int contrast,
                                 std::uint16_t share, std::uint8_t* out) {
  const auto needed = static_cast<std::uint8_t>(contrast);
  for (std::size_t i = 0; i < count; ++i) {
    const std::uint8_t darkest = std::min(std::min(low[i - 1], low[i]), low[i + 1]);
    const std::uint8_t brightest = std::max(std::max(high[i - 1], high[i]), high[i + 1]);
    const std::uint8_t range = static_cast<std::uint8_t>(brightest - darkest);
    const std::uint8_t middle = static_cast<std::uint8_t>(darkest + (range * share >> 8));
    out[i] = range < needed ? std::uint8_t{0} : middle;
  }
}

PLUMBLINE_CLONES void repeat_four(const std::uint8_t* tiles, std::size_t count, std::uint8_t* out) {
  for (std::size_t i = 0; i < count; ++i) {
    const std::uint32_t four = tiles[i] * 0x01010101u;
    std::memcpy(out + 4 * i, &four, 4);
  }
}

PLUMBLINE_CLONES void mark_dark(const std::uint8_t* grey, const std::uint8_t* threshold, std::size_t count,
                                std::uint8_t* out) {
  for (std::size_t i = 0; i < count; ++i) out[i] = grey[i] < threshold[i] ? std::uint8_t{1} : std::uint8_t{0};
}
PLUMBLINE_CLONES void mark_bright(const std::uint8_t* grey, const std::uint8_t* threshold, std::size_t count,
                                  std::uint8_t* out) {
  for (std::size_t i = 0; i < count; ++i) {
    const std::uint8_t above = grey[i] > threshold[i] ? std::uint8_t{1} : std::uint8_t{0};
    out[i] = threshold[i] > 0 ? above : std::uint8_t{0};
  }
}

/// 1 where a figure's pixel has none above it and none to its left, and was not followed yet.
PLUMBLINE_CLONES void upper_left_corners(const std::uint8_t* row, const std::uint8_t* above, std::size_t count,
                                         std::uint8_t* out) {
  for (std::size_t i = 0; i < count; ++i)
    out[i] = static_cast<std::uint8_t>((row[i] == 1) & (row[i - 1] == 0) & (above[i] == 0));
}

double cross(const Eigen::Vector2d& a, const Eigen::Vector2d& b) { return a.x() * b.y() - a.y() * b.x(); }

/// A line through points, by total least squares.
struct Line {
  Eigen::Vector2d centre, along;
  double rms;  // of the points' distances [px]
};

bool intersect(const Line& a, const Line& b, Eigen::Vector2d& point) {
  const double sine = cross(a.along, b.along);
  if (std::abs(sine) < 0.17) return false;  // 10 degrees
  point = a.centre + a.along * (cross(b.centre - a.centre, b.along) / sine);
  return true;
}

}  // namespace

LevelSearch::LevelSearch(int width, int height, int kept_rows, const LevelSearchOptions& options)
    : width_(width),
      height_(height),
      options_(options),
      stride_((static_cast<std::size_t>(width) + 8 + 63) / 64 * 64),
      tiles_((width + tile - 1) / tile),
      grey_(3 * tile * stride_) {
  for (auto* row : {&low_, &high_, &scratch_}) row->resize(stride_ + 64);
  for (auto* ring : {&tile_low_, &tile_high_})
    for (auto& row : *ring) row.resize(static_cast<std::size_t>(tiles_) + 2);
  limit_.resize(tiles_);
  // A quarter more, so that rows move up rarely.
  const auto held =
      static_cast<std::size_t>(options_.keep_all ? height_ : std::min(height_, kept_rows + kept_rows / 4)) + 64;
  binary_.reserve(held * stride_);
  prefer_large_pages(binary_.data(), binary_.capacity());
  binary_.resize(held * stride_);
}

void LevelSearch::add_row(const std::uint8_t* grey) {
  std::uint8_t* own = &grey_[static_cast<std::size_t>(rows_ % (3 * tile)) * stride_];
  const auto width = static_cast<std::size_t>(width_), padded = static_cast<std::size_t>(tiles_) * tile;
  std::copy_n(grey, width, own);
  std::fill(own + width, own + padded, grey[width - 1]);
  if (rows_ % tile == 0) {
    std::copy_n(own, padded, low_.begin());
    std::copy_n(own, padded, high_.begin());
  } else {
    widen_range(own, padded, low_.data(), high_.data());
  }
  ++rows_;
  if (rows_ % tile == 0 || rows_ == height_) finish_tile_row();
}

/// The row of tiles above the one that is complete now has all its neighbours.
void LevelSearch::finish_tile_row() {
  const int row = (rows_ - 1) / tile;
  const auto padded = static_cast<std::size_t>(tiles_) * tile;
  auto &low = tile_low_[row % 3], &high = tile_high_[row % 3];
  least_of_four(low_.data(), padded, low.data());
  greatest_of_four(high_.data(), padded, high.data());
  const auto finish = [&](int r) {
    const auto tiles = static_cast<std::size_t>(tiles_);
    std::uint8_t *l = low_.data(), *h = high_.data();
    std::copy_n(tile_low_[r % 3].data(), tiles, l + 1);
    std::copy_n(tile_high_[r % 3].data(), tiles, h + 1);
    for (const int other : {r - 1, r + 1}) {
      if (other < 0 || other > row) continue;
      widen_range(tile_low_[other % 3].data(), tiles, l + 1, scratch_.data());
      widen_range(tile_high_[other % 3].data(), tiles, scratch_.data(), h + 1);
    }
    l[0] = l[1], h[0] = h[1], l[tiles + 1] = l[tiles], h[tiles + 1] = h[tiles];
    thresholds(l + 1, h + 1, tiles, options_.min_contrast,
               static_cast<std::uint16_t>(std::lround(256 * options_.threshold)), limit_.data());
    binarise(r, limit_.data());
  };
  if (row > 0) finish(row - 1);
  if (rows_ == height_) finish(row);
}

void LevelSearch::binarise(int tile_row, const std::uint8_t* threshold) {
  make_room();
  const auto padded = static_cast<std::size_t>(tiles_) * tile;
  repeat_four(threshold, static_cast<std::size_t>(tiles_), scratch_.data());
  const int end = std::min((tile_row + 1) * tile, height_);
  for (int y = tile_row * tile; y < end; ++y) {
    const std::uint8_t* grey = &grey_[static_cast<std::size_t>(y % (3 * tile)) * stride_];
    std::uint8_t* out = pixel(0, y);
    (options_.bright ? mark_bright : mark_dark)(grey, scratch_.data(), padded, out);
    std::fill(out + width_, out + (stride_ - 1), std::uint8_t{0});
  }
  known_ = end;
  std::fill_n(pixel(-1, known_), stride_, std::uint8_t{0});  // figures end here for now
}

/// Drops rows above those that figures still begin in.
void LevelSearch::make_room() {
  const auto held = static_cast<int>(binary_.size() / stride_);
  if (known_ - first_ + tile + 2 <= held) return;
  const int drop = options_.keep_all ? 0 : std::max(0, next_ - 1 - first_);
  std::memmove(&binary_[stride_], &binary_[stride_ * static_cast<std::size_t>(drop + 1)],
               static_cast<std::size_t>(known_ - first_ - drop) * stride_);
  first_ += drop;
  const int missing = known_ - first_ + tile + 2 - held;
  if (missing > 0) binary_.resize(static_cast<std::size_t>(held + missing + 64) * stride_);
}

void LevelSearch::follow(int end, Outlines& out) {
  for (; next_ < std::min(end, known_); ++next_) {
    const std::uint8_t* row = pixel(0, next_);
    upper_left_corners(row, row - stride_, static_cast<std::size_t>(width_), scratch_.data());
    for (int x = 0; x < width_; x += 8) {
      std::uint64_t eight;
      std::memcpy(&eight, &scratch_[x], 8);
      if (eight == 0) continue;
      for (int i = x; i < std::min(x + 8, width_); ++i) {
        if (scratch_[i] == 0 || row[i] != 1) continue;
        const End end_of = trace(i, next_, true);
        if (end_of == End::unfinished) out.unfinished.push_back({i, next_});
        LevelQuad quad;
        if (end_of == End::closed && fit(quad)) out.quads.push_back(quad);
      }
    }
  }
}

void LevelSearch::follow_again(std::array<int, 2> first, Outlines& out) {
  LevelQuad quad;
  if (trace(first[0], first[1], false) == End::closed && fit(quad)) out.quads.push_back(quad);
}

/// Clockwise along the cracks with the figure on the right; where two of its pixels touch at a corner only, they are
/// two figures.
LevelSearch::End LevelSearch::trace(int start_x, int start_y, bool only_new) {
  constexpr std::array<int, 4> dx = {1, 0, -1, 0}, dy = {0, 1, 0, -1};
  constexpr std::size_t kCheck = 64;
  const auto s = static_cast<std::ptrdiff_t>(stride_);
  const std::array<std::ptrdiff_t, 4> step = {1, s, -1, -s}, ahead_right = {0, -1, -s - 1, -s},
                                      ahead_left = {-s, 0, -1, -s - 1};
  left_ = right_ = start_x, top_ = bottom_ = start_y;
  std::uint8_t* at = pixel(start_x, start_y);
  const std::uint8_t* const start = at;
  *at = 3;
  int x = start_x, y = start_y, direction = 0;
  std::size_t length = 0, checked = 0;
  // Stores of bytes may be stores to anything, so what the loop needs is not read through `this`.
  std::array<std::int16_t, 2>* path = path_.data();
  const auto extend = [&] {
    for (; checked < length; ++checked) {
      left_ = std::min<int>(left_, path[checked][0]), right_ = std::max<int>(right_, path[checked][0]);
      top_ = std::min<int>(top_, path[checked][1]), bottom_ = std::max<int>(bottom_, path[checked][1]);
    }
  };
  const auto wiggly = [&] {
    const auto box = static_cast<std::size_t>(2 * (right_ - left_ + bottom_ - top_));
    return length > box + box / 4 + 24;
  };
  const auto reaches_below = [&] { return bottom_ >= known_ && known_ < height_; };
  const auto done = [&](End end) {
    path_length_ = length;
    return end;
  };
  for (;;) {
    if (length % kCheck == 0) {
      extend();
      // A border that is cut by the rows known so far goes back on its inside.
      if (wiggly()) return done(reaches_below() ? End::unfinished : End::wiggly);
      if (path_.size() < length + kCheck) {
        path_.resize(2 * path_.size() + kCheck);
        path = path_.data();
      }
    }
    path[length++] = {static_cast<std::int16_t>(x), static_cast<std::int16_t>(y)};
    at += step[direction];
    x += dx[direction], y += dy[direction];
    if (at[ahead_right[direction]] == 0) {
      direction = (direction + 1) & 3;
      if (direction == 0) {
        if (at == start) break;
        if (only_new && *at == 3) return done(End::wiggly);  // part of one that was left
        *at = 3;
      }
    } else if (at[ahead_left[direction]] != 0) {
      direction = (direction + 3) & 3;
    }
  }
  extend();
  if (reaches_below()) return done(End::unfinished);
  return done(wiggly() ? End::wiggly : End::closed);
}

bool LevelSearch::fit(LevelQuad& quad) const {
  const std::size_t n = path_length_;
  const double shortest = options_.min_side;
  if (std::min(right_ - left_, bottom_ - top_) < shortest) return false;
  const auto at = [&](std::size_t i) { return Eigen::Vector2d(path_[i][0], path_[i][1]); };

  double sum_x = 0, sum_y = 0;
  for (std::size_t i = 0; i < n; ++i) sum_x += path_[i][0], sum_y += path_[i][1];
  const auto farthest = [&](double x, double y) {
    std::size_t best = 0;
    double distance = -1;
    for (std::size_t i = 0; i < n; ++i) {
      const double dx = path_[i][0] - x, dy = path_[i][1] - y, d = dx * dx + dy * dy;
      if (d > distance) best = i, distance = d;
    }
    return best;
  };
  // Between indices `from` and `to`, the point farthest outside of the chord. In whole numbers, which hold the product
  // of two coordinates, and without a division for each point: this is half of what an outline costs.
  const auto outermost = [&](std::size_t from, std::size_t to) {
    const std::array<std::int16_t, 2> a = path_[from], b = path_[to];
    const std::int64_t chord_x = b[0] - a[0], chord_y = b[1] - a[1];
    std::size_t best = from;
    std::int64_t height = 0;
    const auto look = [&](std::size_t first, std::size_t end) {
      for (std::size_t i = first; i < end; ++i) {
        const std::int64_t h = (path_[i][0] - a[0]) * chord_y - (path_[i][1] - a[1]) * chord_x;
        if (h > height) best = i, height = h;
      }
    };
    if (from < to) {
      look(from + 1, to);
    } else if (to < from) {
      look(from + 1, n);
      look(0, to);
    }
    return best;
  };
  std::array<std::size_t, 4> corner{};
  corner[0] = farthest(sum_x / static_cast<double>(n), sum_y / static_cast<double>(n));
  corner[2] = farthest(path_[corner[0]][0], path_[corner[0]][1]);
  corner[1] = outermost(corner[0], corner[2]);
  corner[3] = outermost(corner[2], corner[0]);
  for (int sweep = 0; sweep < 2; ++sweep)
    for (std::size_t i = 0; i < 4; ++i) corner[i] = outermost(corner[(i + 3) % 4], corner[(i + 1) % 4]);

  std::array<Line, 4> lines;
  for (std::size_t i = 0; i < 4; ++i) {
    const std::size_t from = corner[i], count = (corner[(i + 1) % 4] + n - from) % n;
    const double length = (at(corner[(i + 1) % 4]) - at(from)).norm();
    if (length < shortest) return false;
    const std::size_t margin = std::max<std::size_t>(1, count / 8);
    double sx = 0, sy = 0, sxx = 0, sxy = 0, syy = 0, m = 0;
    for (std::size_t k = margin; k + margin <= count; ++k) {
      const auto& p = path_[from + k < n ? from + k : from + k - n];
      const double px = p[0] - path_[from][0], py = p[1] - path_[from][1];
      sx += px, sy += py, sxx += px * px, sxy += px * py, syy += py * py, m += 1;
    }
    if (m < 3) return false;
    const double cx = sx / m, cy = sy / m, xx = sxx / m - cx * cx, xy = sxy / m - cx * cy, yy = syy / m - cy * cy;
    const double angle = 0.5 * std::atan2(2 * xy, xx - yy);
    const double smaller = 0.5 * (xx + yy - std::hypot(xx - yy, 2 * xy));
    lines[i] = {
        at(from) + Eigen::Vector2d(cx, cy), {std::cos(angle), std::sin(angle)}, std::sqrt(std::max(0.0, smaller))};
    if (lines[i].rms > std::max(0.75, 0.02 * length)) return false;
  }
  for (std::size_t i = 0; i < 4; ++i) {
    if (!intersect(lines[(i + 3) % 4], lines[i], quad.corners[i])) return false;
    if ((quad.corners[i] - at(corner[i])).norm() > std::max(3.0, 0.1 * (right_ - left_ + bottom_ - top_))) return false;
  }
  for (std::size_t i = 0; i < 4; ++i) {
    const Eigen::Vector2d side = quad.corners[(i + 1) % 4] - quad.corners[i];
    const Eigen::Vector2d next = quad.corners[(i + 2) % 4] - quad.corners[(i + 1) % 4];
    if (side.norm() < shortest || cross(side, next) <= 0) return false;
  }
  return true;
}

}  // namespace plumbline::detect
