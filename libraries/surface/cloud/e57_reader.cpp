// E57 (ASTM E2807): the packets of a compressed vector, each with a stretch of every field's stream of bits.
#include "surface/cloud/e57_scans.hpp"

namespace plumbline::cloud {
namespace {

/// The stream of one field: what came and was not read yet.
class BitStream {
 public:
  explicit BitStream(const E57Field& field) : field_(field) {}
  void append(const char* bytes, std::size_t count) {
    // What was read goes, but only in large pieces; eight bytes behind the end may be looked at.
    if (first_ / 8 > bytes_.size() / 2) {
      bytes_.erase(bytes_.begin(), bytes_.begin() + static_cast<std::ptrdiff_t>(first_ / 8));
      end_ -= first_ / 8, first_ %= 8;
    }
    bytes_.resize(end_ + count + 16);
    std::memcpy(bytes_.data() + end_, bytes, count);
    end_ += count;
  }
  std::uint64_t ready(std::uint64_t most) const {
    return field_.bits == 0
               ? most
               : std::min<std::uint64_t>(most, (8 * end_ - first_) / static_cast<std::uint64_t>(field_.bits));
  }
  double next() {
    const std::uint64_t stored = bits();
    if (field_.kind == E57Field::Kind::double_float) return std::bit_cast<double>(stored);
    if (field_.kind == E57Field::Kind::single_float)
      return static_cast<double>(std::bit_cast<float>(static_cast<std::uint32_t>(stored)));
    const auto whole = static_cast<std::int64_t>(stored + static_cast<std::uint64_t>(field_.minimum));
    return static_cast<double>(whole) * field_.scale + field_.offset;
  }

 private:
  std::uint64_t bits() {
    if (field_.bits == 0) return 0;
    const auto shift = static_cast<int>(first_ % 8);
    const unsigned char* at = bytes_.data() + first_ / 8;
    std::uint64_t value;
    std::memcpy(&value, at, 8);
    value >>= shift;
    if (shift + field_.bits > 64) value |= static_cast<std::uint64_t>(at[8]) << (64 - shift);
    first_ += static_cast<std::uint64_t>(field_.bits);
    return field_.bits == 64 ? value : value & ((1ULL << field_.bits) - 1);
  }

  const E57Field& field_;
  std::vector<unsigned char> bytes_;
  std::uint64_t end_ = 0, first_ = 0;  ///< bytes that are there; the next bit
};

/// Steps of the scan's own coordinates, as an upper bound in those of the file.
void take_steps(const E57Scan& scan, double farthest, const Eigen::Vector3d& floats, Eigen::Vector3d& steps) {
  Eigen::Vector3d own;
  for (int i = 0; i < 3; ++i) {
    const E57Field& field = scan.fields[scan.coordinates[i]];
    own(i) = field.kind == E57Field::Kind::integer        ? std::abs(field.scale)
             : field.kind == E57Field::Kind::single_float ? floats(i)
                                                          : 0;
  }
  if (scan.spherical) own.setConstant(std::max(own(0), farthest * std::max(own(1), own(2))));
  steps = steps.cwiseMax(scan.rotation.toRotationMatrix().cwiseAbs() * own);
}

class ScanPoints {
 public:
  ScanPoints(E57Pages& pages, const E57Scan& scan, size_t number, CloudSummary& summary, PointBatch& batch)
      : pages_(pages),
        scan_(scan),
        number_(number),
        summary_(summary),
        batch_(batch),
        turn_(scan.rotation.toRotationMatrix()) {
    where_ = "the points of scan " + std::to_string(number);
    for (const E57Field& field : scan.fields) streams_.emplace_back(field);
    for (size_t f = 0; f < streams_.size(); ++f)
      wanted_.push_back(static_cast<int>(f) == scan.coordinates[0] || static_cast<int>(f) == scan.coordinates[1] ||
                        static_cast<int>(f) == scan.coordinates[2] || static_cast<int>(f) == scan.invalid);
  }

  void read() {
    if (scan_.points == 0) return;
    pages_.seek_physical(scan_.points_at, where_.c_str());
    char head[32];
    const std::uint64_t begin = pages_.position();
    pages_.read(head, sizeof head, where_.c_str());
    if (head[0] != 1)
      fail("a section of the kind " + std::to_string(static_cast<int>(static_cast<unsigned char>(head[0]))) +
           ", expected 1, a compressed vector");
    const auto length = number_at<std::uint64_t>(head + 8);
    pages_.seek_physical(number_at<std::uint64_t>(head + 16), where_.c_str());
    while (done_ < scan_.points) {
      if (pages_.position() - begin >= length)
        fail("its packets end after " + std::to_string(done_) + " of " + std::to_string(scan_.points) + " points");
      packet();
    }
    take_steps(scan_, farthest_, Eigen::Vector3d(step_(0), step_(1), step_(2)), summary_.resolution);
  }

