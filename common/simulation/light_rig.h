// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <functional>
#include <memory>
#include <vector>

#include "common/camera/posed_camera.h"
#include "common/capture/lighting.h"
#include "common/geometry/ray_scene.h"
#include "common/image/image.h"
#include "common/simulation/toy_scene.h"

namespace sheen {

struct LightRigOptions {
  int lights = 7;                 ///< lamps on half a circle round the scene, 50 degrees up, 1.3 m away
  int columns = 5, rows = 5;      ///< of cameras on a plane, 20 mm apart, all looking the same way
  int width = 320, height = 240;  ///< pixels
  double gloss = 0;               ///< 0..1, see `ToyScene::gloss`
};

/// A picture and what it shows, exact. Depth, shadow and reflectance belong to the rays through the pixels' centres.
struct SimulatedPicture {
  ImageF radiance;     ///< RGB, as a box filter over each pixel sees it
  ImageF depth;        ///< z in camera coordinates, metres; 0 where there is nothing
  ImageU8 shadow;      ///< 255 where no light of the lamp arrives: it is hidden, or behind the surface
  ImageF reflectance;  ///< RGB
};

/// A still life in the light of one of several lamps, seen by one of a grid of cameras: 001's capture, simulated.
/// Radiance is albedo * (ambient + visible * max(0, n.l) (d0 / d)^2), and a lobe where there is gloss; lamps are
/// points, so that shadows are hard. Light reflected between surfaces is left out.
class LightRig {
 public:
  /// Throws ConfigError.
  explicit LightRig(const LightRigOptions& options);

  static constexpr double kAmbient = 0.18;  ///< what arrives from everywhere, in units of the lamp's light

  const ToyScene& scene() const { return scene_; }
  const LightRigOptions& options() const { return options_; }
  const std::vector<PosedCamera>& cameras() const { return cameras_; }  ///< row by row
  const std::vector<LightState>& lights() const { return lights_; }
  /// Lamps halfway between neighbours.
  const std::vector<LightState>& midway_lights() const { return midway_lights_; }
  /// The lamp at such a place of the row, which may lie between two: 2.5 is halfway from the third to the fourth.
  LightState light_at(double place) const;
  /// The camera at (column, row) of the grid, which may lie between its places.
  PosedCamera camera_at(double column, double row) const;
  PosedCamera central_camera() const { return cameras_[cameras_.size() / 2]; }

  SimulatedPicture picture(const PosedCamera& from, const LightState& light) const;

 private:
  struct Seen;
  Seen look(const Ray& ray, const LightState& light) const;

  LightRigOptions options_;
  ToyScene scene_;
  std::unique_ptr<RayScene> rays_;
  std::vector<PosedCamera> cameras_;
  std::vector<LightState> lights_, midway_lights_;
};

/// Writes the rig as a data set with light keys: images (8-bit sRGB), `mesh.ply`, `transforms.json`; views to be held
/// out are those of the midway lights, at the central and the first camera, and one between cameras. `truth`: also
/// depth, reflectance, shadow and radiance of each central and each held-out image, as OpenEXR in `truth/`.
/// `progress` after each image; what it throws ends the work. Throws FileError.
void write_light_rig(const LightRig& rig, const std::filesystem::path& folder, bool truth,
                     const std::function<void(int done, int total)>& progress);

}  // namespace sheen
