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

/// A direction towards the light, drawn from the normals that the eye sees (Heitz 2018), for u in [0, 1)^2, and what
/// its radiance is to be multiplied with. The weight is zero where the direction points into the surface.
struct LobeSample {
  Eigen::Vector3f light;
  Eigen::Array3f weight;
};
LobeSample sample_ggx(const Material& material, const Eigen::Vector3f& eye, float u0, float u1);

/// Part of the light that the lobe reflects towards an eye at this cosine to the normal, were the light the same from
/// everywhere. From a table that is integrated once.
Eigen::Array3f lobe_albedo(const Material& material, float eye_cosine);

/// `lobe_albedo` averaged over the hemisphere: what the lobe reflects of uniform light in all.
Eigen::Array3f mean_lobe_albedo(const Material& material);

}  // namespace sheen
