#define PLUMBLINE_EIGEN_ONCE
#include "geometry/linear_algebra/eigen_once.hpp"
