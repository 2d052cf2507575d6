// Known points and where they are in photographs.
#pragma once

#include <Eigen/Core>
#include <string>

namespace plumbline::control {

struct ControlPoint {
  std::string name;
  Eigen::Vector3d position;  ///< E, N, H [m]; nan where the file has none: of a point of the plan or of a height only
  Eigen::Vector3d sigma;     ///< [m]; nan where the file says none
  bool check = false;        ///< withheld, to judge by
  Eigen::Vector3d correlation = Eigen::Vector3d::Zero();  ///< of E and N, E and H, N and H
  std::string second_name = {};                           ///< of lists that have a number and a name

  bool is_whole() const { return position.allFinite(); }
};

struct ImagePoint {
  std::string image, point;
  Eigen::Vector2d pixel;  ///< the centre of the top-left pixel is (0, 0)
  double sigma = 0;       ///< [px]; 0: not said
};

}  // namespace plumbline::control
