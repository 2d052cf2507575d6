#include "point_files.hpp"

#include <bit>
#include <charconv>
#include <cmath>
#include <cstring>
#include <map>
#include <stdexcept>

#include "geometry/packed_symmetric.hpp"

namespace plumbline::survey {

namespace {

static_assert(std::endian::native == std::endian::little, "the .npy header says so");

void write_number(double value, std::string& out) {
  if (!std::isfinite(value)) {
    out += "null";
    return;
  }
  char text[32];
  const auto end = std::to_chars(text, text + sizeof text, value).ptr;
  out.append(text, end);
}

void write_text(const std::string& text, std::string& out) {
  static const char* const hex = "0123456789abcdef";
  out += '"';
  for (const char c : text) {
    const auto byte = static_cast<unsigned char>(c);
    if (c == '"' || c == '\\')
      out += '\\', out += c;
    else if (byte < 0x20)
      out += "\\u00", out += hex[byte >> 4], out += hex[byte & 15];
    else
      out += c;
  }
  out += '"';
}

void write_vector(const Eigen::Vector3d& v, std::string& out) {
  for (int k = 0; k < 3; ++k) {
    out += k ? ", " : "[";
    write_number(v[k], out);
  }
  out += ']';
}

/// Element of the packed lower triangle.
double element(const std::vector<double>& packed, std::size_t i, std::size_t j) {
  return packed[i >= j ? packed_size(i) + j : packed_size(j) + i];
}

void check(const PointsT& points) {
  if (!points.covariance.empty() && points.covariance.size() != packed_size(3 * points.points.size()))
    throw std::runtime_error("the covariance of the points has " + std::to_string(points.covariance.size()) +
                             " values, expected " + std::to_string(packed_size(3 * points.points.size())));
}

}  // namespace

std::string points_as_json(const PointsT& points, const SurveyNetworkT& network) {
  check(points);
  std::map<std::string, const std::vector<double>*> own;  // of a network without a joint covariance
  if (points.covariance.empty())
    for (const auto& entry : network.covariances)
      if (entry->to.empty()) own[entry->from] = &entry->values;
  std::string out = "{\n  \"frame\": \"E, N, H [m]\",\n  \"points\": [";
  for (std::size_t p = 0; p < points.points.size(); ++p) {
    const PointT& point = *points.points[p];
    out += p ? ",\n    {\"id\": " : "\n    {\"id\": ";
    write_text(point.id, out);
    out += ", \"position\": ";
    write_vector(point.position, out);
    out += ", \"sigma\": ";
    write_vector(point.sigma, out);
    out += ", \"covariance\": ";
    const auto single = own.find(point.id);
    if (points.covariance.empty() && single == own.end()) {
      out += "null}";
      continue;
    }
    for (std::size_t i = 0; i < 3; ++i) {
      out += i ? ", " : "[";
      Eigen::Vector3d row;
      for (std::size_t j = 0; j < 3; ++j)
        row[static_cast<Eigen::Index>(j)] =
            single != own.end() ? element(*single->second, i, j) : element(points.covariance, 3 * p + i, 3 * p + j);
      write_vector(row, out);
    }
    out += "]}";
  }
  return out + "\n  ]\n}\n";
}

std::string covariance_as_npy(const PointsT& points, bool wanted) {
  check(points);
  const std::size_t n = wanted && !points.covariance.empty() ? 3 * points.points.size() : 0;
  std::string header =
      "{'descr': '<f8', 'fortran_order': False, 'shape': (" + std::to_string(n) + ", " + std::to_string(n) + "), }";
  header.append(63 - (10 + header.size()) % 64, ' ');
  header += '\n';
  std::string out = "\x93NUMPY";
  out += '\x01', out += '\0';
  out += static_cast<char>(header.size() & 255), out += static_cast<char>(header.size() >> 8);
  out += header;
  const std::size_t at = out.size();
  out.resize(at + 8 * n * n);
  for (std::size_t i = 0; i < n; ++i)
    for (std::size_t j = 0; j < n; ++j) {
      const double value = element(points.covariance, i, j);
      std::memcpy(out.data() + at + 8 * (i * n + j), &value, 8);
    }
  return out;
}

}  // namespace plumbline::survey
