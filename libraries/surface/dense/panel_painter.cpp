#include "surface/dense/panel_painter.hpp"

#include <algorithm>
#include <cmath>

#include "plumbline/stop.hpp"

namespace plumbline::surface {
namespace {

/// Grey value at a place of a reduced photograph, bilinear; −1 outside.
int grey_at(const GreyImage& image, double x, double y) {
  const int left = static_cast<int>(std::floor(x)), top = static_cast<int>(std::floor(y));
  if (left < 0 || top < 0 || left + 1 >= image.width || top + 1 >= image.height) return -1;
  const double a = x - left, b = y - top;
  const std::uint8_t* p = image.pixels.data() + static_cast<size_t>(top) * image.width + left;
  const std::uint8_t* q = p + image.width;
  return static_cast<int>(std::lround((1 - b) * ((1 - a) * p[0] + a * p[1]) + b * ((1 - a) * q[0] + a * q[1])));
}

/// Rows and columns of the picture whose pixels may lie within `beyond` of a face.
struct Window {
  int left, right, top, bottom;
};
Window window_of(const PanelFace& face, double beyond, const Orthophoto& picture) {
  Eigen::Vector2d low(1e300, 1e300), high = -low;
  for (const double a : {-0.5, 0.5})
    for (const double b : {-0.5, 0.5}) {
      const Eigen::Vector2d at =
          picture.plane.local(face.plane.world({a * (face.width + 2 * beyond), b * (face.height + 2 * beyond), 0}))
              .head<2>();
      low = low.cwiseMin(at), high = high.cwiseMax(at);
    }
  const auto column = [&](double u) {
    return static_cast<int>(std::floor((u - picture.area.low.x()) / picture.pixel));
  };
  const auto row = [&](double v) { return static_cast<int>(std::floor((picture.area.high.y() - v) / picture.pixel)); };
  return {std::max(0, column(low.x())), std::min(picture.width - 1, column(high.x())), std::max(0, row(high.y())),
          std::min(picture.height - 1, row(low.y()))};
}

/// Where the perpendicular of the picture's plane through a place of it meets a panel, as (u, v, h) of its face. Faces
/// of one picture lie off its plane and lean against it, so that their own perpendicular is another.
Eigen::Vector3d place_on(const PanelFace& face, const PanelSurface& surface, const Eigen::Vector3d& on_picture,
                         const Eigen::Vector3d& out) {
  const Eigen::Vector3d direction = face.plane.axes.transpose() * out;
  Eigen::Vector3d at = face.plane.local(on_picture);
  double height = 0;
  for (int step = 0; step < 3; ++step) {  // on a plane the first one is right; panels are flat to a hundredth
    at += (height - at.z()) / direction.z() * direction;
    height = surface.not_measured.empty() ? surface.base(at.x(), at.y()).dot(surface.form) : 0.0;
  }
  return {at.x(), at.y(), height};
}

float median_of_floats(std::vector<float> values) {
  const auto middle = values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2);
  std::nth_element(values.begin(), middle, values.end());
  return *middle;
}

/// Median and 1.4826 times the median distance from it: the standard deviation of what is normally distributed.
std::pair<float, float> centre_and_spread(std::vector<float> values) {
  const float centre = median_of_floats(values);
  for (float& value : values) value = std::abs(value - centre);
  return {centre, 1.4826f * median_of_floats(std::move(values))};
}

/// Means over squares of half width `half`, of what is there (not below 0); below 0 where nothing is.
std::vector<float> box_means(const std::vector<float>& values, int width, int height, int half) {
  std::vector<float> across(values.size()), count(values.size()), means(values.size());
  const auto at = [width](int x, int y) { return static_cast<size_t>(y) * width + x; };
  for (int y = 0; y < height; ++y) {
    float sum = 0, n = 0;
    const auto take = [&](int x, float sign) {
      if (x >= 0 && x < width && values[at(x, y)] >= 0) sum += sign * values[at(x, y)], n += sign;
    };
    for (int x = 0; x < half; ++x) take(x, 1);
    for (int x = 0; x < width; ++x) {
      take(x + half, 1), take(x - half - 1, -1);
      across[at(x, y)] = sum, count[at(x, y)] = n;
    }
  }
  for (int x = 0; x < width; ++x) {
    float sum = 0, n = 0;
    const auto take = [&](int y, float sign) {
      if (y >= 0 && y < height) sum += sign * across[at(x, y)], n += sign * count[at(x, y)];
    };
    for (int y = 0; y < half; ++y) take(y, 1);
    for (int y = 0; y < height; ++y) {
      take(y + half, 1), take(y - half - 1, -1);
      means[at(x, y)] = n > 0.5f ? sum / n : -1;
    }
  }
  return means;
}

/// The smallest or the largest of what is there within `half` of each pixel.
std::vector<float> extremes(std::vector<float> values, int width, int height, int half, bool largest) {
  std::vector<float> passed(values.size());
  for (const bool across : {true, false}) {
    for (int y = 0; y < height; ++y)
      for (int x = 0; x < width; ++x) {
        float best = -1;
        for (int d = -half; d <= half; ++d) {
          const int i = across ? x + d : x, j = across ? y : y + d;
          if (i < 0 || i >= width || j < 0 || j >= height) continue;
          const float value = values[static_cast<size_t>(j) * width + i];
          if (value >= 0 && (best < 0 || (largest ? value > best : value < best))) best = value;
        }
        passed[static_cast<size_t>(y) * width + x] = best;
      }
    values.swap(passed);
  }
  return values;
}

}  // namespace

