// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>

namespace sheen {

/// How a point of a surface reflects light: a Lambertian base under a GGX microfacet lobe with Schlick's Fresnel term.
/// What the lobe reflects is taken from the base, so no more leaves than arrives.
struct Material {
  Eigen::Array3f albedo{0.5f, 0.5f, 0.5f};     ///< of the base
  Eigen::Array3f normal_reflectance{0, 0, 0};  ///< F0 of the lobe; zero switches it off
  float roughness = 0.3f;                      ///< GGX alpha
};

/// Exponent of the Phong lobe that is as wide as a GGX lobe of this alpha.
inline float phong_exponent(float alpha) {
  return 2 / (alpha * alpha) - 2;
}

/// Schlick's Fresnel reflectance; `cosine` is between half vector and either direction.
Eigen::Array3f fresnel(const Eigen::Array3f& normal_reflectance, float cosine);

/// The GGX lobe's BRDF for unit directions to the eye and to the light, in the frame whose z is the normal (1/sr).
Eigen::Array3f ggx(const Material& material, const Eigen::Vector3f& eye, const Eigen::Vector3f& light);

/// Points of the unit disc from which directions into a lobe are drawn, as many as fill a vector register.
struct LobePoints {
  static constexpr int kCount = 8;
  using Values = Eigen::Array<float, kCount, 1>;

  Values x = Values::Zero(), y = Values::Zero();
  int count = 0;  ///< of them used, the first ones

  /// The point that evenly fills the disc for u in [0, 1)^2.
  void add(float u0, float u1);
};

/// Directions towards the light, drawn from the normals that the eye sees (Heitz 2018), and what their radiance is to
/// be multiplied with: normal reflectance * scale + bias. Both are zero where the direction points into the surface.
struct LobeSamples {
  LobePoints::Values x, y, z, scale, bias;
};
LobeSamples sample_ggx(float roughness, const Eigen::Vector3f& eye, const LobePoints& points);

/// Part of the light that the lobe reflects towards an eye at this cosine to the normal, were the light the same from
/// everywhere. From a table that is integrated once.
Eigen::Array3f lobe_albedo(const Material& material, float eye_cosine);

/// `lobe_albedo` averaged over the hemisphere: what the lobe reflects of uniform light in all.
Eigen::Array3f mean_lobe_albedo(const Material& material);

}  // namespace sheen
