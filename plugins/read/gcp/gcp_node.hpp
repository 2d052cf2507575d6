// read.gcp: ground control that was measured in photographs, from one file.
#pragma once

#include "artifacts/file.hpp"
#include "artifacts/points.hpp"
#include "plumbline/node.hpp"

namespace plumbline::gcp {

struct ReadGcp : Node {
  static constexpr Info info{"read.gcp", "", 1,
                             "Reads ground control and where it is in photographs: OpenDroneMap's gcp_list.txt, or the "
                             "table of openMVS with its accuracies"};
  Param<FilePath> file{"file", required,
                       "gcp_list.txt, or a table gcp_label, image_file_name, x, y, x_map, y_map, elev, x_map_acc, "
                       "y_map_acc, elev_acc"};
  Param<std::string> pixel_origin{"pixel_origin", "by_format", one_of("by_format", "centre", "corner"),
                                  "what (0, 0) is in the file: the centre of the top-left pixel or its corner; "
                                  "by_format: the corner in gcp_list.txt, the centre in openMVS's table"};
  Out<Points> points{"points", frame("frame=survey"), "the points; sigmas that the file does not say are nan"};
  Out<File> control{"control",
                    "control.csv: name, E, N, H, and sigma_E, sigma_N, sigma_H [m] of points that have them"};
  Out<File> measured{"measured", "measured.csv: image, point, x, y [px] from the centre of the top-left pixel"};

  void run(Context& context) override;
};

}  // namespace plumbline::gcp
