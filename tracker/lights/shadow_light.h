// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <span>
#include <string>
#include <vector>

#include "common/capture/lighting.h"

namespace sheen {

/// A point of an object and the point on which its shadow falls; the light is on their line, behind the object.
struct ShadowPair {
  Eigen::Vector3d shadow = Eigen::Vector3d::Zero(), object = Eigen::Vector3d::Zero();  ///< metres
  Eigen::Matrix3d shadow_covariance = Eigen::Matrix3d::Identity();                     ///< m^2, or up to a factor
  Eigen::Matrix3d object_covariance = Eigen::Matrix3d::Identity();
};

/// A light that explains pairs best.
struct ShadowLight {
  LightState light;        ///< a point, or directional where the distance is not known
  Eigen::Vector3d centre;  ///< of the shadow points: where direction and distance are seen from
  Eigen::Vector3d direction;
  double direction_uncertainty_deg = 0;                           ///< standard deviation of the angle
  double inverse_distance = 0, inverse_distance_uncertainty = 0;  ///< 1/m; also of a directional light
  Eigen::Matrix3d covariance = Eigen::Matrix3d::Zero();           ///< of a point's position, m^2
  std::string why_directional;                                    ///< a sentence; empty for a point
  std::vector<double> residuals;      ///< per pair: how far from the shadow clicked the light casts it, metres
  double rms = 0;                     ///< of the residuals
  double noise = 1;                   ///< the residuals, as a factor of the covariances' standard deviations
  std::vector<std::size_t> outliers;  ///< pairs that the others contradict; not used
  int degrees_of_freedom = 0;
};

/// Least squares of the angles between the pairs' lines and the directions to the light, each weighted by what the
/// errors of its two points make of it; over direction and inverse distance, so that a light far away is no special
/// case. The light is directional where its distance is not five times its uncertainty. `noise_known`: the covariances
/// are in m^2; else they are relative, and their size follows from the residuals. Uncertainties then are those of
/// Student's t. `require_directional`: for a list whose other lights are. Throws Error that names the pair: too few,
/// swapped, a light between shadow and object.
ShadowLight light_of_shadows(std::span<const ShadowPair> pairs, bool noise_known, bool require_directional = false);

}  // namespace sheen
