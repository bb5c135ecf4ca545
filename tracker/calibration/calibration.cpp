// SPDX-License-Identifier: Apache-2.0
#include "tracker/calibration/calibration.h"

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>
#include <optional>

#include "common/base/errors.h"
#include "common/base/format.h"
#include "common/base/order_statistics.h"
#include "tracker/pose/pose_solver.h"

namespace sheen {
namespace {

constexpr int kFewestViews = 3;    ///< two homographies leave the focal length open where they are alike
constexpr int kFewestCorners = 6;  ///< of a view: a pose has six unknowns, four corners leave too little to judge it
constexpr double kStartHuberPx =
    10;  ///< while only the focal length is known, corners are off by the lens's distortion
constexpr double kRobustHuberPx = 1;
constexpr double kMedianToSigma = 1.17741;  ///< median length of a 2-D Gaussian error, in standard deviations
constexpr int kMostRounds = 10;
/// Focal lengths to begin with, in widths of the image: 103 to 6 degrees.
constexpr double kStartFocal[] = {0.4, 0.6, 0.85, 1.2, 1.7, 2.5, 4, 6.5, 10};
/// Least eigenvalue-like pivot of the scaled normal equations that still counts as determined.
constexpr double kLeastPivot = 1e-11;

std::vector<Correspondence> correspondences(std::span<const Eigen::Vector3d> target,
                                            std::span<const TargetSighting> sightings) {
  std::vector<Correspondence> points;
  for (const TargetSighting& s : sightings) points.push_back({target[s.point], s.pixel});
  return points;
}

std::optional<Rigid3> pose_of(const Camera& camera, std::span<const Eigen::Vector3d> target, const TargetView& view,
                              double huber_px) {
  const auto pose = solve_pose_of_points(camera, correspondences(target, view.sightings), huber_px);
  if (!pose) return std::nullopt;
  return pose->camera_from_object;
}

Camera plain_camera(ImageSize size, const LensFit& fit, double focal) {
  return {.width = size.width,
          .height = size.height,
          .fx = focal,
          .fy = focal,
          .cx = (size.width - 1) / 2.0,
          .cy = (size.height - 1) / 2.0,
          .lens = fit.lens};
}

/// The focal length under which the views fit best, the lens taken to be without distortion.
Camera start_camera(std::span<const Eigen::Vector3d> target, std::span<const TargetView> views, ImageSize size,
                    const LensFit& fit) {
  constexpr std::size_t kEnough = 12;  // views
  constexpr double kNoPose = 1e9;
  const std::size_t step = std::max<std::size_t>(1, views.size() / kEnough);
  Camera best;
  double least = INFINITY;
  for (const double focal : kStartFocal) {
    const Camera camera = plain_camera(size, fit, focal * size.width);
    double cost = 0;
    for (std::size_t i = 0; i < views.size(); i += step) {
      const auto pose = solve_pose_of_points(camera, correspondences(target, views[i].sightings), kStartHuberPx);
      cost += pose ? pose->cost : kNoPose;
    }
    if (cost < least) {
      least = cost;
      best = camera;
    }
  }
  return best;
}

/// What the model does not estimate is as it is in a model without it: square pixels, no distortion.
Camera without_fixed(const Camera& camera, const LensFit& fit) {
  Intrinsics values = intrinsics_of(camera);
  for (int i = 0; i < kIntrinsics; ++i)
    if (!fit.free[i]) values[i] = i == 1 ? 1 : 0;
  return with_intrinsics(camera, values);
}

/// The views whose pose is known, as a bundle over the target's points.
Bundle make_bundle(std::span<const Eigen::Vector3d> target, std::span<const TargetView> views,
                   std::span<const Rigid3> poses, const Camera& camera, const LensFit& fit) {
  Bundle bundle{.camera = camera,
                .camera_from_object = {poses.begin(), poses.end()},
                .points = {target.begin(), target.end()},
                .free = {.intrinsics = fit.free}};
  for (std::size_t view = 0; view < views.size(); ++view)
    for (const TargetSighting& s : views[view].sightings)
      bundle.sightings.push_back({static_cast<int>(view), s.point, s.pixel});
  return bundle;
}

/// First the focal length alone, so that distortion does not run away to explain what is the focal length's.
void solve_from_start(Bundle& bundle) {
  const BundleFreedom all = bundle.free;
  bundle.free.intrinsics = {true};
  solve(bundle, kStartHuberPx);
  bundle.free = all;
  solve(bundle, kRobustHuberPx);
}

/// noise^2 times the camera's part of the inverse of the normal equations. Throws Error where they have none.
Eigen::Matrix<double, kIntrinsics, kIntrinsics> covariance_of(const Bundle& bundle, double noise) {
  const Eigen::MatrixXd full = information(bundle);
  const Eigen::VectorXd scale = full.diagonal().cwiseSqrt().cwiseInverse();
  const Eigen::LDLT<Eigen::MatrixXd> solver(scale.asDiagonal() * full * scale.asDiagonal());
  if (!scale.allFinite() || !(solver.vectorD().minCoeff() > kLeastPivot))
    throw Error("the views do not determine the camera: tilt the target by 20 to 45 degrees, another way in each view");
  const int count = bundle.free.intrinsics_count();
  Eigen::MatrixXd right = Eigen::MatrixXd::Zero(full.rows(), count);
  right.topRows(count).setIdentity();
  const Eigen::MatrixXd inverse = solver.solve(scale.asDiagonal() * right).topRows(count);
  Eigen::Matrix<double, kIntrinsics, kIntrinsics> covariance;
  covariance.setZero();
  std::vector<int> places;
  for (int i = 0; i < kIntrinsics; ++i)
    if (bundle.free.intrinsics[i]) places.push_back(i);
  for (int i = 0; i < count; ++i)
    for (int j = 0; j < count; ++j)
      covariance(places[i], places[j]) = noise * noise * (inverse(i, j) * scale[i] + inverse(j, i) * scale[j]) / 2;
  return covariance;
}

double rms(std::span<const double> lengths) {
  double sum = 0;
  for (const double length : lengths) sum += length * length;
  return lengths.empty() ? 0 : std::sqrt(sum / static_cast<double>(lengths.size()));
}

std::vector<double> errors_of(const Camera& camera, const Rigid3& pose, std::span<const Eigen::Vector3d> target,
                              const TargetView& view) {
  std::vector<double> lengths;
  const Intrinsics intrinsics = intrinsics_of(camera);
  for (const TargetSighting& s : view.sightings) {
    const Eigen::Vector3d point = pose * target[s.point];
    Eigen::Vector2d pixel;
    const bool seen = project_point(camera.lens, intrinsics.data(), point.data(), pixel.data());
    lengths.push_back(seen ? (s.pixel - pixel).norm() : INFINITY);
  }
  return lengths;
}

/// A view on its way to being used or not.
struct Candidate {
  const TargetView* view;
  std::optional<Rigid3> pose;
  std::vector<bool> good;  ///< of each sighting
  std::string reason;      ///< why it is not used; empty: it is
};

TargetView good_part(const Candidate& candidate) {
  TargetView part{candidate.view->name, {}};
  for (std::size_t i = 0; i < candidate.good.size(); ++i)
    if (candidate.good[i]) part.sightings.push_back(candidate.view->sightings[i]);
  return part;
}

Bundle bundle_of_used(std::span<const Eigen::Vector3d> target, std::span<const Candidate> candidates,
                      const Camera& camera, const LensFit& fit) {
  std::vector<TargetView> used;
  std::vector<Rigid3> poses;
  for (const Candidate& candidate : candidates)
    if (candidate.reason.empty()) {
      used.push_back(good_part(candidate));
      poses.push_back(*candidate.pose);
    }
  if (used.size() < kFewestViews)
    throw Error("only " + std::to_string(used.size()) + " images show the target well enough; a calibration needs " +
                std::to_string(kFewestViews) + " at the very least, 15 or more to be good");
  return make_bundle(target, used, poses, camera, fit);
}

void take_poses(std::vector<Candidate>& candidates, const Bundle& bundle) {
  std::size_t next = 0;
  for (Candidate& candidate : candidates)
    if (candidate.reason.empty()) candidate.pose = bundle.camera_from_object[next++];
}

/// Judges every corner and every view again under the camera; poses of views that are not used are solved for it.
/// Whether anything changed.
bool judge(std::vector<Candidate>& candidates, const Camera& camera, std::span<const Eigen::Vector3d> target,
           const CalibrationOptions& options) {
  std::vector<double> used_errors;
  std::vector<std::vector<double>> errors;
  for (Candidate& candidate : candidates) {
    if (!candidate.reason.empty())
      if (const auto pose = pose_of(camera, target, *candidate.view, kRobustHuberPx)) candidate.pose = pose;
    errors.emplace_back();
    if (candidate.pose) errors.back() = errors_of(camera, *candidate.pose, target, *candidate.view);
    if (!candidate.reason.empty()) continue;
    for (std::size_t i = 0; i < errors.back().size(); ++i)
      if (candidate.good[i]) used_errors.push_back(errors.back()[i]);
  }
  const double sigma = median(used_errors) / kMedianToSigma;
  const double limit = std::max(options.outlier_sigmas * sigma, options.outlier_floor_px);
  bool changed = false;
  for (std::size_t c = 0; c < candidates.size(); ++c) {
    Candidate& candidate = candidates[c];
    if (!candidate.pose || candidate.view->sightings.size() < kFewestCorners) continue;
    std::vector<bool> good;
    for (const double error : errors[c]) good.push_back(error <= limit);
    const auto kept = static_cast<std::size_t>(std::count(good.begin(), good.end(), true));
    std::string reason;
    if (kept < kFewestCorners || static_cast<double>(kept) < options.fewest_kept * static_cast<double>(good.size())) {
      reason = format("%zu of %zu corners are off by more than %.2f px", good.size() - kept, good.size(), limit);
      good.assign(good.size(), true);
    }
    changed = changed || reason.empty() != candidate.reason.empty() || good != candidate.good;
    candidate.reason = reason;
    candidate.good = good;
  }
  return changed;
}

std::vector<Candidate> find_candidates(std::span<const Eigen::Vector3d> target, std::span<const TargetView> views,
                                       const Camera& camera) {
  std::vector<Candidate> candidates;
  for (const TargetView& view : views) {
    Candidate candidate{&view, std::nullopt, std::vector<bool>(view.sightings.size(), true), ""};
    if (view.sightings.empty())
      candidate.reason = "the target was not found";
    else if (view.sightings.size() < kFewestCorners)
      candidate.reason = "only " + std::to_string(view.sightings.size()) + " corners were found";
    else if (!(candidate.pose = pose_of(camera, target, view, kStartHuberPx)))
      candidate.reason = "the corners found do not determine where the target stands";
    candidates.push_back(std::move(candidate));
  }
  return candidates;
}

/// Camera, noise and covariance of a bundle that is solved.
Calibration finish(const Bundle& bundle, const LensFit& fit) {
  Calibration result{.fit = &fit, .camera = bundle.camera};
  double sum = 0;
  for (const Eigen::Vector2d& r : residuals(bundle)) sum += r.squaredNorm();
  const double count = static_cast<double>(bundle.sightings.size());
  const double unknowns = fit.parameters() + 6.0 * static_cast<double>(bundle.camera_from_object.size());
  if (2 * count <= unknowns) throw Error("there are fewer corners than unknowns; take more images of the target");
  result.rms_px = std::sqrt(sum / count);
  result.noise_px = std::sqrt(sum / (2 * count - unknowns));
  result.covariance = covariance_of(bundle, result.noise_px);
  if (const std::string wrong = validation_error(result.camera); !wrong.empty())
    throw Error("the views do not determine the camera (" + wrong + ")");
  return result;
}

void report_views(Calibration& result, std::span<const Candidate> candidates, std::span<const Eigen::Vector3d> target) {
  std::vector<double> all;
  for (const Candidate& candidate : candidates) {
    CalibratedView view{.name = candidate.view->name, .used = candidate.reason.empty(), .reason = candidate.reason};
    view.corners = static_cast<int>(candidate.view->sightings.size());
    if (candidate.pose) {
      view.camera_from_target = *candidate.pose;
      const auto errors = errors_of(result.camera, *candidate.pose, target, *candidate.view);
      std::vector<double> good;
      for (std::size_t i = 0; i < errors.size(); ++i)
        if (candidate.good[i])
          good.push_back(errors[i]);
        else
          view.rejected.push_back({candidate.view->sightings[i].point, errors[i]});
      view.rms_px = rms(good);
      view.rms_all_px = rms(errors);
      all.insert(all.end(), errors.begin(), errors.end());
    }
    if (view.used) result.used.push_back(good_part(candidate));
    result.views.push_back(std::move(view));
  }
  result.rms_all_px = rms(all);
}

}  // namespace

int Calibration::corners_used() const {
  int count = 0;
  for (const TargetView& view : used) count += static_cast<int>(view.sightings.size());
  return count;
}

Calibration calibrate(std::span<const Eigen::Vector3d> target, std::span<const TargetView> views, ImageSize size,
                      const LensFit& fit, const CalibrationOptions& options) {
  std::vector<TargetView> found;
  for (const TargetView& view : views)
    if (view.sightings.size() >= kFewestCorners) found.push_back(view);
  if (found.empty())
    throw Error("the target was found in none of the " + std::to_string(views.size()) +
                " images; is it the one that --target names, sharp and wholly in the picture?");
  const Camera start = start_camera(target, found, size, fit);
  std::vector<Candidate> candidates = find_candidates(target, views, start);
  Bundle bundle = bundle_of_used(target, candidates, start, fit);
  solve_from_start(bundle);
  take_poses(candidates, bundle);
  for (int round = 0; round < kMostRounds && judge(candidates, bundle.camera, target, options); ++round) {
    bundle = bundle_of_used(target, candidates, bundle.camera, fit);
    solve(bundle);
    take_poses(candidates, bundle);
  }
  solve(bundle);  // least squares, also where nothing was judged wrong
  take_poses(candidates, bundle);
  Calibration result = finish(bundle, fit);
  report_views(result, candidates, target);
  return result;
}

Calibration recalibrate(std::span<const Eigen::Vector3d> target, std::span<const TargetView> good, const Camera& start,
                        const LensFit& fit) {
  const Camera camera =
      fit.lens == start.lens ? without_fixed(start, fit) : start_camera(target, good, {start.width, start.height}, fit);
  std::vector<Candidate> candidates = find_candidates(target, good, camera);
  Bundle bundle = bundle_of_used(target, candidates, camera, fit);
  solve_from_start(bundle);
  solve(bundle);
  take_poses(candidates, bundle);
  Calibration result = finish(bundle, fit);
  report_views(result, candidates, target);
  return result;
}

}  // namespace sheen
