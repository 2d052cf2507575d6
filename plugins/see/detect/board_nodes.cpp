// Detectors of ArUco tags, boards and targets, in a plugin of their own: who detects AprilTags builds nothing of them.
#include "aruco_node.hpp"
#include "board_node.hpp"
#include "target_node.hpp"

PLUMBLINE_PLUGIN("detect_boards", PLUMBLINE_BUILD_ID, "MIT", plumbline::detect::DetectAruco,
                 plumbline::detect::DetectBoard, plumbline::detect::PredictTargets, plumbline::detect::DetectTarget)