 private:
  [[noreturn]] void fail(const std::string& what) {
    pages_.stream().fail_at_byte(pages_.physical(), where_ + ": " + what);
  }

  void packet() {
    const std::uint64_t begin = pages_.position();
    char head[6];
    pages_.read(head, 4, where_.c_str());
    const std::uint64_t length = 1ULL + number_at<std::uint16_t>(head + 2);
    const int kind = static_cast<unsigned char>(head[0]);
    if (kind == 0 || kind == 2) {  // an index, and one that holds nothing
      if (length < 4) fail("a packet of " + std::to_string(length) + " bytes");
      pages_.skip(length - 4);
      return;
    }
    if (kind != 1) fail("a packet of the kind " + std::to_string(kind) + ", expected 0 (index), 1 (data) or 2 (empty)");
    pages_.read(head + 4, 2, where_.c_str());
    const std::uint64_t count = number_at<std::uint16_t>(head + 4);
    if (count != streams_.size())
      fail("a packet of " + std::to_string(count) + " streams, its points have " + std::to_string(streams_.size()) +
           " fields");
    std::vector<char> content(length < 6 ? 0 : length - 6);
    pages_.read(content.data(), content.size(), where_.c_str());
    std::uint64_t at = 2 * count;
    if (at > content.size())
      fail("a packet of " + std::to_string(length) + " bytes is shorter than its own list of streams");
    bool anything = false;
    for (size_t f = 0; f < streams_.size(); ++f) {
      const std::uint64_t bytes = number_at<std::uint16_t>(content.data() + 2 * f);
      if (at + bytes > content.size())
        fail("the streams of a packet are longer than its " + std::to_string(length) + " bytes");
      if (wanted_[f]) streams_[f].append(content.data() + at, bytes);
      at += bytes, anything = anything || bytes > 0;
    }
    if (!anything && pages_.position() == begin + 6 + 2 * count && ++empty_ > 1000)
      fail("a thousand packets without content");
    unpack();
  }

  void unpack() {
    std::uint64_t ready = scan_.points - done_;
    for (size_t f = 0; f < streams_.size(); ++f)
      if (wanted_[f]) ready = streams_[f].ready(ready);
    for (std::uint64_t i = 0; i < ready; ++i) {
      Eigen::Vector3d own;
      for (int c = 0; c < 3; ++c) own(c) = streams_[scan_.coordinates[c]].next();
      const bool said = scan_.invalid >= 0 && streams_[scan_.invalid].next() != 0;
      if (said || !own.allFinite()) {  // an infinite number would be the largest, and its step none
        ++summary_.without_place;
        continue;
      }
      take_float_steps(own);
      if (scan_.spherical) {
        farthest_ = std::max(farthest_, own(0));
        own = own(0) * Eigen::Vector3d(std::cos(own(2)) * std::cos(own(1)), std::cos(own(2)) * std::sin(own(1)),
                                       std::sin(own(2)));
      }
      batch_.add(turn_ * own + scan_.translation, number_ - 1);
    }
    done_ += ready;
  }

  /// What a 32-bit float of that size can tell apart.
  void take_float_steps(const Eigen::Vector3d& own) {
    for (int c = 0; c < 3; ++c) {
      if (!(std::abs(own(c)) > largest_(c))) continue;
      largest_(c) = std::abs(own(c));
      const auto value = static_cast<float>(largest_(c));
      step_(c) = static_cast<double>(std::nextafter(value, std::numeric_limits<float>::infinity())) -
                 static_cast<double>(value);
    }
  }

  E57Pages& pages_;
  const E57Scan& scan_;
  size_t number_;
  CloudSummary& summary_;
  PointBatch& batch_;
  Eigen::Matrix3d turn_;
  std::string where_;
  std::vector<BitStream> streams_;
  std::vector<char> wanted_;
  std::uint64_t done_ = 0;
  int empty_ = 0;
  double farthest_ = 0;
  Eigen::Vector3d largest_ = Eigen::Vector3d::Zero(), step_ = Eigen::Vector3d::Zero();
};

}  // namespace

CloudSummary read_e57(CloudStream& stream, const PointSink& sink) {
  E57Pages pages(stream);
  const std::vector<E57Scan> scans = e57_scans(pages.xml(), stream);
  if (scans.empty()) stream.fail("there is no scan in it ('data3D' has no children)");
  CloudSummary summary;
  summary.format = "E57, " + std::to_string(scans.size()) + (scans.size() == 1 ? " scan" : " scans");
  summary.unit = 1, summary.scans = static_cast<int>(scans.size());
  for (const E57Scan& scan : scans) summary.without_pose += !scan.has_pose;
  if (summary.without_pose == summary.scans) summary.without_pose = 0;  // registered and written as it lies
  if (!sink) return summary;
  PointBatch batch(summary, stream, sink);
  for (size_t s = 0; s < scans.size(); ++s) ScanPoints(pages, scans[s], s + 1, summary, batch).read();
  batch.flush();
  return summary;
}

}  // namespace plumbline::cloud
