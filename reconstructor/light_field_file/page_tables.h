// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "common/camera/posed_camera.h"
#include "common/geometry/mesh.h"
#include "reconstructor/surface/sample_state.h"

// A surface light field as pages in browsers draw it: tables of numbers, and maps of 8 bits a value. Lengths in metres,
// from the mesh's origin.
namespace sheen {

/// Centre x y z, radius, up x y z, direction of the first view x y z, origin x y z, brightest encoded colour (white:
/// 1).
std::vector<double> scene_table(const Mesh& mesh, const std::vector<PosedCamera>& cameras, float brightest);

/// Of each photograph: where it was taken x y z, right x y z, down x y z, forward x y z, half its width and half its
/// height at distance 1.
std::vector<float> camera_table(const std::vector<PosedCamera>& cameras);

/// Four numbers per edge of the mesh: its vertices, the triangle on one side and that on the other; the same one twice
/// where the surface ends or more than two meet.
std::vector<std::uint32_t> edge_table(const Mesh& mesh);

inline constexpr std::size_t kPageTexelBytes = 4;

/// The least of a patch's means, and how far above it the largest is.
struct MeanRange {
  float low = 0, width = 1;
};
/// A texel per state: the mean colour in 255ths of its range, and the SampleState * 127. `colours`: 3 per sample; none:
/// nothing is known.
MeanRange pack_means(const Eigen::VectorXf& colours, std::span<const SampleState> states, std::uint8_t* texels);

/// One term of a sample every `stride` texels: 128 + 127ths of the largest value of the term, which is returned.
float pack_term(const Eigen::Ref<const Eigen::VectorXf>& colours, std::size_t stride, std::uint8_t* texels);

/// What the page multiplies a term's coefficient with: it takes bytes as 255ths.
inline float amount_per_coefficient(float largest) {
  return 255.0f / 127.0f * largest;
}

}  // namespace sheen
