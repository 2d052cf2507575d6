// Which camera took a photograph, told from its path.
#pragma once

#include <map>
#include <string>
#include <vector>

namespace plumbline::cameras {

/// "rig/left" of "rig/left/0017.png" and "" without a folder.
std::string folder_of(const std::string& path);

/// "rig/cam_0_frame" of "rig/cam_0_frame_0017.png", "cam2" of "0017_cam2.png": what stands around the last number of
/// the name that does not number a camera.
std::string name_around_number(const std::string& path);

/// The name of the camera; `by` is "by_folder", "by_name" (folder and what stands around the number), "by_file" (the
/// file's name: "cam0" of "0001/cam0.png") or "one".
std::string camera_name(const std::string& path, const std::string& by);

/// `by`, or "by_file" where folders or names were to tell and each folder clearly is a moment: "0001/left.png",
/// "0001/right.png", "0002/left.png" and so on.
std::string cameras_told(const std::vector<std::string>& paths, const std::string& by);

/// What two photographs of one moment share, of cameras told apart as above: the folder of "by_file", else that number,
/// or the name without its folder if it has none.
std::string moment_of(const std::string& path, const std::string& by);

/// The moments of each camera's photographs. Times of ten digits and more, which cameras hardly share to the last of
/// them, are one moment where they differ by less than a quarter of the shortest time between two photographs of a
/// camera.
std::vector<std::vector<std::string>> moments_of(const std::vector<std::vector<std::string>>& paths,
                                                 const std::string& by);

/// "cam_0, cam_1 and cam_2" if the names of one folder suggest that several cameras took the photographs, each at least
/// three: the same moments under several beginnings. Empty otherwise.
std::string suspected_cameras(const std::vector<std::string>& paths);

}  // namespace plumbline::cameras
