// SPDX-License-Identifier: Apache-2.0
#include "common/simulation/reflectance.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cmath>

namespace sheen {
namespace {

/// Smith's Lambda for GGX.
float lambda(float cosine, float alpha) {
  const float c2 = cosine * cosine;
  return (std::sqrt(1 + alpha * alpha * std::max(0.0f, 1 - c2) / std::max(c2, 1e-8f)) - 1) / 2;
}

float fresnel_rise(float cosine) {
  const float m = 1 - std::clamp(cosine, 0.0f, 1.0f), m2 = m * m;
  return m2 * m2 * m;
}

/// Half vector seen by the eye.
Eigen::Vector3f sample_visible_normal(const Eigen::Vector3f& eye, float alpha, float u0, float u1) {
  const Eigen::Vector3f stretched = Eigen::Vector3f(alpha * eye.x(), alpha * eye.y(), eye.z()).normalized();
  const float side = std::hypot(stretched.x(), stretched.y());
  const Eigen::Vector3f t1 =
      side > 1e-6f ? Eigen::Vector3f(-stretched.y() / side, stretched.x() / side, 0) : Eigen::Vector3f::UnitX();
  const Eigen::Vector3f t2 = stretched.cross(t1);
  const float r = std::sqrt(u0), phi = 2 * float(M_PI) * u1;
  const float a = r * std::cos(phi);
  const float s = 0.5f * (1 + stretched.z());
  const float b = (1 - s) * std::sqrt(std::max(0.0f, 1 - a * a)) + s * r * std::sin(phi);
  const Eigen::Vector3f n = a * t1 + b * t2 + std::sqrt(std::max(0.0f, 1 - a * a - b * b)) * stretched;
  return Eigen::Vector3f(alpha * n.x(), alpha * n.y(), std::max(0.0f, n.z())).normalized();
}

/// The lobe's albedo is F0 * scale + bias; both depend on the eye's cosine and on alpha alone.
struct AlbedoTable {
  static constexpr int kSide = 32;
  std::array<std::array<Eigen::Array2f, kSide>, kSide> entry;  // [alpha][cosine]
  std::array<Eigen::Array2f, kSide> mean;                      // [alpha], over the hemisphere

  AlbedoTable() {
    constexpr int kSamples = 32;
    for (int a = 0; a < kSide; ++a) {
      Eigen::Array2f weighted = Eigen::Array2f::Zero();
      float weight_sum = 0;
      for (int c = 0; c < kSide; ++c) {
        const float alpha = std::max(0.02f, float(a) / (kSide - 1)), cosine = std::max(0.01f, float(c) / (kSide - 1));
        const Eigen::Vector3f eye(std::sqrt(1 - cosine * cosine), 0, cosine);
        Eigen::Array2f sum = Eigen::Array2f::Zero();
        for (int i = 0; i < kSamples; ++i)
          for (int j = 0; j < kSamples; ++j) {
            const Eigen::Vector3f half =
                sample_visible_normal(eye, alpha, (i + 0.5f) / kSamples, (j + 0.5f) / kSamples);
            const float light_cosine = 2 * eye.dot(half) * half.z() - eye.z();
            if (light_cosine <= 0) continue;
            const float l_eye = lambda(cosine, alpha), l_light = lambda(light_cosine, alpha);
            const float shadowing = (1 + l_eye) / (1 + l_eye + l_light), rise = fresnel_rise(eye.dot(half));
            sum += shadowing * Eigen::Array2f(1 - rise, rise);
          }
        entry[a][c] = sum / (kSamples * kSamples);
        const float end = c == 0 || c == kSide - 1 ? 0.5f : 1.0f;
        weighted += end * cosine * entry[a][c];
        weight_sum += end * cosine;
      }
      mean[a] = weighted / weight_sum;
    }
  }
};

const AlbedoTable& albedo_table() {
  static const AlbedoTable table;
  return table;
}

/// Place in a table of `AlbedoTable::kSide` entries over 0..1.
struct TablePlace {
  int index;
  float rest;
  explicit TablePlace(float x) {
    const float scaled = std::clamp(x, 0.0f, 1.0f) * (AlbedoTable::kSide - 1);
    index = std::min(static_cast<int>(scaled), AlbedoTable::kSide - 2);
    rest = scaled - index;
  }
};

}  // namespace

Eigen::Array3f fresnel(const Eigen::Array3f& normal_reflectance, float cosine) {
  return normal_reflectance + (1 - normal_reflectance) * fresnel_rise(cosine);
}

Eigen::Array3f ggx(const Material& material, const Eigen::Vector3f& eye, const Eigen::Vector3f& light) {
  if (eye.z() <= 0 || light.z() <= 0) return Eigen::Array3f::Zero();
  const Eigen::Vector3f half = (eye + light).normalized();
  const float a2 = material.roughness * material.roughness;
  const float d = half.z() * half.z() * (a2 - 1) + 1;
  const float density = a2 / (float(M_PI) * d * d);
  const float shadowing = 1 / (1 + lambda(eye.z(), material.roughness) + lambda(light.z(), material.roughness));
  return fresnel(material.normal_reflectance, eye.dot(half)) * (density * shadowing / (4 * eye.z() * light.z()));
}

LobeSample sample_ggx(const Material& material, const Eigen::Vector3f& eye, float u0, float u1) {
  const Eigen::Vector3f half = sample_visible_normal(eye, material.roughness, u0, u1);
  const Eigen::Vector3f light = 2 * eye.dot(half) * half - eye;
  if (light.z() <= 0) return {light, Eigen::Array3f::Zero()};
  const float l_eye = lambda(eye.z(), material.roughness), l_light = lambda(light.z(), material.roughness);
  return {light, fresnel(material.normal_reflectance, eye.dot(half)) * ((1 + l_eye) / (1 + l_eye + l_light))};
}

Eigen::Array3f lobe_albedo(const Material& material, float eye_cosine) {
  const AlbedoTable& table = albedo_table();
  const TablePlace a(material.roughness), c(eye_cosine);
  const auto along_cosine = [&](int row) -> Eigen::Array2f {
    return table.entry[row][c.index] * (1 - c.rest) + table.entry[row][c.index + 1] * c.rest;
  };
  const Eigen::Array2f e = along_cosine(a.index) * (1 - a.rest) + along_cosine(a.index + 1) * a.rest;
  return material.normal_reflectance * e[0] + e[1];
}

Eigen::Array3f mean_lobe_albedo(const Material& material) {
  const AlbedoTable& table = albedo_table();
  const TablePlace a(material.roughness);
  const Eigen::Array2f e = table.mean[a.index] * (1 - a.rest) + table.mean[a.index + 1] * a.rest;
  return material.normal_reflectance * e[0] + e[1];
}

}  // namespace sheen
