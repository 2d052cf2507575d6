#include "surface/cloud/cloud_file.hpp"

#include <algorithm>
#include <charconv>
#include <filesystem>

#include "surface/cloud/cloud_stream.hpp"

namespace plumbline::cloud {
namespace {

constexpr std::uint64_t kLongestLine = 1 << 20;

CloudSummary read_any(const std::string& path, const PointSink& sink) {
  CloudStream stream(path);
  char first[16] = {};
  stream.read(first, std::min<std::uint64_t>(stream.size(), sizeof first), "its first bytes");
  stream.seek(0);
  const std::string head(first, sizeof first);
  if (head.starts_with("ply") && (head[3] == '\n' || head[3] == '\r')) return read_ply(stream, sink);
  if (head.starts_with("LASF")) return read_las(stream, sink);
  if (head.starts_with("ASTM-E57")) return read_e57(stream, sink);
  if (head.starts_with("# .PCD") || head.starts_with("VERSION"))
    stream.fail("this is a PCD file, which is not read; expected PLY, LAS, E57, PTS or XYZ");
  return read_text(stream, sink);
}

}  // namespace

CloudStream::CloudStream(const std::string& path)
    : name_(std::filesystem::path(path).filename().string()), stream_(path, std::ios::binary) {
  std::error_code error;
  if (!std::filesystem::is_regular_file(path, error)) fail("there is no such file: " + path);
  size_ = std::filesystem::file_size(path, error);
  if (!stream_ || error) fail("the file cannot be read: " + path);
  if (size_ == 0) fail("the file is empty; expected a point cloud as PLY, LAS, E57, PTS or XYZ");
}

void CloudStream::seek(std::uint64_t position) {
  position_ = std::min(position, size_);
  stream_.clear();
  stream_.seekg(static_cast<std::streamoff>(position_));
}

void CloudStream::read(char* to, std::uint64_t bytes, const char* what) {
  if (bytes > left())
    fail_at_byte(position_,
                 "the file ends after " + std::to_string(size_) + " bytes, within " + what + "; it was cut short");
  stream_.read(to, static_cast<std::streamsize>(bytes));
  if (!stream_) fail_at_byte(position_, std::string("cannot be read, within ") + what);
  position_ += bytes;
}

bool CloudStream::line(std::string& to) {
  buffer_.resize(kLongestLine);
  stream_.getline(buffer_.data(), static_cast<std::streamsize>(buffer_.size()));
  const auto got = static_cast<std::uint64_t>(stream_.gcount());  // with the line's end
  if (got == 0) return false;
  position_ += got;
  if (stream_.fail()) fail_at_byte(position_, "a line of more than 1 MiB: this is no text with a point a line");
  const bool ended = !stream_.eof();
  to.assign(buffer_.data(), got - (ended ? 1 : 0));
  ++line_;
  if (!to.empty() && to.back() == '\r') to.pop_back();
  return true;
}

void CloudStream::fail_at_byte(std::uint64_t byte, const std::string& what) const {
  throw CloudError(name_ + ", byte " + std::to_string(byte) + ": " + what);
}

void CloudStream::fail_at_line(const std::string& what) const {
  throw CloudError(name_ + ", line " + std::to_string(line_) + ": " + what);
}

void CloudStream::fail(const std::string& what) const { throw CloudError(name_ + ": " + what); }

double step_of_text(std::string_view word) {
  const size_t power = std::min(word.find_first_of("eE"), word.size()), point = word.substr(0, power).find('.');
  double exponent = 0;
  if (power < word.size()) {
    std::string_view digits = word.substr(power + 1);
    if (digits.starts_with('+')) digits.remove_prefix(1);
    std::from_chars(digits.data(), digits.data() + digits.size(), exponent);
  }
  const double decimals = point == std::string_view::npos ? 0 : static_cast<double>(power - point - 1);
  return std::pow(10.0, exponent - decimals);
}

Eigen::Vector3d Steps::found() const {
  Eigen::Vector3d steps;
  for (Eigen::Index axis = 0; axis < 3; ++axis) {
    const auto largest = static_cast<float>(largest_(axis));
    const double of_float = static_cast<double>(std::nextafter(largest, std::numeric_limits<float>::infinity())) -
                            static_cast<double>(largest);
    const bool floats = declared_[axis] || (floats_[axis] && several_[axis]);
    steps(axis) = std::max(std::isfinite(finest_(axis)) ? finest_(axis) : 0, floats ? of_float : 0);
  }
  return steps;
}

CloudSummary look_at_cloud(const std::string& path) { return read_any(path, {}); }

CloudSummary read_cloud(const std::string& path, const PointSink& sink) {
  const CloudSummary summary = read_any(path, sink);
  const std::string name = std::filesystem::path(path).filename().string();
  if (summary.points > 0) return summary;
  if (summary.without_place > 0)
    throw CloudError(name + ": none of its " + std::to_string(summary.without_place) +
                     " points has coordinates, all are NaN or infinite");
  if (summary.withheld > 0)
    throw CloudError(name + ": all of its " + std::to_string(summary.withheld) +
                     " points are marked as withheld or noise");
  throw CloudError(name + ": there is no point in it");
}

}  // namespace plumbline::cloud
