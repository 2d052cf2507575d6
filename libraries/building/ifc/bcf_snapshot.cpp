// The snapshot of a topic: an elevation drawn into palette pixels of four bits, packed as PNG (W3C PNG, second
// edition).
#include <zlib.h>

#include <algorithm>
#include <cmath>
#include <cstring>
#include <stdexcept>

#include "building/ifc/bcf_topic.hpp"

namespace plumbline::ifc {
namespace {

constexpr int kWidth = 640, kHeight = 480;
/// White, grey, black, then pass, undecided, fail in the colours of Okabe and Ito, light and full.
constexpr unsigned char kPalette[][3] = {{255, 255, 255}, {190, 195, 200}, {20, 24, 28},
                                         {0, 158, 115},   {230, 159, 0},   {213, 94, 0},
                                         {204, 236, 227}, {250, 236, 204}, {247, 223, 204}};

class Picture {
 public:
  Picture() : pixels_(static_cast<std::size_t>(kWidth) * kHeight, 0) {}
  void set(int x, int y, unsigned char colour) {
    if (x >= 0 && y >= 0 && x < kWidth && y < kHeight) pixels_[y * kWidth + x] = colour;
  }
  void box(double x0, double y0, double x1, double y1, unsigned char colour) {
    const int left = std::max(0, at(x0)), right = std::min(kWidth - 1, at(x1));
    if (left > right) return;
    for (int y = std::max(0, at(y0)), last = std::min(kHeight - 1, at(y1)); y <= last; ++y)
      std::fill_n(pixels_.begin() + y * kWidth + left, right - left + 1, static_cast<char>(colour));
  }
  void frame(double x0, double y0, double x1, double y1, int thick, unsigned char colour) {
    box(x0, y0, x1, y0 + thick, colour), box(x0, y1 - thick, x1, y1, colour);
    box(x0, y0, x0 + thick, y1, colour), box(x1 - thick, y0, x1, y1, colour);
  }
  /// Nothing of what reaches so far from there is in the picture.
  static bool outside(double x, double y, double r) {
    return x + r < 0 || y + r < 0 || x - r > kWidth || y - r > kHeight;
  }
  void disc(double x, double y, double r, unsigned char colour) {
    for (int j = at(y - r); j <= at(y + r); ++j)
      for (int i = at(x - r); i <= at(x + r); ++i)
        if (std::hypot(i - x, j - y) <= r) set(i, j, colour);
  }
  void triangle(double x, double y, double r, unsigned char colour) {
    for (int j = at(y - r); j <= at(y + r); ++j)
      for (int i = at(x - r); i <= at(x + r); ++i)
        if (std::abs(i - x) <= 0.5 * (j - (y - r))) set(i, j, colour);
  }
  std::string png() const;

