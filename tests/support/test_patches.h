// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <vector>

namespace sheen {

/// The two patches that the goals of the factorization are stated for.
enum class TestPatch {
  kTypical,  ///< glossy: its best rank-12 error is about 0.040
  kHard,     ///< sharp highlights on a strongly curved patch: about 0.253
};

inline constexpr int kTestPatchSamples = 816;  ///< six triangles of 16 x 17 / 2
inline constexpr int kTestPatchViews = 300;

/// Positions of the samples in the plane of the patch, 2 x 816: six triangles round the origin, radius 1.
Eigen::Matrix2Xf test_patch_samples();

/// Columns of a patch as a camera gives them, 2448 x 300: albedo times diffuse light plus the glossy lobes of three
/// lights on a patch that is curved like a cap, seen along a spiral from the pole of the hemisphere to 75 degrees; and
/// 1 % noise. Row = 3 sample + channel.
Eigen::MatrixXf test_patch_columns(TestPatch patch);

/// As given, by ascending norm, by descending norm, then `shuffled` random orders.
std::vector<std::vector<int>> column_orders(const Eigen::MatrixXf& columns, int shuffled = 20);

/// What a straight edge leaves visible of a test patch, 2448 x views, 1 or 0: a column is occluded with probability
/// `occluded`, and then a fraction of its samples between 0.2 and 0.8 is hidden, on one side of an edge in a random
/// direction.
Eigen::Array<std::uint8_t, Eigen::Dynamic, Eigen::Dynamic> occluding_edges(int views, double occluded,
                                                                           std::uint32_t seed);

}  // namespace sheen
