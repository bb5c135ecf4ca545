// SPDX-License-Identifier: Apache-2.0
#include "common/simulation/reflectance.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cmath>

namespace sheen {
namespace {

using Values = LobePoints::Values;

/// Smith's Lambda for GGX.
float lambda(float cosine, float alpha) {
  const float c2 = cosine * cosine;
  return (std::sqrt(1 + alpha * alpha * std::max(0.0f, 1 - c2) / std::max(c2, 1e-8f)) - 1) / 2;
}

Values lambda(const Values& cosine, float alpha) {
  const Values c2 = cosine.square();
  return ((1 + alpha * alpha * (1 - c2).max(0.0f) / c2.max(1e-8f)).sqrt() - 1) / 2;
}

float fresnel_rise(float cosine) {
  const float m = 1 - std::clamp(cosine, 0.0f, 1.0f), m2 = m * m;
  return m2 * m2 * m;
}

Values fresnel_rise(const Values& cosine) {
  const Values m = 1 - cosine.max(0.0f).min(1.0f);
  return m.square().square() * m;
}

struct Vectors {
  Values x, y, z;
  Values dot(const Eigen::Vector3f& v) const { return x * v.x() + y * v.y() + z * v.z(); }
};

/// Half vectors seen by the eye.
Vectors sample_visible_normals(const Eigen::Vector3f& eye, float alpha, const LobePoints& points) {
  const Eigen::Vector3f stretched = Eigen::Vector3f(alpha * eye.x(), alpha * eye.y(), eye.z()).normalized();
  const float side = std::hypot(stretched.x(), stretched.y());
  const Eigen::Vector3f t1 =
      side > 1e-6f ? Eigen::Vector3f(-stretched.y() / side, stretched.x() / side, 0) : Eigen::Vector3f::UnitX();
  const Eigen::Vector3f t2 = stretched.cross(t1);
  const float s = 0.5f * (1 + stretched.z());
  const Values& a = points.x;
  const Values b = (1 - s) * (1 - a.square()).max(0.0f).sqrt() + s * points.y;
  const Values c = (1 - a.square() - b.square()).max(0.0f).sqrt();
  Vectors n{alpha * (a * t1.x() + b * t2.x() + c * stretched.x()),
            alpha * (a * t1.y() + b * t2.y() + c * stretched.y()),
            (a * t1.z() + b * t2.z() + c * stretched.z()).max(0.0f)};
  const Values length = (n.x.square() + n.y.square() + n.z.square()).sqrt();
  n.x /= length;
  n.y /= length;
  n.z /= length;
  return n;
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
          for (int j = 0; j < kSamples; j += LobePoints::kCount) {
            LobePoints points;
            for (int k = 0; k < LobePoints::kCount; ++k) points.add((i + 0.5f) / kSamples, (j + k + 0.5f) / kSamples);
            const LobeSamples samples = sample_ggx(alpha, eye, points);
            sum += Eigen::Array2f(samples.scale.sum(), samples.bias.sum());
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

void LobePoints::add(float u0, float u1) {
  const float r = std::sqrt(u0), phi = 2 * float(M_PI) * u1;
  x[count] = r * std::cos(phi);
  y[count] = r * std::sin(phi);
  ++count;
}

LobeSamples sample_ggx(float roughness, const Eigen::Vector3f& eye, const LobePoints& points) {
  const Vectors half = sample_visible_normals(eye, roughness, points);
  const Values eye_cosine = half.dot(eye);
  LobeSamples samples;
  samples.x = 2 * eye_cosine * half.x - eye.x();
  samples.y = 2 * eye_cosine * half.y - eye.y();
  samples.z = 2 * eye_cosine * half.z - eye.z();
  const float l_eye = lambda(eye.z(), roughness);
  const Values shadowing =
      (samples.z > 0).select((1 + l_eye) / (1 + l_eye + lambda(samples.z, roughness)), Values::Zero());
  samples.bias = shadowing * fresnel_rise(eye_cosine);
  samples.scale = shadowing - samples.bias;
  return samples;
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
