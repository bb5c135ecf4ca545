// SPDX-License-Identifier: Apache-2.0
#include "reconstructor/numerics/reflectance.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <limits>
#include <stdexcept>

namespace sheen {
namespace {

using Eigen::Vector3d;
constexpr double kPi = std::numbers::pi, kUnknown = std::numeric_limits<double>::quiet_NaN();
constexpr double kLargestExponent = 1e5;

Vector3d mirrored(const Vector3d& eye) {
  return {-eye.x(), -eye.y(), eye.z()};
}

/// A difference over this is exact to a few parts in 10^5 for a lobe of this exponent.
double resolution_of(double exponent) {
  return 0.005 / std::sqrt(std::max(exponent, 1.0) + 3);
}

bool is_positive(double weight) {
  return weight > 0 && weight < 1e9;
}

/// (L.w)^k. With k = 1 there is a kink where it ends, which no bound of second derivatives covers: not known beyond.
double lobe(double cosine, double exponent) {
  if (exponent == 0) return 1;
  if (cosine <= 0) return exponent < 2 ? kUnknown : 0;
  return std::pow(cosine, exponent);
}

double microfacets(const AnalyticReflectance::Microfacets& part, const Vector3d& light, const Vector3d& eye) {
  const Vector3d half = (light + eye).normalized();
  const double a2 = part.roughness * part.roughness, nh = half.z(), lh = light.dot(half);
  const double spread = nh * nh * (a2 - 1) + 1;
  const auto smith = [&](double cosine) { return cosine + std::sqrt(a2 + (1 - a2) * cosine * cosine); };
  const double fresnel = part.normal_reflectance + (1 - part.normal_reflectance) * std::pow(1 - lh, 5);
  return fresnel * a2 / (spread * spread) / (smith(light.z()) * smith(eye.z()));
}

/// The nodes of an axis that a value between two of them is made of: the cubic whose slopes at both are those of the
/// parabolas through three nodes each. Linear interpolation would have kinks, and a slope that is off by half a cell.
struct NodeWeights {
  std::size_t first = 0, count = 1;
  std::array<double, 4> weights{1, 0, 0, 0};
};
NodeWeights node_weights(const std::vector<double>& axis, double at) {
  NodeWeights nodes;
  const std::size_t last = axis.size() - 1;
  if (at <= axis.front()) return nodes;
  if (at >= axis.back()) {
    nodes.first = last;
    return nodes;
  }
  const auto i = static_cast<std::size_t>(std::upper_bound(axis.begin(), axis.end(), at) - axis.begin()) - 1;
  const double gap = axis[i + 1] - axis[i], s = (at - axis[i]) / gap;
  nodes.first = i == 0 ? 0 : i - 1;
  nodes.count = std::min(i + 2, last) - nodes.first + 1;
  nodes.weights = {};
  nodes.weights[i - nodes.first] = s * s * (2 * s - 3) + 1;
  nodes.weights[i + 1 - nodes.first] = s * s * (3 - 2 * s);
  if (last == 1) {
    nodes.weights = {1 - s, s, 0, 0};
    return nodes;
  }
  for (const auto& [node, amount] : {std::pair{i, s * (1 - s) * (1 - s)}, std::pair{i + 1, s * s * (s - 1)}}) {
    const std::size_t middle = std::clamp(node, std::size_t{1}, last - 1);
    const double x = axis[node], x0 = axis[middle - 1], x1 = axis[middle], x2 = axis[middle + 1];
    // Slopes of the three parabolas that are 1 at one node and 0 at the others.
    const std::array slopes{(2 * x - x1 - x2) / ((x0 - x1) * (x0 - x2)), (2 * x - x0 - x2) / ((x1 - x0) * (x1 - x2)),
                            (2 * x - x0 - x1) / ((x2 - x0) * (x2 - x1))};
    for (std::size_t n = 0; n < 3; ++n) nodes.weights[middle - 1 + n - nodes.first] += gap * amount * slopes[n];
  }
  return nodes;
}

/// The last axis goes on beyond both ends, for what repeats after pi.
void repeat_after_pi(std::array<std::vector<double>, 3>& axes, std::vector<float>& values) {
  const std::vector<double> axis = axes[2];
  const std::size_t n = axis.size(), rows = values.size() / n, more = std::min<std::size_t>(2, n - 1);
  const bool closed = axis.back() - axis.front() > kPi * (1 - 1e-6);  // the last node is the first again
  const std::size_t used = closed ? n - 1 : n;
  std::vector<float> longer;
  axes[2].clear();
  for (std::size_t j = 0; j < used + 2 * more; ++j) {
    const std::size_t from = (j + used - more) % used;
    axes[2].push_back(axis[from] + (j < more ? -kPi : j >= used + more ? kPi : 0));
  }
  for (std::size_t row = 0; row < rows; ++row)
    for (std::size_t j = 0; j < used + 2 * more; ++j) longer.push_back(values[row * n + (j + used - more) % used]);
  values = std::move(longer);
}

}  // namespace

std::vector<Vector3d> Reflectance::highlights(const Vector3d& eye) const {
  return {mirrored(eye), eye};
}

bool is_lobe_exponent(double exponent) {
  return exponent == 0 || exponent == 1 || (exponent >= 2 && exponent <= kLargestExponent);
}

FreeLobes::FreeLobes(std::vector<ReflectanceLobe> lobes) : lobes_(std::move(lobes)), resolution_(resolution_of(0)) {
  if (lobes_.empty()) throw std::invalid_argument("a reflectance needs a lobe");
  for (const ReflectanceLobe& lobe : lobes_) {
    if (!is_positive(lobe.weight)) throw std::invalid_argument("a lobe's weight must be above 0");
    if (!is_lobe_exponent(lobe.exponent)) throw std::invalid_argument("a lobe's exponent must be 0, 1 or 2 to 100000");
    resolution_ = std::min(resolution_, resolution_of(lobe.exponent));
  }
}

double FreeLobes::value(const Vector3d& light, const Vector3d& eye) const {
  double sum = 0;
  for (const ReflectanceLobe& part : lobes_) sum += part.weight * lobe(light.dot(eye), part.exponent);
  return sum;
}

AnalyticReflectance::AnalyticReflectance(std::vector<Lafortune> lobes, std::vector<Microfacets> microfacets)
    : lobes_(std::move(lobes)), microfacets_(std::move(microfacets)), resolution_(resolution_of(0)) {
  if (lobes_.empty() && microfacets_.empty()) throw std::invalid_argument("has no part that reflects light");
  for (const Lafortune& part : lobes_) {
    if (!is_positive(part.weight)) throw std::invalid_argument("weight must be above 0");
    if (!is_lobe_exponent(part.exponent)) throw std::invalid_argument("exponent must be 0, 1 or 2 to 100000");
    if (!part.c.allFinite() || part.c.cwiseAbs().maxCoeff() > 1 || part.c.isZero())
      throw std::invalid_argument("lafortune must be three numbers between -1 and 1, not all 0");
    resolution_ = std::min(resolution_, resolution_of(part.exponent));
  }
  for (const Microfacets& part : microfacets_) {
    if (!is_positive(part.weight)) throw std::invalid_argument("weight must be above 0");
    if (!(part.roughness >= 0.01 && part.roughness <= 1))
      throw std::invalid_argument("roughness must be between 0.01 and 1");
    if (!(part.normal_reflectance >= 0 && part.normal_reflectance <= 1))
      throw std::invalid_argument("ggx must be a reflectance between 0 and 1");
    resolution_ = std::min(resolution_, 0.001 * part.roughness);
  }
}

double AnalyticReflectance::value(const Vector3d& light, const Vector3d& eye) const {
  double sum = 0;
  for (const Lafortune& part : lobes_) sum += part.weight * lobe(part.c.cwiseProduct(eye).dot(light), part.exponent);
  for (const Microfacets& part : microfacets_) sum += part.weight * sheen::microfacets(part, light, eye);
  return sum;
}

std::vector<Vector3d> AnalyticReflectance::highlights(const Vector3d& eye) const {
  std::vector<Vector3d> found;
  if (!microfacets_.empty()) found.push_back(mirrored(eye));
  for (const Lafortune& part : lobes_)
    if (const Vector3d w = part.c.cwiseProduct(eye); part.exponent > 0 && w.norm() > 0) found.push_back(w.normalized());
  return found;
}

bool AnalyticReflectance::isotropic() const {
  return std::all_of(lobes_.begin(), lobes_.end(),
                     [](const Lafortune& part) { return part.exponent == 0 || part.c.x() == part.c.y(); });
}

TabulatedReflectance::TabulatedReflectance(Coordinates coordinates, std::array<std::vector<double>, 3> axes,
                                           std::vector<float> values, double resolution)
    : coordinates_(coordinates), axes_(std::move(axes)), values_(std::move(values)), resolution_(resolution) {
  std::size_t crossings = 1;
  for (const std::vector<double>& axis : axes_) {
    if (axis.size() < 2) throw std::invalid_argument("each axis needs two angles or more");
    if (!(axis.front() >= 0) || !(axis.back() <= kPi * (1 + 1e-6)) ||
        !std::is_sorted(axis.begin(), axis.end(), std::less_equal<>()))
      throw std::invalid_argument("the angles of an axis must grow, from 0 or more");
    crossings *= axis.size();
  }
  if (values_.size() != crossings)
    throw std::invalid_argument("needs one value for each crossing of its angles: " + std::to_string(crossings) +
                                ", not " + std::to_string(values_.size()));
  if (std::none_of(values_.begin(), values_.end(), [](float value) { return value > 0; }))
    throw std::invalid_argument("reflects no light");
  if (coordinates_ == Coordinates::kHalfDifference) repeat_after_pi(axes_, values_);
}

double TabulatedReflectance::value(const Vector3d& light, const Vector3d& eye) const {
  std::array<double, 3> at;
  const auto angle = [](double cosine) { return std::acos(std::clamp(cosine, -1.0, 1.0)); };
  if (coordinates_ == Coordinates::kLightEye) {
    at = {angle(light.z()), angle(eye.z()),
          std::abs(std::atan2(light.x() * eye.y() - light.y() * eye.x(), light.x() * eye.x() + light.y() * eye.y()))};
  } else {
    const Vector3d half = (light + eye).normalized();
    // The light in the frame whose z is the half vector and whose y is square to it and to the normal.
    const Vector3d y =
        std::hypot(half.x(), half.y()) > 1e-12 ? Vector3d(-half.y(), half.x(), 0).normalized() : Vector3d(0, 1, 0);
    const Vector3d x = y.cross(half);
    double azimuth = std::atan2(light.dot(y), light.dot(x));
    if (azimuth < 0) azimuth += kPi;  // light and eye may change places
    at = {angle(half.z()), angle(light.dot(half)), azimuth};
  }
  std::array<NodeWeights, 3> nodes;
  for (std::size_t i = 0; i < 3; ++i) nodes[i] = node_weights(axes_[i], at[i]);
  double sum = 0;
  for (std::size_t i = 0; i < nodes[0].count; ++i)
    for (std::size_t j = 0; j < nodes[1].count; ++j)
      for (std::size_t k = 0; k < nodes[2].count; ++k) {
        const double weight = nodes[0].weights[i] * nodes[1].weights[j] * nodes[2].weights[k];
        if (weight == 0) continue;
        const float value = values_[((nodes[0].first + i) * axes_[1].size() + nodes[1].first + j) * axes_[2].size() +
                                    nodes[2].first + k];
        if (value < 0) return kUnknown;
        sum += weight * static_cast<double>(value);
      }
  return sum;
}

}  // namespace sheen
