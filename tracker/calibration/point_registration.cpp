// SPDX-License-Identifier: Apache-2.0
#include "tracker/calibration/point_registration.h"

#include <Eigen/Cholesky>
#include <Eigen/Geometry>
#include <Eigen/LU>
#include <Eigen/SVD>
#include <algorithm>
#include <array>
#include <cmath>
#include <numeric>

#include "common/base/errors.h"
#include "common/base/format.h"
#include "common/base/order_statistics.h"
#include "tracker/calibration/point_fit.h"

namespace sheen {
namespace {

constexpr double kStagePrior_m = 0.5e-3, kPixelPrior_px = 1;  // where neither file nor residuals say more
constexpr double kOutlierSigmas = 6;
constexpr int kEnoughFreedom = 6;  // degrees of freedom from which the residuals alone say the noise
constexpr double kPrior = 2;       // below it, degrees of freedom that the expectation counts for
constexpr double kLine = 0.03;     // width of the points, of their length: less is a line
constexpr double kSameUnit = 0.1;  // relative: sizes that differ by more are of another unit or object
constexpr double kWorthSaying = 0.005;
constexpr double kMirrored = 0.25;              // residual of the mirror image, of the residual itself
constexpr double kSpreadOfTriangulation = 0.2;  // standard deviation of a place, of its distance: more is no place
constexpr double kOffSurface = 0.03;            // of the mesh's radius

const PosedCamera& view_named(const std::map<std::string, PosedCamera>& views, const std::string& name,
                              const std::string& point) {
  if (const auto exact = views.find(name); exact != views.end()) return exact->second;
  const PosedCamera* found = nullptr;
  for (const auto& [whole, view] : views) {
    if (std::filesystem::path(whole).filename() != name) continue;
    if (found) throw ConfigError("point \"" + point + "\": several images are called \"" + name + "\"; give the path");
    found = &view;
  }
  if (!found) throw ConfigError("point \"" + point + "\": there is no image \"" + name + "\" with a pose");
  return *found;
}

/// Where the rays of the pixels meet: the middle between them, then the least squares of the pixels.
PointPair intersect(const PickedPoint& point, const std::map<std::string, PosedCamera>& views, double sigma_px) {
  std::vector<const PosedCamera*> cameras;
  Eigen::Matrix3d across = Eigen::Matrix3d::Zero();
  Eigen::Vector3d right = Eigen::Vector3d::Zero();
  for (const PickedPixel& picked : point.pixels) {
    cameras.push_back(&view_named(views, picked.image, point.name));
    const PosedCamera& view = *cameras.back();
    const auto ray = view.camera.ray(picked.pixel);
    if (!ray || !view.camera.contains(picked.pixel))
      throw ConfigError("point \"" + point.name + "\": its pixel lies outside of the image \"" + picked.image + "\"");
    const Eigen::Vector3d direction = view.camera_from_object.rotation.conjugate() * *ray;
    const Eigen::Matrix3d projector = Eigen::Matrix3d::Identity() - direction * direction.transpose();
    across += projector;
    right += projector * camera_centre(view.camera_from_object);
  }
  PointPair pair{.mesh = point.mesh, .stage = across.ldlt().solve(right)};
  Eigen::Matrix3d information;
  for (int round = 0; round < 10; ++round) {
    information.setZero();
    Eigen::Vector3d gradient = Eigen::Vector3d::Zero();
    for (std::size_t i = 0; i < cameras.size(); ++i) {
      Eigen::Vector2d pixel;
      Eigen::Matrix<double, 2, 3> by_point;
      if (!project_with_derivative(*cameras[i], pair.stage, pixel, by_point))
        throw ConfigError("point \"" + point.name + "\": its pixels do not meet in front of the cameras");
      information += by_point.transpose() * by_point / (sigma_px * sigma_px);
      gradient += by_point.transpose() * (point.pixels[i].pixel - pixel) / (sigma_px * sigma_px);
    }
    pair.stage += information.ldlt().solve(gradient);
  }
  pair.covariance = information.inverse();
  const double distance = (camera_centre(cameras[0]->camera_from_object) - pair.stage).norm();
  if (!(pair.covariance.trace() < std::pow(kSpreadOfTriangulation * distance, 2)))
    throw ConfigError("point \"" + point.name +
                      "\": its images look from nearly the same place; add an image from another side");
  return pair;
}

/// Refuses points that lie on one line.
void check_spread(std::span<const PointPair> pairs, bool of_mesh) {
  Eigen::Matrix3Xd points(3, pairs.size());
  for (std::size_t i = 0; i < pairs.size(); ++i) points.col(i) = of_mesh ? pairs[i].mesh : pairs[i].stage;
  points.colwise() -= points.rowwise().mean().eval();
  const Eigen::Vector3d spread = Eigen::JacobiSVD<Eigen::Matrix3Xd>(points).singularValues();
  const std::string where = of_mesh ? "on the mesh" : "on the stage";
  if (!(spread[0] > 0)) throw ConfigError("all points lie at one place " + where + "; pick points far from each other");
  if (spread[1] < kLine * spread[0])
    throw ConfigError("the points lie nearly on one line " + where +
                      ", which leaves the rotation about it open; add a point well beside the line");
}

/// Median ratio of distances on the stage to those on the mesh: no placement is needed for it.
double size_ratio(std::span<const PointPair> pairs) {
  std::vector<double> ratios;
  for (std::size_t i = 0; i < pairs.size(); ++i)
    for (std::size_t j = i + 1; j < pairs.size(); ++j)
      if (const double on_mesh = (pairs[i].mesh - pairs[j].mesh).norm(); on_mesh > 0)
        ratios.push_back((pairs[i].stage - pairs[j].stage).norm() / on_mesh);
  return median(ratios);
}

void check_unit(double ratio, const PointOptions& options) {
  struct Unit {
    double metres;
    const char* name;
    const char* option;
  };
  constexpr std::array kUnits{Unit{1e-3, "millimetres", "mm"}, Unit{1e-2, "centimetres", "cm"},
                              Unit{0.0254, "inches", "inch"}, Unit{1, "metres", "m"}};
  if (std::abs(std::log(ratio / options.scale)) < kSameUnit) return;
  for (const Unit& unit : kUnits)
    if (std::abs(std::log(ratio / unit.metres)) < kSameUnit)
      throw ConfigError(std::string("the mesh's points are in ") + unit.name + ": give --unit " + unit.option);
  if (options.free_scale) return;
  throw ConfigError(
      format("the points are %.4g times as far apart on the stage as on the mesh: they are of another unit, "
             "or not the same points; where the mesh's size is not known, give --free-scale",
             ratio / options.scale));
}

double rms(std::span<const PointPair> pairs, const Similarity& fit) {
  double squares = 0;
  for (const PointPair& pair : pairs) squares += (pair.stage - fit * pair.mesh).squaredNorm();
  return std::sqrt(squares / static_cast<double>(pairs.size()));
}

/// Refuses points whose mirror image fits, and which do not fit themselves.
void check_not_mirrored(std::span<const PointPair> pairs, const ScaleRule& rule) {
  std::vector<int> all(pairs.size());
  std::iota(all.begin(), all.end(), 0);
  std::vector<PointPair> mirrored(pairs.begin(), pairs.end());
  for (PointPair& pair : mirrored) pair.mesh = -pair.mesh;
  const double as_given = rms(pairs, fit_points(pairs, all, rule).stage_from_mesh);
  const double in_mirror = rms(mirrored, fit_points(mirrored, all, rule).stage_from_mesh);
  if (as_given > 3 * kStagePrior_m && in_mirror < kMirrored * as_given)
    throw ConfigError(
        format("the points are mirrored: they fit a mirror image of the mesh to %.2g mm, and the mesh to "
               "%.3g mm; one axis of the mesh or of the stage's coordinates has the wrong sign",
               1e3 * in_mirror, 1e3 * as_given));
}

double distance_from(const Mesh& mesh, const Eigen::Vector3d& point) {
  double nearest = HUGE_VAL;
  for (std::size_t t = 0; t < mesh.triangles.size(); ++t) {
    const Eigen::Vector3d a = mesh.corner(t, 0).cast<double>(), b = mesh.corner(t, 1).cast<double>(),
                          c = mesh.corner(t, 2).cast<double>(), normal = (b - a).cross(c - a).normalized();
    const double height = (point - a).dot(normal);
    if (std::abs(height) >= nearest) continue;
    const std::array<Eigen::Vector3d, 3> corners{a, b, c};
    bool above = true;
    for (int i = 0; i < 3; ++i) {
      const Eigen::Vector3d from = corners[i], along = corners[(i + 1) % 3] - from;
      above &= normal.dot(along.cross(point - from)) >= 0;
      const double part = std::clamp((point - from).dot(along) / along.squaredNorm(), 0.0, 1.0);
      nearest = std::min(nearest, (point - from - part * along).norm());
    }
    if (above) nearest = std::min(nearest, std::abs(height));
  }
  return nearest;
}

void check_surface(const Mesh& mesh, PointRegistration& result) {
  const double radius = bounding_sphere(mesh).radius;
  std::vector<double> distances;
  for (const RegisteredPoint& point : result.points) distances.push_back(point.from_surface);
  if (median(distances) > radius / 2)
    throw ConfigError(
        "the file's mesh points are not on the mesh: they are of another unit or another frame than the "
        "mesh file");
  for (const RegisteredPoint& point : result.points)
    if (point.from_surface > kOffSurface * radius)
      result.warnings.push_back(
          "point \"" + point.name +
          format("\" lies %.1f %% of the mesh's radius off its surface: was it picked on this mesh?",
                 100 * point.from_surface / radius));
}

double rms_px(const PickedPoint& point, const std::map<std::string, PosedCamera>& views,
              const Eigen::Vector3d& stage_point) {
  if (point.pixels.empty()) return 0;
  double squares = 0;
  for (const PickedPixel& picked : point.pixels) {
    const PosedCamera& view = view_named(views, picked.image, point.name);
    const auto pixel = view.camera.project(view.camera_from_object * stage_point);
    squares += pixel ? (*pixel - picked.pixel).squaredNorm() : HUGE_VAL;
  }
  return std::sqrt(squares / static_cast<double>(point.pixels.size()));
}

}  // namespace

PointRegistration register_points(const Correspondences& picked, const Mesh& mesh,
                                  const std::map<std::string, PosedCamera>& views, const PointOptions& options) {
  const auto count = static_cast<int>(picked.points.size());
  if (count < 3)
    throw ConfigError("there are " + std::to_string(count) +
                      " points; three or more are needed, six tell their errors");
  PointRegistration result;
  std::vector<PointPair> pairs;
  bool known = true;
  for (const PickedPoint& point : picked.points) {
    const auto& sigma = point.stage ? picked.stage_uncertainty_m : picked.pixel_uncertainty_px;
    known &= sigma.has_value();
    const double deviation = sigma.value_or(point.stage ? kStagePrior_m : kPixelPrior_px);
    pairs.push_back(point.stage
                        ? PointPair{point.mesh, *point.stage, deviation * deviation * Eigen::Matrix3d::Identity()}
                        : intersect(point, views, deviation));
  }
  for (const bool of_mesh : {true, false}) check_spread(pairs, of_mesh);
  const double ratio = size_ratio(pairs);
  check_unit(ratio, options);
  const ScaleRule rule{options.free_scale, options.scale};
  check_not_mirrored(pairs, rule);

  const std::vector<int> used = consensus(pairs, rule, known, kOutlierSigmas);
  const PointFit fit = fit_points(pairs, used, rule);
  const double prior = fit.degrees_of_freedom < kEnoughFreedom ? kPrior : 0;
  const double factor = known ? 1 : variance_factor(fit, prior);
  result.placement = {fit.stage_from_mesh, fit.centre, factor * fit.covariance};
  result.degrees_of_freedom = fit.degrees_of_freedom;
  result.noise_estimated = !known;
  double squares = 0, variances = 0;
  for (int i = 0; i < count; ++i) {
    RegisteredPoint point{.name = picked.points[i].name, .stage = pairs[i].stage};
    point.used = std::find(used.begin(), used.end(), i) != used.end();
    const Eigen::Vector3d at = fit.stage_from_mesh * pairs[i].mesh;
    point.residual = point.stage - at;
    point.residual_px = rms_px(picked.points[i], views, at);
    point.from_surface = distance_from(mesh, pairs[i].mesh);
    std::vector<int> others = used;
    std::erase(others, i);
    if (others.size() >= 3) {
      const PointFit without = fit_points(pairs, others, rule);
      point.sigmas = sigmas_off(pairs[i], without, known ? 1 : variance_factor(without, 2 * kPrior));
    }
    if (point.used) {
      squares += point.residual.squaredNorm();
      variances += factor * pairs[i].covariance.trace() / 3;
    }
    result.points.push_back(point);
  }
  result.rms_m = std::sqrt(squares / static_cast<double>(used.size()));
  result.noise_m = std::sqrt(variances / static_cast<double>(used.size()));

  check_surface(mesh, result);
  for (const RegisteredPoint& point : result.points)
    if (!point.used)
      result.warnings.push_back("point \"" + point.name +
                                format("\" is an outlier, left out: it is %.3g mm from where the others have it "
                                       "(%.0f standard deviations); pick it again",
                                       1e3 * point.residual.norm(), point.sigmas));
  if (!options.free_scale && std::abs(ratio / options.scale - 1) > kWorthSaying) {
    const PointFit freely = fit_points(pairs, used, {.free = true});
    const double off = freely.stage_from_mesh.scale / options.scale - 1;
    const double sigma = std::sqrt((known ? 1 : variance_factor(freely, kPrior)) * freely.covariance(6, 6));
    if (std::abs(off) > kWorthSaying && std::abs(off) > 4 * sigma)
      result.warnings.push_back(format("the mesh is %.2f %% too ", 100 * std::abs(off)) +
                                (off > 0 ? "small" : "large") + " for these points: measure it, or give --free-scale");
  }
  if (known && result.degrees_of_freedom > 0 &&
      fit.squares > result.degrees_of_freedom + 5 * std::sqrt(2.0 * result.degrees_of_freedom))
    result.warnings.push_back(format("the residuals are %.1f times what the file's uncertainty expects",
                                     std::sqrt(fit.squares / result.degrees_of_freedom)));
  return result;
}

}  // namespace sheen