/// Rows of the picture with some around them: what each photograph shows, and between which values it may lie where
/// photographs are compared. Below 0: it shows nothing.
struct PanelPainter::Strip {
  int top = 0, width = 0, height = 0;
  std::vector<Eigen::Vector3d> place;  ///< u, v and height on the face
  struct Layer {
    std::vector<float> grey, low, high;            ///< the pixel, and its surroundings' mean
    std::vector<float> alike, darkest, brightest;  ///< with all photographs' brightness: the pixel, and those near it
  };
  std::vector<Layer> layers;
};

PaintCounts& PaintCounts::operator+=(const PaintCounts& other) {
  unseen += other.unseen, contradicted += other.contradicted;
  unchecked += other.unchecked, agreed += other.agreed;
  return *this;
}

PanelPainter::PanelPainter(const PanelFace& face, const PanelSurface& surface, const std::vector<PaintView>& views,
                           double beyond, Orthophoto& picture)
    : face_(face),
      surface_(surface),
      views_(views),
      beyond_(beyond),
      picture_(picture),
      measured_(surface.not_measured.empty()),
      level_(views.size()),
      gain_(views.size(), 1),
      offset_(views.size(), 0) {
  const Window window = window_of(face, beyond, picture);
  left_ = window.left, right_ = window.right, top_ = window.top, bottom_ = window.bottom;
  double coarsest = 0;
  for (size_t k = 0; k < views.size(); ++k) {
    const auto middle = map_at(*views[k].view.view, face.plane, {0, 0, 0}, -1e6);
    if (!middle) continue;
    // As many pixels of the photograph as one of the picture holds are taken together.
    while (level_[k] + 1 < Pyramid::levels && middle->ground_pixel() * (2 << level_[k]) <= picture.pixel) ++level_[k];
    coarsest = std::max(coarsest, middle->ground_pixel());
  }
  blur_ = std::clamp(static_cast<int>(std::ceil(1.5 * coarsest / picture.pixel)), 3, 12);
  shift_ = std::clamp(static_cast<int>(std::ceil(coarsest / picture.pixel)), 1, 8);
  if (views.size() > 1) make_brightness_alike();
}

