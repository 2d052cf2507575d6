// frames.to_building: the survey in the frame of the design, before anything is built on it.
#pragma once

#include <limits>

#include "artifacts/design.hpp"
#include "artifacts/plates.hpp"
#include "artifacts/points.hpp"
#include "artifacts/transform.hpp"
#include "building/ifc/georeference.hpp"
#include "geometry/frame_graph.hpp"
#include "plumbline/node.hpp"

namespace plumbline::frames {

struct ToBuilding : Node {
  static constexpr Info info{
      "frames.to_building", "", 5,
      "Brings surveyed points into the frame of the design, and refuses a survey that is not there"};
  In<Points> points{"points", frame("frame=?S"), "surveyed points with their covariance"};
  In<Points> designed{"designed", frame("frame=building"), "where the same points are by the design (match.elements)"};
  In<Design> design{"design", frame("frame=building"), "the design, for its map conversion"};
  In<Plates> plates{"plates", frame("frame=?S"), "plates, whose azimuths count from the survey's north"};
  Param<std::string> use{
      "use", "same",
      one_of("same", "map_conversion", "map_conversion_in_metres", "map_conversion_in_project_units",
             "map_conversion_turned_back", "fitted", "fitted_in_space", "given"),
      "same: survey and design share one frame; map_conversion: the survey is in map coordinates; fitted: shift "
      "and turn from the anchors, which then show no common shift; fitted_in_space: the same of points that may lean, "
      "such as a block of photographs alone; given: shift and turn below"};
  Param<double> datum_sigma{
      "datum_sigma", std::numeric_limits<double>::quiet_NaN(), "m", between(0, 10),
      "of a survey that hangs on the design, fitted to it or on control with its coordinates: how well other "
      "measurements show that the whole stands where it is designed, a standard deviation; 0: agreed to be judged "
      "about the best fit; nan: nobody says, and nothing is decided. Of any other it is added to what is known"};
  Param<std::vector<double>> translation{"translation", std::vector<double>{}, "m", between(-1e8, 1e8),
                                         "for 'given': the design's origin in the survey's coordinates, E N H"};
  Param<double> rotation{"rotation", 0, "rad", between(-7, 7),
                         "for 'given': turn of the design's x axis from the survey's east, counter-clockwise"};
  Param<double> grid_scale{"grid_scale", 1, "1", between(0.99, 1.01),
                           "for 'given': survey's length over design's length"};
  Param<std::vector<double>> sigmas{"sigmas", std::vector<double>{}, "rad,m", between(0, 100),
                                    "for 'given': standard deviations of rotation, E, N, H; empty: exact"};
  Out<Points> building{"points", frame("frame=building"), "the surveyed points in the frame of the design"};
  Out<Plates> building_plates{"plates", frame("frame=building"), "the plates, turned likewise"};
  Out<Transform> transform{"transform", frame("to=building,from=?S"), "what was applied, with its covariance"};

  void run(Context& context) override;

 private:
  FrameLink fitted(const ifc::CommonPoints& common, Context& context) const;
  FrameLink told(const ifc::CommonPoints& common, const DesignT& read, Context& context) const;
};

}  // namespace plumbline::frames
