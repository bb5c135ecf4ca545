// SPDX-License-Identifier: Apache-2.0
#include "tracker/pose/focal_length.h"

#include <Eigen/Cholesky>
#include <algorithm>
#include <array>
#include <cmath>

#include "common/base/format.h"
#include "tracker/pose/pose_solver.h"
#include "tracker/pose/reprojection.h"

namespace sheen {
namespace {

constexpr int kSteps = 4;
constexpr double kNoiseFloor_px = 0.02;  ///< of a corner: edges err together, by what their residuals do not show
constexpr double kLeastSigma = 5e-4;     ///< no image counts for more: print and paper are not exact
constexpr double kTells = 0.02;          ///< an image that is less certain says nothing
constexpr std::uint64_t kFewest = 12;    ///< images
constexpr double kSignificant = 4;       ///< standard deviations of the mean
constexpr double kMatters = 0.006;       ///< of the focal length: some pixels at the border of an image
constexpr double kBreathes = 3;          ///< times the variance that the images state

constexpr int kFocal = 6, kSpread = 7, kUnknowns = 8;

using Unknowns = Eigen::Matrix<double, kUnknowns, 1>;
using Normal = Eigen::Matrix<double, kUnknowns, kUnknowns>;
using Jacobian = Eigen::Matrix<double, 2, kUnknowns>;

struct Equations {
  Normal normal = Normal::Zero();
  Unknowns gradient = Unknowns::Zero();
  double squares = 0;
  int values = 0;
};

/// Where each corner goes when all edges of a tag move outwards by a pixel.
std::array<Eigen::Vector2d, 4> outwards(const std::array<Eigen::Vector2d, 4>& corners) {
  const Eigen::Vector2d centre = (corners[0] + corners[1] + corners[2] + corners[3]) / 4;
  std::array<Eigen::Vector2d, 4> normals;  // of the edge behind each corner
  for (std::size_t k = 0; k < 4; ++k) {
    const Eigen::Vector2d along = (corners[(k + 1) % 4] - corners[k]).normalized();
    const Eigen::Vector2d across(along.y(), -along.x());
    normals[k] = across.dot(corners[k] - centre) < 0 ? Eigen::Vector2d(-across) : across;
  }
  std::array<Eigen::Vector2d, 4> moved;
  for (std::size_t k = 0; k < 4; ++k) {
    const Eigen::Vector2d &a = normals[k], &b = normals[(k + 3) % 4];
    moved[k] = (a + b) / std::max(0.1, 1 + a.dot(b));
  }
  return moved;
}

/// Of the reprojection, by a step of the pose, of the logarithm of the focal length, and of the place of all edges: ink
/// that spreads, blur before a tone curve and JPEG move those outwards or inwards, which looks like another lens.
std::optional<Equations> linearised(const Camera& camera, const StageLayout& stage,
                                    const std::vector<TagObservation>& tags, const Rigid3& pose, double spread_px) {
  Equations equations;
  for (const TagObservation& tag : tags) {
    const StageTag* const known = tag.used ? stage.find(tag.id) : nullptr;
    const std::array<Eigen::Vector2d, 4> spread = outwards(tag.corners);
    for (std::size_t k = 0; known && k < tag.corners.size(); ++k) {
      const auto projection = project_with_jacobian(camera, pose, known->corners_object[k]);
      if (!projection) return std::nullopt;
      Jacobian jacobian;
      jacobian << projection->jacobian, projection->pixel - Eigen::Vector2d(camera.cx, camera.cy), spread[k];
      const Eigen::Vector2d error = projection->pixel + spread_px * spread[k] - tag.corners[k];
      equations.normal += jacobian.transpose() * jacobian;
      equations.gradient += jacobian.transpose() * error;
      equations.squares += error.squaredNorm();
      equations.values += 2;
    }
  }
  return equations;
}

}  // namespace

std::optional<FocalDeviation> focal_deviation(const Camera& camera, const StageLayout& stage,
                                              const std::vector<TagObservation>& tags, const Rigid3& pose) {
  Camera scaled = camera;
  Rigid3 moving = pose;
  double log_scale = 0, spread_px = 0;
  for (int i = 0;; ++i) {
    const auto equations = linearised(scaled, stage, tags, moving, spread_px);
    if (!equations || equations->values <= kUnknowns) return std::nullopt;
    const Eigen::LDLT<Normal> solver(equations->normal);
    if (i == kSteps) {
      const double variance =
          std::max(equations->squares / (equations->values - kUnknowns), kNoiseFloor_px * kNoiseFloor_px);
      const double sigma = std::sqrt(variance * solver.solve(Unknowns::Unit(kFocal))[kFocal]);
      if (!std::isfinite(sigma) || !(sigma > 0)) return std::nullopt;
      return FocalDeviation{std::expm1(log_scale), sigma};
    }
    const Unknowns step = solver.solve(-equations->gradient);
    if (!step.allFinite()) return std::nullopt;
    moving = moved(moving, step.head<6>());
    log_scale += step[kFocal];
    spread_px += step[kSpread];
    if (std::abs(log_scale) > 1) return std::nullopt;
    scaled.fx = camera.fx * std::exp(log_scale);
    scaled.fy = camera.fy * std::exp(log_scale);
  }
}

void FocalWatch::add(const FocalDeviation& deviation) {
  if (!(deviation.sigma < kTells)) return;
  const double weight = 1 / std::pow(std::max(deviation.sigma, kLeastSigma), 2);
  ++images_;
  weights_ += weight;
  sum_ += weight * deviation.fraction;
  squares_ += weight * deviation.fraction * deviation.fraction;
}

double FocalWatch::mean() const {
  return weights_ > 0 ? sum_ / weights_ : 0;
}

double FocalWatch::excess() const {
  if (images_ < 2) return 1;
  return std::max(0.0, squares_ - sum_ * sum_ / weights_) / static_cast<double>(images_ - 1);
}

double FocalWatch::sigma() const {
  return weights_ > 0 ? std::sqrt(std::max(1.0, excess()) / weights_) : 0;
}

double FocalWatch::spread() const {
  if (images_ < 2) return 0;
  return std::sqrt(std::max(0.0, excess() - 1) * static_cast<double>(images_) / weights_);
}

std::string FocalWatch::finding() const {
  if (images_ < kFewest) return {};
  constexpr const char* kRemedy =
      ": lock focus and zoom in the camera or its app, calibrate as it is then, and capture again";
  if (spread() > kMatters && excess() > kBreathes)
    return format("the focal length changes by %.1f %% from image to image (autofocus)", 100 * spread()) + kRemedy;
  if (std::abs(mean()) > kMatters && std::abs(mean()) > kSignificant * sigma())
    return format("the focal length is %.1f %% %s than the calibrated one, in all images", 100 * std::abs(mean()),
                  mean() > 0 ? "longer" : "shorter") +
           kRemedy;
  return {};
}

}  // namespace sheen
