#include "photo/detect/edge_samples.hpp"

#include <algorithm>
#include <cmath>

#include "photo/images/grey_image.hpp"

namespace plumbline::detect {
namespace {

/// Narrows [from, to] to the x with |x · slope + rest| <= limit.
void narrow(double slope, double rest, double limit, double& from, double& to) {
  if (std::abs(slope) < 1e-9) {
    if (std::abs(rest) > limit) to = from - 1;
    return;
  }
  const double a = (-limit - rest) / slope, b = (limit - rest) / slope;
  from = std::max(from, std::min(a, b));
  to = std::min(to, std::max(a, b));
}

}  // namespace

EdgeFrame edge_frame(const Eigen::Vector2d& start, const Eigen::Vector2d& end) {
  EdgeFrame frame;
  const Eigen::Vector2d span = end - start;
  frame.half_length = 0.5 * span.norm();
  frame.centre = 0.5 * (start + end);
  frame.along = span.normalized();
  frame.across = {-frame.along.y(), frame.along.x()};
  frame.box = frame.across.cwiseAbs().maxCoeff();
  return frame;
}

TransferCurve::TransferCurve(double gamma) : gamma_(gamma), offset_(255 * 0.055 * (gamma - 1) / (2.4 - 1)) {
  for (std::size_t i = 0; i < 256; ++i) {
    light_[i] = static_cast<float>(to_light(static_cast<double>(i)));
    weight_[i] = static_cast<float>(1 / light_slope(static_cast<double>(i)));
  }
}

double TransferCurve::to_light(double grey) const { return std::pow(share(grey), gamma_); }

double TransferCurve::to_grey(double light) const {
  return std::pow(std::max(light, 0.0), 1 / gamma_) * (255 + offset_) - offset_;
}

double TransferCurve::light_slope(double grey) const {
  return gamma_ * std::pow(share(grey), gamma_ - 1) / (255 + offset_);
}

double TransferCurve::share(double grey) const {
  // A power has no slope at zero; half a grey value is below what is recorded.
  return (gamma_ == 1 ? grey : std::max(grey, 0.5) + offset_) / (255 + offset_);
}

void EdgeSamples::collect(const GreyImage& image, const EdgeFrame& frame, const Eigen::Vector3d& shape, double margin,
                          double reach, std::size_t stride, const SamplingGrid& grid, const Eigen::Vector2i& origin) {
  count = 0;
  const double t_limit = 1 - margin / frame.half_length;
  if (!(t_limit > 0)) return;
  const double length = frame.half_length * t_limit;
  const double width = reach + shape.cwiseAbs().sum();
  const Eigen::Vector2d half = (frame.along * length).cwiseAbs() + (frame.across * width).cwiseAbs();
  const Eigen::Vector2d low = frame.centre - half, high = frame.centre + half;
  if (low.x() < 0 || low.y() < 0 || high.x() > image.width - 1 || high.y() > image.height - 1) return;
  const Eigen::Vector2d along = frame.along / frame.half_length;
  const int step = static_cast<int>(stride);
  const bool is_even = grid.period <= 1;
  const double off = is_even ? 0 : 1;  // [px], more than any pixel lies off its place
  int skip = 0;                        // pixels of the row until the next that is taken
  for (int y = static_cast<int>(std::ceil(low.y())); y <= static_cast<int>(high.y()); ++y) {
    const double dy = y + grid.row(y + origin.y()) - frame.centre.y();
    double from = low.x() - frame.centre.x(), to = high.x() - frame.centre.x();
    narrow(frame.along.x(), frame.along.y() * dy, length + off, from, to);
    narrow(frame.across.x(), frame.across.y() * dy, width + off, from, to);
    const std::uint8_t* row = &image.pixels[static_cast<std::size_t>(y) * image.width];
    const int first = std::max(0, static_cast<int>(std::ceil(from + frame.centre.x())));
    const int last = std::min(image.width - 1, static_cast<int>(std::floor(to + frame.centre.x())));
    if (last < first) continue;
    const std::size_t room = count + static_cast<std::size_t>(last - first) + 1;
    if (t.size() < room) t.resize(2 * room), d.resize(2 * room), grey.resize(2 * room);
    int x = first + skip;
    for (; x <= last; x += step) {
      const double dx = x + (is_even ? 0 : grid.column(x + origin.x())) - frame.centre.x();
      const double place = dx * along.x() + dy * along.y(), distance = dx * frame.across.x() + dy * frame.across.y();
      t[count] = static_cast<float>(place), d[count] = static_cast<float>(distance), grey[count] = row[x];
      count += (std::abs(place) <= t_limit) &
               (std::abs(distance - (shape[0] + place * (shape[1] + place * shape[2]))) <= reach);
    }
    skip = x - last - 1;
  }
}

void EdgeSamples::record(const TransferCurve& curve) {
  const std::size_t size = padded();
  if (t.size() < size) t.resize(size), d.resize(size);
  if (light.size() < size) light.resize(t.size()), weight.resize(t.size());
  for (std::size_t i = 0; i < count; ++i) {
    light[i] = curve.recorded_light(grey[i]);
    weight[i] = curve.recorded_weight(grey[i]);
  }
  for (std::size_t i = count; i < size; ++i) t[i] = d[i] = light[i] = weight[i] = 0;
}

}  // namespace plumbline::detect
