// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <array>
#include <filesystem>

#include "common/image/image.h"

namespace sheen {

/// A picture as a polynomial of a far light's direction (Malzbender 2001): per pixel and colour the coefficients of 1,
/// x, y, x^2, xy, y^2 of the unit vector to the light (x right, y up in the picture), for sRGB-encoded values 0..1.
struct PolynomialTexture {
  static constexpr int kTerms = 6;
  std::array<ImageF, kTerms> planes;  ///< 3 channels each

  static std::array<double, kTerms> terms(const Eigen::Vector3d& light);
  /// Encoded values, not clamped.
  ImageF picture(const Eigen::Vector3d& light) const;
};

/// Fits one to pictures, which are not kept.
class PolynomialFit {
 public:
  PolynomialFit(int width, int height);
  /// light: towards it, any length; encoded: 3 channels.
  void add(const Eigen::Vector3d& light, const ImageF& encoded);
  /// In the sense of least squares. Throws ConfigError where there are too few lights, or all on a curve.
  PolynomialTexture texture() const;

 private:
  Eigen::Matrix<double, PolynomialTexture::kTerms, PolynomialTexture::kTerms> gram_;
  std::array<ImageF, PolynomialTexture::kTerms> sums_;
};

/// A .ptm file (version 1.2, PTM_FORMAT_RGB: 8 bits per coefficient). Throws FileError.
void write_ptm(const std::filesystem::path& file, const PolynomialTexture& texture);

/// A folder in the format of the relight tools, which OpenLIME shows: info.json, plane_0.jpg to plane_5.jpg, and
/// index.html, a page that shows it with OpenLIME's openlime.umd.js beside it. Throws FileError.
void write_relight(const std::filesystem::path& folder, const PolynomialTexture& texture);

}  // namespace sheen
