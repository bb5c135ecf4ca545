// SPDX-License-Identifier: Apache-2.0
#include "common/registration/image_registration.h"

#include <Eigen/Cholesky>
#include <algorithm>
#include <array>
#include <cmath>

#include "common/base/errors.h"
#include "common/base/order_statistics.h"
#include "common/registration/outline_evidence.h"
#include "common/registration/placement_fit.h"
#include "common/registration/texture_evidence.h"

namespace sheen {
namespace {

constexpr std::array kLosses_px{32.0, 8.0, 3.0, 1.5};  // of outlines, from coarse to fine
constexpr double kCommonError_px = 0.25;  // of what all images get wrong alike: how masks round, how highlights drift
constexpr int kGroups = 20;
constexpr double kReach_px = 1.5;   // of the level: how far the mesh moves before it is looked at again
constexpr double kStill_px = 0.02;  // of the level: it has not moved
constexpr int kLooks = 8;           // at each level, how often it is asked again who sees what
constexpr double kMargin_px = 2;    // of points inside the outline: the detail's window

/// Images that look from about the same side: the farthest of all from those that there are begins the next group.
std::vector<int> groups_by_side(std::span<const RegistrationImage> images, const Eigen::Vector3d& centre) {
  std::vector<Eigen::Vector3d> sides;
  for (const RegistrationImage& image : images)
    sides.push_back((camera_centre(image.view.camera_from_object) - centre).normalized());
  std::vector<int> groups(images.size(), 0);
  std::vector<double> nearest(images.size(), HUGE_VAL);
  std::size_t seed = 0;
  for (int group = 0; group < std::min(kGroups, static_cast<int>(images.size())); ++group) {
    for (std::size_t i = 0; i < sides.size(); ++i) {
      const double distance = (sides[i] - sides[seed]).norm();
      if (distance >= nearest[i]) continue;
      nearest[i] = distance;
      groups[i] = group;
    }
    seed = static_cast<std::size_t>(std::max_element(nearest.begin(), nearest.end()) - nearest.begin());
  }
  return groups;
}

/// What a pixel is wide at the mesh, metres.
double mean_pixel(std::span<const RegistrationImage> images, const Eigen::Vector3d& centre) {
  double sum = 0;
  for (const RegistrationImage& image : images)
    sum += (image.view.camera_from_object * centre).norm() / std::sqrt(image.view.camera.fx * image.view.camera.fy);
  return sum / static_cast<double>(images.size());
}

/// The fit of all images, and those of the halves from there.
struct Fits {
  PlacementFit both, even, odd;
};

Fits with_halves(const PlacementFit& both, const FitOptions& options, const std::function<Equations(Half)>& equations) {
  return {both, fit_placement(both.stage_from_mesh, equations(Half::kEven), options),
          fit_placement(both.stage_from_mesh, equations(Half::kOdd), options)};
}

void judge_by_halves(const Fits& fits, const FitOptions& options, ImageRegistration& result) {
  result.placement = {fits.both.stage_from_mesh, options.centre, fits.both.covariance};
  result.undetermined = fits.both.undetermined;
  if (fits.even.residuals == 0 || fits.odd.residuals == 0) return;
  result.halves = step_between(fits.even.stage_from_mesh, fits.odd.stage_from_mesh, options.centre);
  const int n = options.free_scale ? 7 : 6;
  // Half of the images: twice the covariance; a difference of two: twice that.
  const Eigen::MatrixXd expected = 4 * fits.both.covariance.topLeftCorner(n, n);
  const Eigen::VectorXd difference = result.halves.head(n);
  result.halves_sigmas = std::sqrt(std::max(0.0, difference.dot(expected.ldlt().solve(difference)) / n));
  result.placement.covariance *= std::max(1.0, std::pow(result.halves_sigmas, 2));
}

Fits fit_outlines(const OutlineEvidence& outlines, const Similarity& start, FitOptions options,
                  const std::function<void()>& step_done) {
  PlacementFit fit{.stage_from_mesh = start};
  const auto at = [&](double loss_px, Half half) -> Equations {
    return [&outlines, &options, loss_px, half](const Similarity& place) {
      return outlines.equations(place, options.centre, loss_px, half);
    };
  };
  for (const double loss_px : kLosses_px) {
    fit = fit_placement(fit.stage_from_mesh, at(loss_px, Half::kBoth), options);
    step_done();
  }
  return with_halves(fit, options, [&](Half half) { return at(kLosses_px.back(), half); });
}

/// At each level, until the mesh stays: who sees what changes while it moves.
class TextureFit {
 public:
  TextureFit(TextureEvidence& texture, const FitOptions& options, double pixel_m)
      : texture_(texture), options_(options), pixel_m_(pixel_m) {}

