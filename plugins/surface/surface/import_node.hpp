// Points of a scanner, or of another program, on the faces of a design.
#pragma once

#include <optional>

#include "artifacts/design.hpp"
#include "artifacts/file.hpp"
#include "artifacts/folder.hpp"
#include "artifacts/points.hpp"
#include "artifacts/surface_points.hpp"
#include "artifacts/transform.hpp"
#include "faces.hpp"
#include "plumbline/node.hpp"
#include "surface/dense/scan_tiles.hpp"

namespace plumbline::surface {

/// What is open about which panels a scan shows, and about the frame that it is in; empty: nothing is.
struct WhichPanels {
  std::string doubt, unconfirmed, other_frame = {};
};

struct ImportCloud : Node {
  static constexpr Info info{
      "dense.import", "depth", 8,
      "Reads a point cloud (PLY, LAS 1.0 to 1.4, E57, PTS, XYZ) and keeps the points on the faces of a design"};
  Param<FilePath> file{"file", FilePath{}, "the cloud: .ply, .las, .e57, .pts, .xyz, recognised by its content"};
  Optional<File> by_reference{"scan", "the cloud by reference, in the place of 'file'"};
  Optional<Design> design{"design", frame("frame=?F"), "whose panels are measured"};
  Optional<Points> points{"points", frame("frame=?F"), "without a design: the plane of these points is measured"};
  Optional<Transform> registration{
      "registration", frame("to=?F,from=?S"),
      "the way from the scan's frame, with its covariance; without it the scan is in the frame of the design"};
  Optional<Transform> anchors{
      "anchors", frame("to=?F,from=?A"),
      "the way on which the anchors came into the frame of the design; the scan is not moved by it: where it moves "
      "them "
      "and no 'registration' is connected, the two may be judged in two frames, and that is said"};
  Param<std::string> unit{"unit", "from_file", one_of("from_file", "m", "cm", "mm", "ft", "us_ft"),
                          "of the file's coordinates; from_file: what the file says, metres if it says nothing"};
  Param<double> noise{"noise", 0.002, "m", between(1e-6, 1),
                      "of a point along the surface's normal, 1 sigma: range noise of the scanner"};
  Param<double> place_sigma{"place_sigma", 0.0, "m", between(0, 10),
                            "of the scan's place as a whole in each coordinate, besides the registration's covariance"};
  Param<double> turn_sigma{"turn_sigma", 0.0, "rad", between(0, 0.1),
                           "of the scan's orientation about each axis through the middle of the faces, likewise"};
  Param<double> scan_sigma{
      "scan_sigma", 0.0, "m", between(0, 10),
      "of each scan's place by itself (blocks of PTS, point source ids of LAS, scans of E57): what they differ "
      "by where two of them meet"};
  Param<double> scan_turn_sigma{"scan_turn_sigma", 0.0, "rad", between(0, 0.1), "of each scan's orientation, likewise"};
  Param<double> search{
      "search", 0.05, "m", between(0.001, 2),
      "a panel further than this from its face is not measured; points are kept to 6 times the noise beyond it"};
  Param<double> beside{
      "beside", 0.02, "m", between(0, 1),
      "points so far beside a face are kept too: panels that are wider than designed, and their joints"};
  Param<double> tile{"tile", 0.5, "m", between(0.02, 5), "edge of the parts that points are kept in"};
  Param<double> margin{"margin", 0.05, "m", between(0, 5),
                       "without a design: how far beyond the points the plane reaches"};
  Param<std::vector<double>> seen_from{
      "seen_from", std::vector<double>{}, "m", between(-1e9, 1e9),
      "x, y, z of the scanner's stations in the frame of the design, one after the other: on which side of a panel the "
      "outside is, where the design does not say; a panel that all of them see from behind is left out"};
  Param<bool> place_confirmed{"place_confirmed", false,
                              "somebody has seen that the scan lies on the panels that it shows, and not one panel "
                              "beside them: nothing is asked "
                              "of its place; a connected 'registration' says so too"};
  Out<SurfacePoints> surface{"surface", frame("frame=?F"), "the points"};
  Out<Folder> files{"files", "where they lie"};

  void run(Context& context) override;

 private:
  std::string cloud_path(Context& context) const;
  /// `common`: places that all scans share; `own`: of each by itself; `which`: what is open about which panels it
  /// shows.
  void commit(Context& context, const Faces& faces, const ScanTiles& tiles, const std::vector<ScanPlace>& common,
              const std::optional<ScanPlace>& own, const WhichPanels& which, const std::string& folder,
              const std::string& uri) const;
};

}  // namespace plumbline::surface
