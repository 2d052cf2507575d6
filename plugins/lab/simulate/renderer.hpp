// Photographs of the simulated facade, band by band, so that an image of any size needs little memory.
//
// Plates are what is measured, so they are exact: each is sampled 4 × 4 times a pixel through the true camera
// (distortion by a grid of 16 px whose interpolation error is about 0.001 px), edges inside a sample are area-filtered,
// and the samples are integrated over pixel and point spread function. The wall behind them only has to look like one:
// it is sampled once a pixel. Luma is linear in light, unless the perturbations ask for a transfer curve. Same inputs,
// same bytes.
#pragma once

#include <cstdint>
#include <memory>
#include <vector>

#include "building.hpp"
#include "camera.hpp"
#include "obstruction.hpp"
#include "panels.hpp"
#include "perturbations.hpp"

namespace plumbline::simulate {

struct RenderOptions {
  double noise_scale = 1.0;     ///< multiplies the camera's read and shot noise; 0: none
  double blur = -1;             ///< standard deviation of the point spread function [px]; negative: the profile's
  double light_gradient = 0.2;  ///< relative change of the light across the facade
  double haze = 0;              ///< share of scattered light in the image, 0 to 1: contrast falls by it
  double exposure = 1.0;
  Perturbations perturbations = {};    ///< those of the camera, the print and the scene
  std::vector<HungPanel> panels = {};  ///< painted over the wall, behind the plates; none: the wall is seen
  double panel_contrast = 1;           ///< of their texture
  std::uint64_t seed = 1;
};

class Renderer {
 public:
  static constexpr int band_rows = 16;

  /// Throws std::invalid_argument if the camera's distortion cannot be inverted within the image.
  Renderer(const Building& building, const SimulatedCamera& camera, const RigidTransform& camera_from_building,
           const RenderOptions& options, const Obstruction& obstruction = {});
  ~Renderer();
  Renderer(const Renderer&) = delete;
  Renderer& operator=(const Renderer&) = delete;

  int width() const;
  int height() const;
  int bands() const { return (height() + band_rows - 1) / band_rows; }
  /// Width rounded up to the 16 px that a block row of a 4:2:0 JPEG takes.
  int padded_width() const { return (width() + 15) / 16 * 16; }

  /// Rows 16·band ... 16·band + 15 as luma (16 × padded_width) and chroma of half the resolution (8 × padded_width / 2
  /// each).
  struct Band {
    std::vector<std::uint8_t> luma, blue, red;
  };
  void render(int band, Band& out) const;

 private:
  struct Scene;
  std::unique_ptr<Scene> scene_;
};

}  // namespace plumbline::simulate
