// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <cstdint>

namespace sheen {

/// Well-mixed 64 bits of a 64-bit value: the source of every reproducible random number of the simulation.
std::uint64_t mix_bits(std::uint64_t value);

/// Uniform in [0, 1) from 24 bits of a hash.
inline float unit_float(std::uint64_t hash) {
  return static_cast<float>(hash >> 40) * 0x1p-24f;
}

/// Smooth noise of wavelength about 1, within [-1, 1], with mean 0; equal on every machine.
float gradient_noise(const Eigen::Vector3f& p);

/// Sum of `octaves` of gradient noise, each of half the wavelength and half the height, within about [-1, 1].
float fractal_noise(Eigen::Vector3f p, int octaves);

/// Points scattered at one per unit cell: the distance to the nearest and a number in [0, 1) that names it.
struct ScatteredPoint {
  float distance;
  float name;
};
ScatteredPoint nearest_scattered_point(const Eigen::Vector3f& p);

}  // namespace sheen
