// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <span>
#include <vector>

#include "common/geometry/similarity.h"

namespace sheen {

// Images do not tell where a stage stands, how it is turned, and how large it is: seven numbers, the gauge. The printed
// sheet and a measured length do. All points are the corners of tags, four a tag.

Eigen::Vector3d middle_of_tag(const Eigen::Vector3d* corners);

/// The similarity that takes the sheet to where most tags are found; a few may stand anywhere. Gives the weight of each
/// corner: 1 within what a printer and flat paper do.
Similarity robust_similarity(std::span<const Eigen::Vector3d> sheet, std::span<const Eigen::Vector3d> found,
                             std::vector<double>& weights);

/// Derivative (7 x 3 points) of the gauge by the points, which stand in the sheet's frame: translation and rotation of
/// the similarity above, at these weights; distance of two tags' middles.
Eigen::MatrixXd gauge(std::span<const Eigen::Vector3d> points, std::span<const Eigen::Vector3d> sheet,
                      std::span<const double> weights, int from_tag, int to_tag);

/// The part of the inverse of normal equations that changes nothing of the gauge: the covariance for a noise of 1. The
/// points begin at unknown `first`. Throws Error when the equations have no such inverse.
Eigen::MatrixXd constrained_inverse(const Eigen::MatrixXd& normal, const Eigen::MatrixXd& gauge, int first);

}  // namespace sheen
