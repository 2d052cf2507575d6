#include "show/report/image_block_drawing.hpp"

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>

#include "photo/images/grey_image.hpp"
#include "show/report/format.hpp"
#include "show/report/language.hpp"
#include "show/report/plot.hpp"

namespace plumbline::report {
namespace {

/// Axes of the drawing: right and up; the third is towards the reader.
struct View {
  Eigen::Vector3d right, up;
  std::string caption;
};

/// Two views that fit the points: onto the plane they spread over most, and along it.
std::array<View, 2> views_of(const std::vector<DrawnCamera>& cameras, const std::vector<DrawnPoint>& points) {
  Eigen::Vector3d mean = Eigen::Vector3d::Zero(), towards = Eigen::Vector3d::Zero();
  for (const auto& p : points) mean += p.position / static_cast<double>(points.size());
  Eigen::Matrix3d spread = Eigen::Matrix3d::Zero();
  for (const auto& p : points) spread += (p.position - mean) * (p.position - mean).transpose();
  for (const auto& c : cameras) towards += (c.centre - mean).normalized();
  const Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> axes(spread);
  Eigen::Vector3d normal = axes.eigenvectors().col(0), right = axes.eigenvectors().col(2);
  if (normal.dot(towards) < 0) normal = -normal;
  Eigen::Index largest = 0;
  right.cwiseAbs().maxCoeff(&largest);
  if (right(largest) < 0) right = -right;
  const Eigen::Vector3d up = normal.cross(right);
  return {View{right, up, "As the photographs look at the points"},
          View{right, -normal, "From the edge of the same plane"}};
}

void draw_view(Markup& html, const View& view, const std::vector<DrawnCamera>& cameras,
               const std::vector<DrawnPoint>& points) {
  constexpr double width = 520, height = 400, margin = 24;
  double left = 1e300, right = -1e300, low = 1e300, high = -1e300;
  const auto take = [&](const Eigen::Vector3d& p) {
    left = std::min(left, p.dot(view.right)), right = std::max(right, p.dot(view.right));
    low = std::min(low, p.dot(view.up)), high = std::max(high, p.dot(view.up));
  };
  for (const auto& c : cameras) take(c.centre);
  for (const auto& p : points) take(p.position);
  const double extent = std::max({(right - left) / (width - 2 * margin), (high - low) / (height - 2 * margin), 1e-9});
  const auto x = [&](const Eigen::Vector3d& p) {
    return 0.5 * width + (p.dot(view.right) - 0.5 * (left + right)) / extent;
  };
  const auto y = [&](const Eigen::Vector3d& p) {
    return 0.5 * height - (p.dot(view.up) - 0.5 * (low + high)) / extent;
  };
  Scope figure(html, "figure");
  {
    Scope svg = drawing(html, width, height, view.caption);
    LabelPlacer labels({0, 0, width, height}, 11);
    for (const auto& c : cameras) {
      const Eigen::Vector3d tip = c.centre + 22 * extent * c.forward;
      line(html, x(c.centre), y(c.centre), x(tip), y(tip), "bar");
      html.empty("rect", {{"x", px(x(c.centre) - 3.5)},
                          {"y", px(y(c.centre) - 3.5)},
                          {"width", "7"},
                          {"height", "7"},
                          {"class", "mean"}});
    }
    for (const auto& p : points)
      html.empty("circle", {{"cx", px(x(p.position))}, {"cy", px(y(p.position))}, {"r", "2.2"}, {"class", "dot"}});
    if (points.size() <= 120)
      for (const auto& p : points) labels.place(html, x(p.position), y(p.position), 4, verbatim(p.name), "small halo");
    if (cameras.size() <= 20)
      for (const auto& c : cameras) labels.place(html, x(c.centre), y(c.centre), 6, verbatim(c.name), "small halo");
    const double bar = round_down(0.3 * (width - 2 * margin) * extent);
    line(html, margin, height - 10, margin + bar / extent, height - 10, "axis");
    label(html, margin + bar / extent + 6, height - 6,
          bar < 0.1 ? mm_unit(bar, bar < 0.01 ? 1 : 0) : fixed(bar, bar < 1 ? 1 : 0) + "\u00a0m", "small", "start");
  }
  html.element("figcaption", view.caption + ".");
}

}  // namespace

void draw_scene(Markup& html, const std::vector<DrawnCamera>& cameras, const std::vector<DrawnPoint>& points) {
  if (points.size() < 3) return;
  Scope pair(html, "div", {{"class", "pair"}});
  for (const View& view : views_of(cameras, points)) draw_view(html, view, cameras, points);
}

void draw_residuals(Markup& html, int width, int height, const std::vector<DrawnResidual>& residuals) {
  if (residuals.empty() || width <= 0 || height <= 0) return;
  constexpr double drawn_width = 760;
  constexpr size_t most = 3000;
  const double scale = drawn_width / width, drawn_height = scale * height;
  std::vector<double> lengths;
  for (const auto& r : residuals) lengths.push_back(r.residual.norm());
  std::nth_element(lengths.begin(), lengths.begin() + static_cast<std::ptrdiff_t>(lengths.size() * 9 / 10),
                   lengths.end());
  const double typical = std::max(1e-6, lengths[lengths.size() * 9 / 10]), factor = 16 / typical;
  const size_t step = (residuals.size() + most - 1) / most;
  Scope figure(html, "figure");
  {
    Scope svg = drawing(html, drawn_width, drawn_height, "Residuals over the image");
    html.empty("rect", {{"x", "0.5"},
                        {"y", "0.5"},
                        {"width", px(drawn_width - 1)},
                        {"height", px(drawn_height - 1)},
                        {"class", "band-edge"}});
    for (size_t i = 0; i < residuals.size(); i += step) {
      const double x = scale * residuals[i].at.x(), y = scale * residuals[i].at.y();
      const Eigen::Vector2d d =
          std::min(1.0, 60 / std::max(1e-9, factor * residuals[i].residual.norm())) * factor * residuals[i].residual;
      line(html, x, y, x + d.x(), y + d.y(), "bar");
      html.empty("circle", {{"cx", px(x)}, {"cy", px(y)}, {"r", "1"}, {"class", "dot"}});
    }
  }
  html.element("figcaption", "Residuals over the image, measured minus computed; nine in ten are shorter than " +
                                 fixed(typical, 2) + " px, which is drawn " + fixed(factor * typical, 0) + " px long" +
                                 (step > 1 ? "; every " + std::to_string(step) + "th is drawn" : "") +
                                 ". Arrows that turn together over a region show a lens that the model does not fit.");
}

namespace {

constexpr double cell_size = 4;  ///< of the drawing

/// `cells` × `cells` grey values of the square at (x0, y0), in runs of one value.
void draw_pixels(Markup& html, const GreyImage& image, double x0, double y0, double side, int cells) {
  const double step = side / cells;
  for (int row = 0; row < cells; ++row) {
    for (int column = 0; column < cells;) {
      const auto grey = [&](int c) {
        const int x = static_cast<int>(std::lround(x0 + (c + 0.5) * step)),
                  y = static_cast<int>(std::lround(y0 + (row + 0.5) * step));
        if (x < 0 || y < 0 || x >= image.width || y >= image.height) return -1;
        return static_cast<int>(image.pixels[static_cast<size_t>(y) * image.width + x]) & 0xf8;
      };
      const int value = grey(column);
      int end = column + 1;
      while (end < cells && grey(end) == value) ++end;
      if (value >= 0) {
        const std::string v = std::to_string(value);
        html.empty("rect", {{"x", px(column * cell_size)},
                            {"y", px(row * cell_size)},
                            {"width", px((end - column) * cell_size)},
                            {"height", px(cell_size)},
                            {"fill", "rgb(" + v + "," + v + "," + v + ")"}});
      }
      column = end;
    }
  }
}

void draw_ring(Markup& html, double x, double y) {
  html.empty(
      "circle",
      {{"cx", px(x)}, {"cy", px(y)}, {"r", "4"}, {"fill", "none"}, {"stroke", "#d55e00"}, {"stroke-width", "2"}});
}

}  // namespace

void draw_crop(Markup& html, const GreyImage& image, const std::vector<Eigen::Vector2d>& corners) {
  constexpr int cells = 48;
  double left = 1e9, right = -1e9, top = 1e9, bottom = -1e9;
  for (const auto& c : corners) {
    left = std::min(left, c.x()), right = std::max(right, c.x());
    top = std::min(top, c.y()), bottom = std::max(bottom, c.y());
  }
  const double side = std::max({1.3 * (right - left), 1.3 * (bottom - top), 24.0}), unit = cells * cell_size / side;
  const double x0 = 0.5 * (left + right) - 0.5 * side, y0 = 0.5 * (top + bottom) - 0.5 * side;
  Scope svg = drawing(html, cells * cell_size, cells * cell_size, "The tag in the photograph");
  draw_pixels(html, image, x0, y0, side, cells);
  for (const auto& c : corners) draw_ring(html, (c.x() - x0) * unit, (c.y() - y0) * unit);
}

void draw_corner(Markup& html, const GreyImage& image, const Eigen::Vector2d& measured,
                 const Eigen::Vector2d& computed) {
  constexpr int cells = 48;
  const double side = std::max(16.0, 3 * (measured - computed).cwiseAbs().maxCoeff()), unit = cells * cell_size / side;
  const double x0 = measured.x() - 0.5 * side, y0 = measured.y() - 0.5 * side;
  Scope svg = drawing(html, cells * cell_size, cells * cell_size, "Its worst corner, measured and computed");
  draw_pixels(html, image, x0, y0, side, cells);
  draw_ring(html, (measured.x() - x0) * unit, (measured.y() - y0) * unit);
  const double x = (computed.x() - x0) * unit, y = (computed.y() - y0) * unit;
  for (const double sign : {-1.0, 1.0})
    html.empty("line", {{"x1", px(x - 6)},
                        {"y1", px(y - 6 * sign)},
                        {"x2", px(x + 6)},
                        {"y2", px(y + 6 * sign)},
                        {"stroke", "#0072b2"},
                        {"stroke-width", "2"}});
}

}  // namespace plumbline::report
