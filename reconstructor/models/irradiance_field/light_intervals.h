// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <optional>
#include <vector>

#include "reconstructor/irradiance_field_file/lit_scene.h"
#include "reconstructor/irradiance_field_file/relighting.h"
#include "reconstructor/models/light_advice.h"
#include "reconstructor/numerics/point_kriging.h"

namespace sheen {

/// Pairs of points with no third in the ball between them (Gabriel 1969). points: 3 x n.
std::vector<std::array<Eigen::Index, 2>> neighbours(const Eigen::Matrix3Xd& points);

/// The heuristic of paper 000 for lights: what a light's image adds to the prediction from the others, its residual, is
/// what an interval twice as wide would miss. How fast that shrinks is measured, too: with a light's neighbours left
/// out as well the interval is twice as wide again (a smooth scene misses four times as much, edges of shadows hardly
/// more). At the rim of the lights, where the prediction goes beyond its neighbours, it misses up to twice as much.
/// None for fewer than 8 lights.
std::optional<LightAdvice> judge_lights(const LitScene& scene, const PointKriging& kriging,
                                        const Relighting& relighting, double tolerance);

}  // namespace sheen
