// SPDX-License-Identifier: Apache-2.0
#include "reconstructor/numerics/light_search.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cmath>
#include <functional>
#include <optional>
#include <vector>

namespace sheen {
namespace {

using Eigen::Vector2d;
using Eigen::Vector3d;
constexpr double kPi = std::numbers::pi;
constexpr int kEyeAngles = 12, kEyeAzimuths = 6;
constexpr double kClosest = 3;  // steps from a highlight
constexpr int kRadii = 15, kAzimuths = 8;
constexpr std::size_t kImproved = 6;   // places of the grid that are improved
constexpr double kNearHorizon = 1e-4;  // light just above it
// What is found is a little less than the supremum: the grid and the differences miss some.
constexpr double kMargin = 1.01;

/// Two directions square to a unit vector and to each other.
struct Tangents {
  Vector3d first, second;
};
Tangents tangents_of(const Vector3d& axis) {
  const Vector3d first = axis.unitOrthogonal();
  return {first, axis.cross(first)};
}

/// A light and an eye over an element, in the frame of its surface.
struct Element {
  Vector3d light, eye;
};

/// What the exposure does as the light moves from a place at distance 1.
struct Derivatives {
  double value = 0;
  Vector2d slope;
  Eigen::Matrix2d curvature;  ///< along the two tangents of the light's direction
};

class Exposure {
 public:
  explicit Exposure(const Reflectance& reflectance) : reflectance_(reflectance), step_(reflectance.resolution()) {}

  /// reflectance * N.L / distance^2 with the light at a place.
  double at(const Vector3d& place, const Vector3d& eye) const {
    const double distance = place.norm();
    return reflectance_.value(place / distance, eye) * place.z() / (distance * distance * distance);
  }
  /// Differences over the reflectance's resolution. Nothing where the light would sink below the horizon, or where the
  /// reflectance is not known.
  std::optional<Derivatives> derivatives(const Element& element) const {
    if (element.light.z() < 2 * step_) return std::nullopt;
    const auto [u, v] = tangents_of(element.light);
    const auto f = [&, &u = u, &v = v](double a, double b) {  // clang 14 does not capture bindings by itself
      return at(element.light + step_ * (a * u + b * v), element.eye);
    };
    const double here = f(0, 0), right = f(1, 0), left = f(-1, 0), up = f(0, 1), down = f(0, -1);
    const double r = std::sqrt(0.5), diagonal = f(r, r) + f(-r, -r) - 2 * here;
    Derivatives d;
    d.value = here;
    d.slope = Vector2d(right - left, up - down) / (2 * step_);
    const double uu = right + left - 2 * here, vv = up + down - 2 * here, uv = diagonal - (uu + vv) / 2;
    d.curvature << uu, uv, uv, vv;
    d.curvature /= step_ * step_;
    if (!d.curvature.allFinite() || !d.slope.allFinite()) return std::nullopt;
    return d;
  }
  const Reflectance& reflectance() const { return reflectance_; }

 private:
  const Reflectance& reflectance_;
  double step_;
};

/// Largest second derivative along a line that rises at some angle above the tangent plane of the light's direction, at
/// the place where its plane is nearest. With u the tangent of that angle, the line's direction is (t + u L) / sqrt(1 +
/// u^2), its plane is 1 / sqrt(1 + u^2) away, and as the exposure is homogeneous of degree -2 in the light's place
/// (Euler), the derivative in units of that plane's distance is (t'Ht - 6 u slope.t + 6 u^2 value) / (1 + u^2)^3.
double along_a_line(const Derivatives& d, const Vector2d& tangent) {
  const double a = tangent.dot(d.curvature * tangent), b = -6 * d.slope.dot(tangent), c = 6 * d.value;
  const auto size = [&](double u) {
    const double s = 1 + u * u;
    return std::abs(a + b * u + c * u * u) / (s * s * s);
  };
  double best = 0;
  for (int i = -4; i <= 4; ++i)
    if (size(0.35 * i) > size(best)) best = 0.35 * i;  // up to 54 degrees; beyond, planes are far away
  // The top of the parabola through the best and its neighbours, twice.
  for (const double gap : {0.35, 0.05}) {
    const double left = size(best - gap), middle = size(best), right = size(best + gap),
                 bend = left + right - 2 * middle;
    if (bend >= 0) break;
    const double top = best + gap * std::clamp(0.5 * (left - right) / bend, -1.0, 1.0);
    if (size(top) > middle) best = top;
  }
  return size(best);
}

/// Largest second derivative by the angle of a turn of the light's direction about some axis: sin^2 S + sin cos g, with
/// the axis' angle to the light, S the curvature on the sphere along the turn and g the slope square to it.
double by_a_turn(const Derivatives& d, const Vector2d& tangent) {
  // On the sphere the fall with distance is gone.
  const double s = tangent.dot(d.curvature * tangent) + 2 * d.value;
  const double g = d.slope.dot(Vector2d(-tangent.y(), tangent.x()));
  return (std::abs(s) + std::hypot(s, g)) / 2;
}

using Size = double (*)(const Derivatives&, const Vector2d&);

/// Over all tangents; `directions` of them.
double largest(const Derivatives& d, Size size, int directions) {
  double most = 0;
  for (int i = 0; i < directions; ++i) {
    const double angle = kPi * i / directions;
    most = std::max(most, size(d, {std::cos(angle), std::sin(angle)}));
  }
  // The curvature's own axes, where an anisotropic highlight bends most.
  const double own = 0.5 * std::atan2(2 * d.curvature(0, 1), d.curvature(0, 0) - d.curvature(1, 1));
  for (const double angle : {own, own + kPi / 2}) most = std::max(most, size(d, {std::cos(angle), std::sin(angle)}));
  return most;
}

/// The best places so far, for a figure that is to be as large as can be.
class Best {
 public:
  void offer(double value, const Element& element) {
    if (!(value > 0) || (places_.size() == kImproved && value <= places_.back().value)) return;
    const auto at = std::find_if(places_.begin(), places_.end(), [&](const Place& p) { return p.value < value; });
    places_.insert(at, {value, element});
    if (places_.size() > kImproved) places_.pop_back();
  }
  /// Each place moved about with ever smaller steps while that makes it larger.
  double improved(const Reflectance& reflectance, const std::function<double(const Element&)>& value) const {
    double most = 0;
    const double least = std::cos(reflectance.steepest_eye());
    for (Place place : places_) {
      for (double step = 0.1; step > 1e-5; step /= 2) {
        for (bool moved = true; moved;) {
          moved = false;
          for (int axis = 0; axis < 8; ++axis) {
            Element next = place.element;
            Vector3d& direction = axis < 4 ? next.light : next.eye;
            const auto [u, v] = tangents_of(direction);
            direction = (direction + (axis % 2 ? step : -step) * (axis / 2 % 2 ? u : v)).normalized();
            if (next.light.z() <= 0 || next.eye.z() < least) continue;
            if (const double at = value(next); at > place.value * (1 + 1e-6)) {
              place = {at, next};
              moved = true;
            }
          }
        }
      }
      most = std::max(most, place.value);
    }
    return most;
  }