int PanelPainter::sample(size_t view, const Eigen::Vector3d& place, int level) const {
  const PaintView& of = views_[view];
  if (!of.screens.empty() && of.screens.hide(place)) return -1;
  const auto seen = project(of.view.view->camera, of.view.view->cam_from_world * place);
  if (!seen) return -1;
  const double scale = 1.0 / (1 << level), shift = 0.5 * (scale - 1);
  return grey_at(of.view.image->level[level], seen->x() * scale + shift, seen->y() * scale + shift);
}

Eigen::Vector3d PanelPainter::place_of(int x, int y) const {
  const Eigen::Vector3d on_plane = picture_.plane.world(
      {picture_.area.low.x() + (x + 0.5) * picture_.pixel, picture_.area.high.y() - (y + 0.5) * picture_.pixel, 0});
  return place_on(face_, surface_, on_plane, picture_.plane.axes.col(2));
}

bool PanelPainter::on_panel(const Eigen::Vector3d& place) const {
  return std::abs(place.x()) <= 0.5 * face_.width && std::abs(place.y()) <= 0.5 * face_.height;
}

/// In the coarsest resolution, where noise and what is finer than photographs are apart is gone, as in what is
/// compared.
void PanelPainter::make_brightness_alike() {
  constexpr int places = 100;  // across and up
  std::vector<std::vector<float>> grey(views_.size());
  std::vector<float> middle;  // of all photographs, by place
  std::vector<float> here;
  for (int i = 0; i < places * places; ++i) {
    const double u = ((i % places + 0.5) / places - 0.5) * face_.width,
                 v = ((i / places + 0.5) / places - 0.5) * face_.height;
    const Eigen::Vector3d at = face_.plane.world({u, v, measured_ ? surface_.base(u, v).dot(surface_.form) : 0});
    here.clear();
    for (size_t k = 0; k < views_.size(); ++k) {
      grey[k].push_back(static_cast<float>(sample(k, at, Pyramid::levels - 1)));
      if (grey[k].back() >= 0) here.push_back(gain_[k] * grey[k].back() + offset_[k]);
    }
    middle.push_back(here.empty() ? -1 : median_of_floats(here));
  }
  std::vector<float> apart;
  for (size_t k = 0; k < views_.size(); ++k) {
    std::vector<float> own, of_all;
    for (size_t i = 0; i < middle.size(); ++i)
      if (grey[k][i] >= 0) own.push_back(grey[k][i]), of_all.push_back(middle[i]);
    if (own.size() < 10) continue;
    const auto [own_centre, own_spread] = centre_and_spread(own);
    const auto [centre, spread] = centre_and_spread(of_all);
    gain_[k] = own_spread > 2 && spread > 2 ? std::clamp(spread / own_spread, 0.5f, 2.0f) : 1;
    offset_[k] = centre - gain_[k] * own_centre;
    for (size_t i = 0; i < own.size(); ++i) apart.push_back(std::abs(gain_[k] * own[i] + offset_[k] - of_all[i]));
  }
  if (!apart.empty()) alike_ = std::clamp(1.5f * 1.4826f * median_of_floats(std::move(apart)), 8.0f, 16.0f);
}

