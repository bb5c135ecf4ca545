// SPDX-License-Identifier: Apache-2.0
#include "tracker/lights/shadow_light.h"

#include <Eigen/Cholesky>
#include <Eigen/Geometry>
#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <numeric>
#include <optional>

#include "common/base/angle.h"
#include "common/base/errors.h"
#include "common/base/format.h"

namespace sheen {
namespace {

constexpr double kKnownDistance = 5;  // standard deviations of the inverse distance: below, the light is directional
constexpr double kNearest = 1e-6;     // extent of the pairs over the distance: below, numbers are too short to tell
constexpr double kOutlier = 5;        // standard deviations
constexpr int kEnoughFreedom = 3;     // of the others, to call a pair an outlier
constexpr double kShortest = 1e-9;    // metres between shadow and object

using Basis = Eigen::Matrix<double, 3, 2>;

/// Two unit vectors across a direction.
Basis across(const Eigen::Vector3d& direction) {
  Basis basis;
  basis.col(0) = direction.unitOrthogonal();
  basis.col(1) = direction.cross(basis.col(0));
  return basis;
}

/// Where the light is, seen from `centre`: at direction / inverse_distance.
struct Place {
  Eigen::Vector3d centre, direction;
  double inverse_distance = 0;
};

/// Of one pair: the angle between its line and the light's direction, as two components.
struct Angle {
  Eigen::Vector2d value;
  Eigen::Matrix<double, 2, 3> by;  ///< of two turns of the direction and of the inverse distance
  Eigen::Matrix2d information;
  double length = 0;  ///< from shadow to object
};
Angle angle_of(const ShadowPair& pair, const Place& place) {
  Angle angle;
  const Eigen::Vector3d line = pair.object - pair.shadow;
  angle.length = line.norm();
  // Towards the light, times the inverse distance: finite for a light at infinity.
  const Eigen::Vector3d to_centre = place.centre - pair.shadow;
  const Eigen::Vector3d towards = place.direction + place.inverse_distance * to_centre;
  const double size = towards.norm();
  const Basis basis = across(towards / size), turns = across(place.direction);
  angle.value = basis.transpose() * line / angle.length;
  angle.by.leftCols<2>() = basis.transpose() * turns / size;
  angle.by.col(2) = basis.transpose() * to_centre / size;
  const double inverse_length = 1 / angle.length, inverse_light = place.inverse_distance / size;
  const Eigen::Matrix2d covariance = basis.transpose() *
                                     (std::pow(inverse_length, 2) * pair.object_covariance +
                                      std::pow(inverse_length - inverse_light, 2) * pair.shadow_covariance) *
                                     basis;
  angle.information = covariance.inverse();
  return angle;
}

struct LightFit {
  Place place;
  Eigen::Matrix3d covariance = Eigen::Matrix3d::Zero();  ///< of two turns and the inverse distance
  double squares = 0;
};

/// Gauss-Newton over direction and, of a point, inverse distance.
LightFit fit_light(std::span<const ShadowPair> pairs, Place place, bool point) {
  LightFit fit{.place = place};
  for (int round = 0; round < 50; ++round) {
    Eigen::Matrix3d normal = Eigen::Matrix3d::Zero();
    Eigen::Vector3d right = Eigen::Vector3d::Zero();
    fit.squares = 0;
    for (const ShadowPair& pair : pairs) {
      const Angle angle = angle_of(pair, fit.place);
      normal += angle.by.transpose() * angle.information * angle.by;
      right += angle.by.transpose() * angle.information * angle.value;
      fit.squares += angle.value.dot(angle.information * angle.value);
    }
    Eigen::Vector3d step = Eigen::Vector3d::Zero();
    fit.covariance.setZero();
    if (point) {
      fit.covariance = normal.inverse();
      step = normal.ldlt().solve(right);
    } else {
      fit.covariance.topLeftCorner<2, 2>() = normal.topLeftCorner<2, 2>().inverse();
      step.head<2>() = fit.covariance.topLeftCorner<2, 2>() * right.head<2>();
    }
    if (!step.allFinite()) break;
    fit.place.direction = (fit.place.direction + across(fit.place.direction) * step.head<2>()).normalized();
    fit.place.inverse_distance += step.z();
    if (step.head<2>().norm() < 1e-13 && std::abs(step.z()) < 1e-12 * (1 + std::abs(fit.place.inverse_distance))) break;
  }
  return fit;
}

/// Half width that holds 68 % of Student's t, to a hundredth.
double student(int freedom) {
  return 1 + 0.5 / freedom + 0.337 / (freedom * freedom);
}

std::string pair_name(std::size_t i) {
  return "pair " + std::to_string(i + 1);
}

Place first_guess(std::span<const ShadowPair> pairs) {
  Place place{Eigen::Vector3d::Zero(), Eigen::Vector3d::Zero(), 0};
  for (const ShadowPair& pair : pairs) {
    place.centre += pair.shadow / static_cast<double>(pairs.size());
    place.direction += (pair.object - pair.shadow).normalized();
  }
  place.direction.normalize();
  return place;
}

/// Throws where a pair is no line, or points the other way than most.
void check_pairs(std::span<const ShadowPair> pairs) {
  for (std::size_t i = 0; i < pairs.size(); ++i)
    if (!((pairs[i].object - pairs[i].shadow).norm() > kShortest))
      throw Error(pair_name(i) + ": shadow and object are one point; click two");
  const Eigen::Vector3d direction = first_guess(pairs).direction;
  for (std::size_t i = 0; i < pairs.size(); ++i)
    if (!((pairs[i].object - pairs[i].shadow).dot(direction) > 0))
      throw Error(pair_name(i) +
                  " points away from where the others see the light: are its shadow and object swapped?");
}

void check_behind(const ShadowPair& pair, const LightState& light, std::size_t i) {
  if (light.kind == LightKind::kPoint && (light.position - pair.object).dot(pair.object - pair.shadow) <= 0)
    throw Error(pair_name(i) + ": the light would be between its shadow and its object; click both again");
}

/// How far the pairs reach from their centre, metres.
double extent_of(std::span<const ShadowPair> pairs, const Eigen::Vector3d& centre) {
  double extent = 0;
  for (const ShadowPair& pair : pairs) extent = std::max(extent, (pair.object - centre).norm());
  return extent;
}

/// Factor of the covariances' standard deviations that the residuals say; 1 where nothing is left to say it.
double noise_of(const LightFit& fit, int freedom) {
  return freedom > 0 ? std::sqrt(fit.squares / freedom) : 1;
}

/// The pair that the others contradict most, if they do.
std::optional<std::size_t> worst_outlier(std::span<const ShadowPair> pairs, const Place& place, int freedom,
                                         bool known) {
  if (!known && freedom - 2 < kEnoughFreedom) return std::nullopt;
  std::vector<double> squares;
  for (const ShadowPair& pair : pairs) {
    const Angle angle = angle_of(pair, place);
    squares.push_back(angle.value.dot(angle.information * angle.value));
  }
  const auto worst = std::max_element(squares.begin(), squares.end());
  const double others = std::accumulate(squares.begin(), squares.end(), -*worst);
  if (pairs.size() < 4) return std::nullopt;
  const double factor = std::max(others / (freedom - 2), known ? 1 : 1e-30);
  if (*worst / 2 < kOutlier * kOutlier * factor) return std::nullopt;
  return static_cast<std::size_t>(worst - squares.begin());
}

/// Of pairs that are all used: everything but residuals and outliers.
ShadowLight light_of_all(std::span<const ShadowPair> pairs, bool noise_known, bool require_directional) {
  const int count = static_cast<int>(pairs.size());
  if (count == 1 && !noise_known)
    throw Error("one pair says no uncertainty; click two or more, or let the file say the \"uncertainty\"");
  const Place guess = first_guess(pairs);
  ShadowLight found;
  LightFit fit = fit_light(pairs, guess, false);
  found.degrees_of_freedom = 2 * count - 2;
  found.why_directional = "one pair says a direction only";
  if (count > 1) {
    const LightFit point = fit_light(pairs, fit.place, true);
    const int freedom = 2 * count - 3;
    const double factor = noise_known ? 1 : noise_of(point, freedom) * student(freedom);
    found.inverse_distance = point.place.inverse_distance;
    found.inverse_distance_uncertainty = factor * std::sqrt(point.covariance(2, 2));
    if (found.inverse_distance < -kKnownDistance * found.inverse_distance_uncertainty)
      throw Error("the lines through the pairs meet behind the shadows: are shadow and object points swapped?");
    const bool known = found.inverse_distance > kKnownDistance * found.inverse_distance_uncertainty &&
                       found.inverse_distance * extent_of(pairs, guess.centre) > kNearest;
    found.why_directional = require_directional ? "another light of the list is"
                                                : format(
                                                      "the pairs' lines are nearly parallel, too few or too rough to "
                                                      "say it: 1 / distance is %.3g +- %.2g per metre",
                                                      found.inverse_distance, found.inverse_distance_uncertainty);
    if (known && !require_directional) {
      fit = point;
      found.degrees_of_freedom = freedom;
      found.why_directional.clear();
    }
  }

  found.noise = noise_of(fit, found.degrees_of_freedom);
  const double factor = noise_known ? 1 : found.noise * student(found.degrees_of_freedom);
  const Eigen::Matrix3d covariance = factor * factor * fit.covariance;
  found.centre = fit.place.centre;
  found.direction = fit.place.direction;
  found.direction_uncertainty_deg = std::sqrt(covariance.topLeftCorner<2, 2>().trace()) / kDegree;
  found.light = {.kind = LightKind::kDirectional, .position = found.direction};
  if (found.why_directional.empty()) {
    const double distance = 1 / fit.place.inverse_distance;
    found.light = {.kind = LightKind::kPoint, .position = found.centre + distance * found.direction};
    Eigen::Matrix3d by;
    by.leftCols<2>() = distance * across(found.direction);
    by.col(2) = -distance * distance * found.direction;
    found.covariance = by * covariance * by.transpose();
  }
  return found;
}

}  // namespace

ShadowLight light_of_shadows(std::span<const ShadowPair> pairs, bool noise_known, bool require_directional) {
  if (pairs.empty()) throw Error("there is no pair of a shadow and an object");
  check_pairs(pairs);
  std::vector<ShadowPair> kept(pairs.begin(), pairs.end());
  std::vector<std::size_t> names(pairs.size());
  std::iota(names.begin(), names.end(), 0);
  ShadowLight found;
  Place place;
  for (;;) {
    found = light_of_all(kept, noise_known, require_directional);
    place = {found.centre, found.direction, found.why_directional.empty() ? found.inverse_distance : 0};
    const auto worst = worst_outlier(kept, place, found.degrees_of_freedom, noise_known);
    if (!worst) break;
    kept.erase(kept.begin() + static_cast<std::ptrdiff_t>(*worst));
    names.erase(names.begin() + static_cast<std::ptrdiff_t>(*worst));
  }
  for (std::size_t i = 0; i < pairs.size(); ++i) {
    const Angle angle = angle_of(pairs[i], place);
    found.residuals.push_back(angle.length * angle.value.norm());
    if (std::find(names.begin(), names.end(), i) == names.end()) {
      found.outliers.push_back(i);
    } else {
      found.rms += std::pow(found.residuals.back(), 2) / static_cast<double>(names.size());
      check_behind(pairs[i], found.light, i);
    }
  }
  found.rms = std::sqrt(found.rms);
  return found;
}

}  // namespace sheen
