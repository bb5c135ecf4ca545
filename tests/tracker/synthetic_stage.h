// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <random>
#include <vector>

#include "common/camera/camera.h"
#include "common/capture/capture.h"
#include "common/stage/stage_layout.h"

namespace sheen::testing {

/// 1024 x 768, f = 1200 px, with a lens that bends by several pixels at the corners unless `pinhole`.
Camera stage_camera(bool pinhole = false);

/// A pose from which the whole stage is seen: 0.55 to 0.75 m away, up to `max_tilt_deg` off the vertical, any roll.
Rigid3 random_stage_pose(std::mt19937& rng, double max_tilt_deg = 55);

/// Where the tags' corners appear, exactly; tags that are not wholly inside the image are left out.
std::vector<TagObservation> exact_observations(const Camera& camera, const StageLayout& stage, const Rigid3& pose);

void add_corner_noise(std::vector<TagObservation>& tags, double sigma_px, std::mt19937& rng);

/// Errors of corners where the lines of edges meet: a line through points along each edge, 1 px apart, each of which is
/// off across the edge by `point_sigma_px`, and all of an edge together by `edge_sigma_px`.
void add_edge_noise(std::vector<TagObservation>& tags, double point_sigma_px, double edge_sigma_px, std::mt19937& rng);

/// The stage as the camera sees it, by asking for each of samples_per_side^2 points of a pixel which ink lies there:
/// paper `paper`, ink `ink`, beyond the board `background` (grey levels).
ImageU8 render_stage(const Camera& camera, const StageLayout& stage, const Rigid3& pose, int samples_per_side = 8,
                     double ink = 30, double paper = 200, double background = 90);

void add_pixel_noise(ImageU8& image, double sigma, std::mt19937& rng);

/// The step from an estimated pose to the truth, squared in units of the stated covariance: chi squared with 6 degrees
/// of freedom where that is right.
double squared_in_sigmas(const PoseEstimate& pose, const Rigid3& truth);

}  // namespace sheen::testing