  PlacementFit descend(const Similarity& start, int from_level, int to_level, const std::function<void()>& level_done) {
    PlacementFit fit{.stage_from_mesh = start};
    for (int level = from_level; level >= to_level; --level) {
      const double pixel_m = pixel_m_ * (1 << level);
      options_.probe_m = pixel_m / 2;
      options_.reach_m = kReach_px * pixel_m;
      for (int look = 0; look < kLooks; ++look) {
        const Similarity before = fit.stage_from_mesh;
        texture_.see(before, level, kMargin_px);
        fit = fit_placement(before, equations(Half::kBoth), options_);
        PlacementStep step = step_between(before, fit.stage_from_mesh, options_.centre);
        step.head<3>() *= options_.radius;
        step[6] *= options_.radius;
        if (step.norm() < kStill_px * pixel_m) break;
      }
      level_done();
    }
    return fit;
  }

  /// From each level that the mesh can be seen at: the finest of them finds what is near, the coarsest what is far, and
  /// may take one rib for the next. The images' agreement decides.
  Fits best(const Similarity& start, const std::function<void()>& level_done) {
    Similarity best = start;
    double agreement = -1;
    const int coarsest = texture_.coarsest(start), shared = std::min(1, coarsest);
    for (int level = shared; level <= coarsest; ++level) {
      const PlacementFit fit = descend(start, level, shared, level_done);
      texture_.see(fit.stage_from_mesh, shared, kMargin_px);
      const double found = texture_.agreement(fit.stage_from_mesh).correlation;
      if (found <= agreement) continue;
      agreement = found;
      best = fit.stage_from_mesh;
    }
    const PlacementFit fit = descend(best, 0, 0, level_done);
    return with_halves(fit, options_, [this](Half half) { return equations(half); });
  }

 private:
  Equations equations(Half half) const {
    return [this, half](const Similarity& place) { return texture_.equations(place, options_.centre, half); };
  }

  TextureEvidence& texture_;
  FitOptions options_;
  double pixel_m_;
};

}  // namespace

const char* to_string(Evidence evidence) {
  return evidence == Evidence::kOutlines ? "outlines" : "texture";
}

ImageRegistration register_to_images(const Mesh& mesh, std::span<const RegistrationImage> images,
                                     const Similarity& start, bool free_scale, const StepsDone& progress) {
  const RayScene scene(mesh);
  const BoundingSphere sphere = bounding_sphere(mesh);
  FitOptions options{.centre = start * sphere.centre, .radius = start.scale * sphere.radius, .free_scale = free_scale};
  options.groups = groups_by_side(images, options.centre);
  const double pixel_m = mean_pixel(images, options.centre);
  options.probe_m = pixel_m / 2;
  std::size_t done = 0, steps = 0;
  const auto step_done = [&] {
    if (progress) progress(++done, steps);
  };

  ImageRegistration result;
  const OutlineEvidence outlines(mesh, scene, images, start);
  if (outlines.masks() >= 2) {
    result.evidence = Evidence::kOutlines;
    result.images = outlines.masks();
    steps = kLosses_px.size();
    const auto off = [&](const Similarity& place) {
      std::vector<double> distances = outlines.distances(place);
      for (double& d : distances) d = std::abs(d);
      if (distances.empty()) throw Error("no image shows the mesh's outline: check that its pose is roughly right");
      return median(distances);
    };
    result.before = off(start);
    options.common_error = kCommonError_px;
    judge_by_halves(fit_outlines(outlines, start, options, step_done), options, result);
    result.after = off(result.placement.stage_from_mesh);
    return result;
  }

  TextureEvidence texture(mesh, scene, images);
  const int levels = texture.coarsest(start) + 1;
  steps = static_cast<std::size_t>(1 + levels * (levels - 1) / 2);
  result.images = images.size();
  texture.see(start, 0, kMargin_px);
  const TextureEvidence::Agreement before = texture.agreement(start);
  if (before.points == 0)
    throw Error("no two images see the same part of the mesh: check that its pose is roughly right");
  result.before = before.correlation;
  options.common_move_m = kCommonError_px * pixel_m;
  judge_by_halves(TextureFit(texture, options, pixel_m).best(start, step_done), options, result);
  texture.see(result.placement.stage_from_mesh, 0, kMargin_px);
  result.after = texture.agreement(result.placement.stage_from_mesh).correlation;
  return result;
}

}  // namespace sheen
