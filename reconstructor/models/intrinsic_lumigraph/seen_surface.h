// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>
#include <span>
#include <vector>

#include "common/camera/posed_camera.h"
#include "common/geometry/ray_scene.h"
#include "common/image/image.h"
#include "reconstructor/lumigraph_file/light_set.h"

namespace sheen {

/// What a mesh hides from lamps and eyes.
class Occluders {
 public:
  explicit Occluders(const Mesh& mesh);

  struct Place {
    Eigen::Vector3f point, facing;  ///< `facing`: unit, the side of the triangle that is seen
    Hit hit;
  };
  const RayScene& rays() const { return rays_; }
  /// What a ray has hit; without a facing where that is nothing.
  Place place_or_none(const Ray& ray, const Hit& hit) const;
  /// Whether a lamp's light arrives: it is on the side that is seen, and nothing stands before it.
  bool reached(const Place& place, const Lamp& lamp) const;
  /// The same (1 or 0) of many places; of such as lie beside each other it is found more quickly.
  void reached(std::span<const Place> places, const Lamp& lamp, std::span<std::uint8_t> answers) const;

 private:
  std::optional<Ray> shadow_ray(const Place& place, const Lamp& lamp) const;  ///< none where the lamp is behind

  Mesh mesh_;
  RayScene rays_;
  float clearance_, far_;  ///< metres: what a ray starts off the surface with; further than the mesh reaches
};

/// What a camera sees of a mesh: the surface behind the corners of its pixels, found once, from which light that moves
/// is judged quickly. Refers to the occluders.
class SeenSurface {
 public:
  SeenSurface(const Occluders& occluders, const PosedCamera& from);

  ImageF depth() const;    ///< z in camera coordinates at the pixels' centres; 0 where there is nothing
  ImageF normals() const;  ///< unit, towards the eye's side; object frame
  /// At a pixel's centre.
  const Hit& hit(int x, int y) const { return centres_[std::size_t(y) * from_.camera.width + x].hit; }

  /// Part of each pixel that a lamp's light reaches, 0..255. An edge of the shadow is resolved by 4 x 4 rays per pixel.
  ImageU8 reached(const Lamp& lamp) const;

 private:
  Ray ray_at(double x, double y) const;
  std::uint8_t reached_within(int x, int y, const Lamp& lamp) const;  ///< a pixel at an edge of the shadow

  const Occluders* occluders_;
  PosedCamera from_;
  Rigid3 object_from_camera_;
  std::vector<Occluders::Place> centres_, corners_;  ///< `facing` is zero where there is nothing
};

}  // namespace sheen