 private:
  struct Place {
    double value;
    Element element;
  };
  std::vector<Place> places_;  ///< the largest first
};

Vector3d direction(double angle, double azimuth) {
  return {std::sin(angle) * std::cos(azimuth), std::sin(angle) * std::sin(azimuth), std::cos(angle)};
}

void for_each_eye(const Reflectance& reflectance, const std::function<void(const Vector3d&)>& visit) {
  const int azimuths = reflectance.isotropic() ? 1 : kEyeAzimuths;
  for (int i = 0; i < kEyeAngles; ++i)
    for (int j = 0; j < (i == 0 ? 1 : azimuths); ++j)
      visit(direction(reflectance.steepest_eye() * i / (kEyeAngles - 1), 2 * kPi * j / azimuths));
}

/// Directions round an axis, ever closer to it.
void for_each_light(const Vector3d& axis, double closest, const std::function<void(const Vector3d&)>& visit) {
  visit(axis);
  const auto [u, v] = tangents_of(axis);
  const double growth = std::pow(kPi / closest, 1.0 / kRadii);
  double radius = closest;
  for (int i = 0; i < kRadii; ++i, radius *= growth)
    for (int j = 0; j < kAzimuths; ++j) {
      const double azimuth = 2 * kPi * j / kAzimuths;
      visit(std::cos(radius) * axis + std::sin(radius) * (std::cos(azimuth) * u + std::sin(azimuth) * v));
    }
}

double known(double value) {
  return std::isfinite(value) ? value : 0;
}

}  // namespace

ExposureBounds lobe_bounds(std::span<const ReflectanceLobe> lobes) {
  ExposureBounds bounds;
  for (const auto& [weight, exponent] : lobes) {
    bounds.brightest += weight;
    bounds.point_curvature += weight * (exponent + 3);
    bounds.direction_curvature += weight * (exponent + 1);
    bounds.horizon_slope += weight;
  }
  return bounds;
}

ExposureBounds search_bounds(const Reflectance& reflectance) {
  const Exposure exposure(reflectance);
  Best brightest, point, turn, horizon;
  for_each_eye(reflectance, [&](const Vector3d& eye) {
    std::vector<Vector3d> axes = reflectance.highlights(eye);
    axes.push_back(Vector3d::UnitZ());
    for (const Vector3d& axis : axes)
      for_each_light(axis, kClosest * reflectance.resolution(), [&](const Vector3d& light) {
        const Element element{light, eye};
        const std::optional<Derivatives> d = exposure.derivatives(element);
        if (!d) return;
        brightest.offer(d->value, element);
        point.offer(largest(*d, along_a_line, 2), element);
        turn.offer(largest(*d, by_a_turn, 2), element);
      });
    for (int i = 0; i < 2 * kAzimuths; ++i) {
      const Element element{direction(kPi / 2 - kNearHorizon, kPi * i / kAzimuths), eye};
      horizon.offer(known(reflectance.value(element.light, eye)), element);
    }
  });
  const auto curvature = [&](Size size) {
    return [&exposure, size](const Element& element) {
      const std::optional<Derivatives> d = exposure.derivatives(element);
      return d ? largest(*d, size, 12) : 0;
    };
  };
  ExposureBounds bounds;
  bounds.brightest =
      brightest.improved(reflectance, [&](const Element& e) { return known(exposure.at(e.light, e.eye)); });
  bounds.point_curvature = kMargin * point.improved(reflectance, curvature(along_a_line));
  bounds.direction_curvature = kMargin * turn.improved(reflectance, curvature(by_a_turn));
  bounds.horizon_slope = kMargin * horizon.improved(reflectance, [&](const Element& e) {
    const Vector3d light = direction(kPi / 2 - kNearHorizon, std::atan2(e.light.y(), e.light.x()));
    return known(reflectance.value(light, e.eye));
  });
  return bounds;
}

}  // namespace sheen
