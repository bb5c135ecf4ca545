// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <array>
#include <numbers>
#include <vector>

namespace sheen {

/// How a point of a surface reflects light: its BRDF, in any unit. Directions are unit vectors away from the point, in
/// the frame whose z is the normal.
class Reflectance {
 public:
  virtual ~Reflectance() = default;
  /// For a light and an eye above the surface (z > 0); NaN where it is not known.
  virtual double value(const Eigen::Vector3d& light, const Eigen::Vector3d& eye) const = 0;
  /// Where highlights may be, as directions to the light: what is narrow is looked for there.
  virtual std::vector<Eigen::Vector3d> highlights(const Eigen::Vector3d& eye) const;
  /// Whether it stays the same when light and eye turn about the normal together.
  virtual bool isotropic() const { return true; }
  /// Detail finer than this angle (radians) is not there, or is not to be believed: derivatives are differences over
  /// it.
  virtual double resolution() const { return 1e-3; }
  /// Eyes further from the normal (radians) are left out: their values are seldom measured and seldom believable.
  virtual double steepest_eye() const { return kSteepestMeasuredEye; }

  static constexpr double kSteepestMeasuredEye = 80 * std::numbers::pi / 180;
};

/// A lobe of a reflectance: weight * (L.w)^exponent, with |w| <= 1 any vector that goes with the surface (Lafortune
/// 1997); exponent 0 is a Lambertian one. Only the weights' ratios count.
struct ReflectanceLobe {
  double weight = 1;    ///< > 0
  double exponent = 0;  ///< 0, 1 or at least 2: between them the second derivative has no bound
};

/// Whether a lobe of this exponent has a bounded second derivative, and is not too narrow to be searched.
bool is_lobe_exponent(double exponent);

/// Lobes round one direction w, which is anywhere: where the eye is said to be.
class FreeLobes : public Reflectance {
 public:
  /// Throws std::invalid_argument for lobes that are none.
  explicit FreeLobes(std::vector<ReflectanceLobe> lobes);
  double value(const Eigen::Vector3d& light, const Eigen::Vector3d& eye) const override;
  std::vector<Eigen::Vector3d> highlights(const Eigen::Vector3d& eye) const override { return {eye}; }
  double resolution() const override { return resolution_; }
  double steepest_eye() const override { return std::numbers::pi / 2; }

 private:
  std::vector<ReflectanceLobe> lobes_;
  double resolution_;
};

/// A sum of analytic parts: Lambertian ones, lobes of Lafortune's and microfacets.
class AnalyticReflectance : public Reflectance {
 public:
  /// (C.x lx ex + C.y ly ey + C.z lz ez)^exponent; exponent 0 is Lambertian.
  struct Lafortune {
    double weight = 1;
    Eigen::Vector3d c{-1, -1, 1};
    double exponent = 0;
  };
  /// GGX with Smith's masking and Schlick's Fresnel term, times pi: a Lambertian part of albedo a is a.
  struct Microfacets {
    double weight = 1, normal_reflectance = 0.04, roughness = 0.3;
  };
  /// Throws std::invalid_argument that says what of them is none.
  AnalyticReflectance(std::vector<Lafortune> lobes, std::vector<Microfacets> microfacets);
  double value(const Eigen::Vector3d& light, const Eigen::Vector3d& eye) const override;
  std::vector<Eigen::Vector3d> highlights(const Eigen::Vector3d& eye) const override;
  bool isotropic() const override;
  double resolution() const override { return resolution_; }

 private:
  std::vector<Lafortune> lobes_;
  std::vector<Microfacets> microfacets_;
  double resolution_;
};

/// Values at the crossings of a grid of angles, and cubics between them. Isotropic.
class TabulatedReflectance : public Reflectance {
 public:
  enum class Coordinates {
    kLightEye,        ///< angle of light and of eye to the normal, azimuth between them
    kHalfDifference,  ///< of the half vector to the normal; of the light to it; azimuth of that (Rusinkiewicz 1998)
  };
  /// axes: radians, growing, two or more each, of which the azimuth's last is pi or less: it is mirrored (light and
  /// eye) or repeated (half vector) there. values: the last axis fastest; negative ones are not known. Throws
  /// std::invalid_argument.
  TabulatedReflectance(Coordinates coordinates, std::array<std::vector<double>, 3> axes, std::vector<float> values,
                       double resolution);
  double value(const Eigen::Vector3d& light, const Eigen::Vector3d& eye) const override;
  double resolution() const override { return resolution_; }

 private:
  Coordinates coordinates_;
  std::array<std::vector<double>, 3> axes_;
  std::vector<float> values_;
  double resolution_;
};

}  // namespace sheen
