// Point clouds as files for programs of others: LAS 1.4 and PLY, each point with its standard deviation.
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <fstream>
#include <string>

#include "surface/cloud/cloud_file.hpp"

namespace plumbline::cloud {

enum class CloudFormat {
  las,  ///< LAS 1.4, point format 6 (ASPRS, R15), in steps of 0.1 mm; "sigma" as extra bytes; metres and the frame by
        ///< WKT
  ply,  ///< binary, little-endian, x, y, z as doubles, sigma as float, metres and the frame as comments
};

/// Writes points one after the other. Throws CloudError if the disk refuses.
class CloudWriter {
 public:
  /// `count`: of the points that will come; `near`: a place among them [m], which LAS counts from; `frame`: name
  /// of the frame that the points are in, which the file says, or that nobody said it. Throws CloudError for a name
  /// that no file can hold: more than 200 characters, a quotation mark or a line break.
  CloudWriter(const std::string& path, CloudFormat format, std::uint64_t count, const Eigen::Vector3d& near,
              const std::string& frame);
  /// `point` and `sigma`, its standard deviation along the surface's normal, in metres. Throws CloudError for a point
  /// that LAS cannot hold: one without place, or further than 200 km from `near`.
  void add(const Eigen::Vector3d& point, float sigma);
  /// Ends the file. Throws CloudError if another number of points came than was announced.
  void finish();

 private:
  void write(const std::string& bytes);
  std::string path_;
  CloudFormat format_;
  std::string frame_;
  std::ofstream file_;
  std::uint64_t announced_ = 0, written_ = 0;
  Eigen::Vector3d offset_ = Eigen::Vector3d::Zero();
  Eigen::Vector3d low_ = Eigen::Vector3d::Constant(std::numeric_limits<double>::infinity()), high_ = -low_;
};

}  // namespace plumbline::cloud
