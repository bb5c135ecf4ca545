// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <span>
#include <vector>

#include "common/capture/lighting.h"
#include "common/image/image.h"

namespace sheen {

// Light adds up: a picture in any luminaire is the sum of pictures in small ones, in linear radiance. What is asked of
// a model are the lights here; their rgb is relative to the lights that its images were taken in.

/// A flat lamp, a parallelogram: it shines along half_u x half_v, and towards the object's origin as brightly as a lamp
/// of this rgb at its centre would.
struct AreaLuminaire {
  Eigen::Vector3d centre, half_u, half_v;  ///< metres, object frame
  Eigen::Vector3f rgb = Eigen::Vector3f::Ones();
};

/// per_side^2 lights of a kind, point or directional. What falls on the origin is exact; elsewhere the angle to the
/// lamp's axis and, of directional lights, distance and direction are those of the origin.
std::vector<LightState> lights_of(const AreaLuminaire& lamp, LightKind kind, int per_side);

/// A map of radiance in latitude and longitude as OpenEXR has it (3 channels): y is up, its middle is in +z, where the
/// camera of a list of lights is.
struct EnvironmentLights {
  std::vector<LightState> lights;  ///< directional; an irradiance of pi has rgb 1
  double left_out = 0;  ///< part of the map's light from where there was no light nearby when the images were taken
};
/// `known`: the lights of the model's images, of one kind. Throws ConfigError where the map has nothing but darkness
/// where they are.
EnvironmentLights lights_of(const ImageF& environment, std::span<const LightState> known);

/// Places along a smooth curve through given ones (Catmull-Rom), of one kind, with as many steps from each to the next;
/// the first and the last are those given. frames >= 2, keys >= 2.
std::vector<LightState> light_path(std::span<const LightState> keys, int frames);

}  // namespace sheen