 private:
  static int at(double v) { return static_cast<int>(std::lround(std::clamp(v, -10.0, 2000.0))); }
  std::string pixels_;
};

void put(std::string& to, std::uint32_t value) {
  for (int shift = 24; shift >= 0; shift -= 8) to += static_cast<char>(value >> shift & 0xFF);
}

void chunk(std::string& to, const std::string& type, const std::string& data) {
  put(to, static_cast<std::uint32_t>(data.size()));
  const std::string checked = type + data;
  to += checked;
  put(to, static_cast<std::uint32_t>(
              crc32(0, reinterpret_cast<const Bytef*>(checked.data()), static_cast<uInt>(checked.size()))));
}

/// zlib's stream of what is mostly runs of one colour: looking for runs only is ten times as fast, and there may be
/// thousands of topics.
std::string packed_runs(const std::string& raw) {
  z_stream stream{};
  if (deflateInit2(&stream, 6, Z_DEFLATED, 15, 8, Z_RLE) != Z_OK) throw std::runtime_error("zlib cannot start");
  std::string packed(deflateBound(&stream, static_cast<uLong>(raw.size())), '\0');
  stream.next_in = reinterpret_cast<Bytef*>(const_cast<char*>(raw.data()));
  stream.avail_in = static_cast<uInt>(raw.size());
  stream.next_out = reinterpret_cast<Bytef*>(packed.data());
  stream.avail_out = static_cast<uInt>(packed.size());
  deflate(&stream, Z_FINISH);
  packed.resize(stream.total_out);
  deflateEnd(&stream);
  return packed;
}

std::string Picture::png() const {
  // Filter "Up": each row as its difference to the one above, which mostly is nothing, in long runs. Rows that are
  // alike stay zero.
  constexpr std::size_t kBytes = kWidth / 2 + 1;
  std::string raw(kBytes * kHeight, '\0');
  const std::string white(kWidth, '\0');
  const char* above = white.data();
  for (int y = 0; y < kHeight; ++y) {
    char* out = raw.data() + static_cast<std::size_t>(y) * kBytes;
    const char* row = pixels_.data() + y * kWidth;
    *out++ = '\2';
    if (std::memcmp(row, above, kWidth) != 0) {
      const auto packed = [](const char* of, int i) { return of[2 * i] << 4 | of[2 * i + 1]; };
      for (int i = 0; i < kWidth / 2; ++i) out[i] = static_cast<char>(packed(row, i) - packed(above, i));
    }
    above = row;
  }
  const std::string packed = packed_runs(raw);
  std::string out = "\x89PNG\r\n\x1a\n", header, palette;
  put(header, kWidth), put(header, kHeight);
  header += std::string("\x04\x03\x00\x00\x00", 5);
  for (const auto& colour : kPalette)
    for (const unsigned char part : colour) palette += static_cast<char>(part);
  chunk(out, "IHDR", header), chunk(out, "PLTE", palette), chunk(out, "IDAT", packed), chunk(out, "IEND", "");
  return out;
}

unsigned char full_colour(ToleranceVerdict verdict) {
  return verdict == ToleranceVerdict::pass        ? 3
         : verdict == ToleranceVerdict::undecided ? 4
         : verdict == ToleranceVerdict::fail      ? 5
                                                  : 1;
}

}  // namespace

std::string snapshot_png(const BcfSurroundings& surroundings, const Eigen::Vector3d& centre, double reach,
                         const FacadeFrame& facade) {
  const double view = std::max(3.0, 2.5 * reach), scale = kHeight / (2 * view);
  const auto x = [&](const Eigen::Vector3d& p) { return kWidth / 2.0 + scale * facade.right.dot(p - centre); };
  const auto y = [&](const Eigen::Vector3d& p) { return kHeight / 2.0 - scale * facade.up.dot(p - centre); };
  // What hangs on another facade, or on another side of the court, is not seen from here.
  const auto shown = [&](const Eigen::Vector3d& p, const std::unique_ptr<FacadeFrameT>& frame) {
    return std::abs(facade.out.dot(p - centre)) < 3 &&
           (!frame || !frame->out.allFinite() || frame->out.dot(facade.out) > 0.5);
  };
  Picture picture;
  // What is drawn lies within the picture and 3 m before and behind it.
  const BcfSurroundings::Around around = surroundings.around(centre, std::hypot(view * kWidth / kHeight, view, 3));
  for (const PanelDeviationT* panel : around.panels) {
    Eigen::Vector3d low = Eigen::Vector3d::Zero(), high = Eigen::Vector3d::Zero();
    for (const auto& corner : panel->corners) {
      if (corner->name == "bottom_left") low = corner->design;
      if (corner->name == "top_right") high = corner->design;
    }
    if (!shown(low, panel->facade)) continue;
    const unsigned char colour = full_colour(panel->verdict);
    picture.box(x(low), y(high), x(high), y(low), colour > 2 ? static_cast<unsigned char>(colour + 3) : 0);
    picture.frame(x(low), y(high), x(high), y(low), 2, colour);
  }
  for (const AnchorDeviationT* anchor : around.anchors) {
    if (!anchor->design.allFinite() || !shown(anchor->design, anchor->facade)) continue;
    const double px = x(anchor->design), py = y(anchor->design);
    if (Picture::outside(px, py, 10)) continue;
    const unsigned char colour = full_colour(anchor->verdict);
    if (anchor->verdict == ToleranceVerdict::fail)
      picture.box(px - 7, py - 7, px + 7, py + 7, colour);
    else if (anchor->verdict == ToleranceVerdict::undecided)
      picture.triangle(px, py, 9, colour);
    else
      picture.disc(px, py, 7, colour);
  }
  const double half = std::max(18.0, scale * reach * 1.15);
  picture.frame(kWidth / 2.0 - half, kHeight / 2.0 - half, kWidth / 2.0 + half, kHeight / 2.0 + half, 3, 2);
  return picture.png();
}

}  // namespace plumbline::ifc