PanelPainter::Strip PanelPainter::strip(int from, int to) const {
  Strip strip;
  const int halo = blur_ + shift_ + 1;
  strip.top = std::max(top_, from - halo);
  strip.width = right_ - left_ + 1, strip.height = std::min(bottom_, to - 1 + halo) - strip.top + 1;
  const size_t size = static_cast<size_t>(strip.width) * strip.height;
  strip.place.resize(size), strip.layers.resize(views_.size());
  for (auto& layer : strip.layers) layer.grey.assign(size, -1);
  for (int y = 0; y < strip.height; ++y) {
    stop_point();
    for (int x = 0; x < strip.width; ++x) {
      const size_t at = static_cast<size_t>(y) * strip.width + x;
      strip.place[at] = place_of(left_ + x, strip.top + y);
      if (std::abs(strip.place[at].x()) > 0.5 * face_.width + beyond_ ||
          std::abs(strip.place[at].y()) > 0.5 * face_.height + beyond_)
        continue;
      const Eigen::Vector3d world = face_.plane.world(strip.place[at]);
      for (size_t k = 0; k < views_.size(); ++k)
        strip.layers[k].grey[at] = static_cast<float>(sample(k, world, level_[k]));
    }
  }
  if (views_.size() < 2) return strip;
  for (size_t k = 0; k < views_.size(); ++k) {
    auto& layer = strip.layers[k];
    std::vector<float> means = box_means(layer.grey, strip.width, strip.height, blur_);
    for (size_t i = 0; i < size; ++i)  // of squares that are half beside the photograph nothing is said
      means[i] = layer.grey[i] < 0 ? -1 : std::max(0.0f, gain_[k] * means[i] + offset_[k]);
    layer.low = extremes(means, strip.width, strip.height, shift_, false);
    layer.high = extremes(std::move(means), strip.width, strip.height, shift_, true);
    layer.alike = layer.grey;
    for (float& value : layer.alike)
      if (value >= 0) value = std::max(0.0f, gain_[k] * value + offset_[k]);
    layer.darkest = extremes(layer.alike, strip.width, strip.height, shift_ + 1, false);
    layer.brightest = extremes(layer.alike, strip.width, strip.height, shift_ + 1, true);
  }
  return strip;
}

Shown PanelPainter::decide(const Strip& strip, size_t at, bool own, std::uint8_t& grey) const {
  std::vector<const Strip::Layer*> seen;
  for (const auto& layer : strip.layers)
    if (layer.grey[at] >= 0) seen.push_back(&layer);
  if (seen.empty()) return Shown::unseen;
  const auto take = [&](const Strip::Layer& from, Shown shown) {
    grey = static_cast<std::uint8_t>(std::max(1L, std::lround(from.grey[at])));
    return shown;
  };
  if (seen.size() < 2) return take(*seen.front(), Shown::unchecked);
  // The surroundings' mean tells what is there from what is not, and misses the border of what is not by half of it;
  // there the pixel itself is unlike all that others show near it.
  const auto agree = [&](const Strip::Layer& one, const Strip::Layer& other) {
    return std::max(one.low[at] - other.high[at], other.low[at] - one.high[at]) <= alike_ &&
           std::max(one.alike[at] - other.brightest[at], other.darkest[at] - one.alike[at]) <= 1.5f * alike_;
  };
  for (const Strip::Layer* one : seen) {
    size_t agreeing = 0;
    for (const Strip::Layer* other : seen) agreeing += agree(*one, *other);
    if (2 * agreeing > seen.size()) return take(*one, measured_ ? Shown::agreed : Shown::unchecked);
  }
  return own && measured_ ? Shown::contradicted : take(*seen.front(), Shown::unchecked);
}

PaintCounts PanelPainter::paint(int from, int to) const {
  PaintCounts counts;
  const Strip rows = strip(from, to);
  for (int y = from; y < to; ++y)
    for (int x = left_; x <= right_; ++x) {
      const size_t at = static_cast<size_t>(y - rows.top) * rows.width + static_cast<size_t>(x - left_);
      const size_t pixel = static_cast<size_t>(y) * picture_.width + x;
      const bool own = on_panel(rows.place[at]);
      if (!own && picture_.shown[pixel] != Shown::unseen) continue;
      std::uint8_t grey = 0;
      const Shown shown = decide(rows, at, own, grey);
      if (!own && shown == Shown::unseen) continue;
      picture_.grey[pixel] = grey, picture_.shown[pixel] = shown;
      if (!own) continue;
      counts.unseen += shown == Shown::unseen, counts.contradicted += shown == Shown::contradicted;
      counts.unchecked += shown == Shown::unchecked, counts.agreed += shown == Shown::agreed;
    }
  return counts;
}

}  // namespace plumbline::surface
