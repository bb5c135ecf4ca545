// SPDX-License-Identifier: Apache-2.0
#include "tracker/fiducials/corner_refiner.h"

#include <Eigen/Geometry>
#include <Eigen/LU>
#include <algorithm>
#include <array>
#include <cmath>
#include <optional>

#include "common/base/order_statistics.h"
#include "common/stage/tag_pattern.h"
#include "tracker/fiducials/grey_sample.h"

namespace sheen {
namespace {

using Eigen::Vector2d;
using Quad = std::array<Vector2d, 4>;

constexpr double kStep = 0.5;                      ///< px between the samples across an edge
constexpr int kMaxSamples = 33;                    ///< of a profile: a reach of 8 px
constexpr int kMinEdgePoints = 6;                  ///< a line rests on so many points or more
constexpr int kLevelWindow = 4;                    ///< points to either side that share their levels of paper and ink
constexpr int kReweightings = 5;                   ///< of the line fit
constexpr double kTukeyMadRatio = 4.685 * 1.4826;  ///< 95 % efficient on Gaussian noise
constexpr double kMinScalePx = 0.02;
constexpr double kSharpReach_px = 2;     ///< holds the slope of a sharp edge
constexpr double kReachPerStreak = 0.3;  ///< more for a blurred one; noise grows with the reach, too
constexpr double kSharpVariance = 1.0;   ///< px^2; pixel, interpolation, a lens's blur and the noise of the tails

/// The picture a pinhole with the camera's focal length would have taken: pixels, not normalised coordinates.
struct Pinhole {
  const Camera& camera;

  std::optional<Vector2d> undistort(const Vector2d& pixel) const {
    const auto ray = camera.ray(pixel);
    if (!ray || ray->z() < 0.05) return std::nullopt;
    return Vector2d(camera.fx * ray->x() / ray->z() + camera.cx, camera.fy * ray->y() / ray->z() + camera.cy);
  }
  std::optional<Vector2d> distort(const Vector2d& p) const {
    return camera.project({(p.x() - camera.cx) / camera.fx, (p.y() - camera.cy) / camera.fy, 1});
  }
};

struct Line {  ///< points with normal . p = offset
  Vector2d normal;
  double offset;
};

/// Grey levels from inside to outside; stands within its point, since an image has some ten thousand of them.
using Profile = Eigen::Matrix<double, Eigen::Dynamic, 1, 0, kMaxSamples, 1>;

struct EdgePoint {
  double along = 0;   ///< of the edge, px from its first corner
  double across = 0;  ///< outwards from the assumed edge, px
  double ink = 0, paper = 0;
  Profile profile;
};

double cross(const Vector2d& a, const Vector2d& b) {
  return a.x() * b.y() - a.y() * b.x();
}

/// Profiles across the edge from `a` to `b`, sampled through the lens; over a few pixels the lens is affine.
std::vector<EdgePoint> sample_edge(const ImageU8& grey, const Pinhole& pinhole, const Vector2d& a, const Vector2d& b,
                                   const Vector2d& outward, int half_samples, double skipped_ends) {
  const double length = (b - a).norm();
  const Vector2d direction = (b - a) / length;
  const double skip = std::max(skipped_ends * length, 2.0);
  std::vector<EdgePoint> points;
  if (length < grey.width() + grey.height()) points.reserve(static_cast<std::size_t>(length) + 1);
  for (double s = skip; s <= length - skip; s += 1) {
    const Vector2d at = a + s * direction;
    const auto centre = pinhole.distort(at), next = pinhole.distort(at + outward);
    if (!centre || !next) continue;
    const Vector2d step = kStep * (*next - *centre);
    if (!inside(grey, *centre - half_samples * step) || !inside(grey, *centre + half_samples * step)) continue;
    EdgePoint& point = points.emplace_back();
    point.along = s;
    point.profile.resize(2 * half_samples + 1);
    for (int i = -half_samples; i <= half_samples; ++i)
      point.profile[i + half_samples] = bilinear(grey, *centre + i * step);
  }
  return points;
}

/// Levels at both ends of the profiles, shared by neighbours: a shadow may lie across the edge, noise must not decide.
void estimate_levels(std::vector<EdgePoint>& points, int end_samples) {
  const int n = static_cast<int>(points.size());
  for (int i = 0; i < n; ++i) {
    double ink = 0, paper = 0;
    int count = 0;
    for (int k = std::max(0, i - kLevelWindow); k <= std::min(n - 1, i + kLevelWindow); ++k)
      for (int j = 0; j < end_samples; ++j, ++count) {
        ink += points[k].profile[j];
        paper += points[k].profile[points[k].profile.size() - 1 - j];
      }
    points[i].ink = ink / count;
    points[i].paper = paper / count;
  }
}

/// Position of a step between two levels: the area between paper and the profile is (paper - ink) times the distance
/// from the profile's inner end to the step, whatever symmetric blur lies over it (trapezoid rule).
double step_position(const EdgePoint& point) {
  const Profile& profile = point.profile;
  const Eigen::Index n = profile.size();
  const double ends = (2 * point.paper - profile[0] - profile[n - 1]) / 2;
  const double area = ((point.paper - profile.array()).sum() - ends) * kStep;
  return area / (point.paper - point.ink) - (n - 1) * kStep / 2;
}

/// across = c0 + c1 * along by iteratively reweighted least squares with Tukey's weights.
std::optional<Vector2d> fit_line(const std::vector<EdgePoint>& points) {
  std::vector<double> residuals(points.size()), sorted;
  Vector2d line(0, 0);
  for (int round = 0; round < kReweightings; ++round) {
    double scale = 0;
    if (round > 0) {
      for (std::size_t i = 0; i < points.size(); ++i)
        residuals[i] = std::abs(points[i].across - line[0] - line[1] * points[i].along);
      sorted = residuals;
      scale = kTukeyMadRatio * std::max(median(sorted), kMinScalePx);
    }
    Eigen::Matrix2d normal = Eigen::Matrix2d::Zero();
    Vector2d right(0, 0);
    for (std::size_t i = 0; i < points.size(); ++i) {
      double weight = 1;
      if (round > 0) {
        const double u = residuals[i] / scale;
        weight = u < 1 ? (1 - u * u) * (1 - u * u) : 0;
      }
      const Vector2d row(1, points[i].along);
      normal += weight * row * row.transpose();
      right += weight * row * points[i].across;
    }
    if (!(normal.determinant() > 1e-6)) return std::nullopt;
    line = normal.inverse() * right;
  }
  return line;
}

Vector2d outward_normal(const Quad& quad, int edge) {
  const Vector2d &a = quad[edge], &b = quad[(edge + 1) % 4];
  const Vector2d direction = (b - a).normalized(), normal(direction.y(), -direction.x());
  return normal.dot(quad[(edge + 2) % 4] - a) > 0 ? Vector2d(-normal) : normal;
}

/// Variance (px^2) of the slope of an edge's mean profile: its width.
double slope_variance(const std::vector<EdgePoint>& points) {
  Profile mean = Profile::Zero(points.front().profile.size());
  for (const EdgePoint& p : points) mean.array() += (p.profile.array() - p.ink) / (p.paper - p.ink);
  double weight = 0, first = 0, second = 0;
  for (Eigen::Index j = 1; j < mean.size(); ++j) {
    const double slope = std::max(mean[j] - mean[j - 1], 0.0), t = j * kStep;
    weight += slope;
    first += slope * t;
    second += slope * t * t;
  }
  return weight > 0 ? second / weight - (first / weight) * (first / weight) : 0;
}

/// Length of the box streak that widens a sharp edge so far.
double streak_px(double variance) {
  return std::sqrt(12 * std::max(variance - kSharpVariance, 0.0));
}

/// Profiles across one edge, with their levels; empty where the edge cannot be measured.
std::vector<EdgePoint> edge_points(const ImageU8& grey, const Pinhole& pinhole, const Quad& quad, int edge,
                                   double reach_px, const RefinerOptions& options) {
  const Vector2d &a = quad[edge], &b = quad[(edge + 1) % 4];
  const Vector2d inward = (quad[(edge + 3) % 4] + quad[(edge + 2) % 4] - a - b) / 2;
  const Vector2d outward = outward_normal(quad, edge);
  const double cell = -outward.dot(inward) / kTagCells;
  const double reach = std::min(reach_px, options.reach_cells * cell);
  if (!(reach >= options.min_reach_px)) return {};
  const int half_samples = std::min(static_cast<int>(reach / kStep), kMaxSamples / 2);
  auto points = sample_edge(grey, pinhole, a, b, outward, half_samples, options.skipped_ends);
  if (points.size() < kMinEdgePoints) return {};
  estimate_levels(points, std::max(2, half_samples / 4));
  std::erase_if(points, [&](const EdgePoint& p) { return p.paper - p.ink < options.min_contrast; });
  if (points.size() < kMinEdgePoints) return {};
  return points;
}

/// `reach_px` is left as what this edge needs: profiles that reach no farther than its blur gather less noise.
std::optional<Line> measure_edge(const ImageU8& grey, const Pinhole& pinhole, const Quad& quad, int edge,
                                 double& reach_px, const RefinerOptions& options) {
  const Vector2d &a = quad[edge], &b = quad[(edge + 1) % 4];
  const Vector2d direction = (b - a).normalized(), outward = outward_normal(quad, edge);
  auto points = edge_points(grey, pinhole, quad, edge, reach_px, options);
  if (points.empty()) return std::nullopt;
  reach_px = std::min(options.reach_px, kSharpReach_px + kReachPerStreak * streak_px(slope_variance(points)));
  for (EdgePoint& point : points) point.across = step_position(point);

  const auto line = fit_line(points);
  if (!line) return std::nullopt;
  const Vector2d p = a + (*line)[0] * outward;  // the fitted line's foot at the first corner
  const Vector2d along = direction + (*line)[1] * outward;
  const Vector2d normal = Vector2d(along.y(), -along.x()).normalized();
  return Line{normal, normal.dot(p)};
}

std::optional<Vector2d> intersect(const Line& a, const Line& b) {
  const double sine = cross(a.normal, b.normal);
  if (std::abs(sine) < 0.1) return std::nullopt;
  return Vector2d(a.offset * b.normal.y() - b.offset * a.normal.y(),
                  b.offset * a.normal.x() - a.offset * b.normal.x()) /
         sine;
}

std::optional<Quad> refine_quad(const ImageU8& grey, const Pinhole& pinhole, const Quad& quad,
                                std::array<double, 4>& reach_px, const RefinerOptions& options) {
  std::array<Line, 4> lines;
  for (int edge = 0; edge < 4; ++edge) {
    const auto line = measure_edge(grey, pinhole, quad, edge, reach_px[edge], options);
    if (!line) return std::nullopt;
    lines[edge] = *line;
  }
  Quad refined;
  for (int corner = 0; corner < 4; ++corner) {
    const auto p = intersect(lines[(corner + 3) % 4], lines[corner]);
    if (!p || !((*p - quad[corner]).norm() <= options.max_correction_px)) return std::nullopt;
    refined[corner] = *p;
  }
  return refined;
}

bool refine_tag(const ImageU8& grey, const Pinhole& pinhole, TagObservation& tag, const RefinerOptions& options) {
  Quad quad;
  for (int corner = 0; corner < 4; ++corner) {
    const auto p = pinhole.undistort(tag.corners[corner]);
    if (!p) return false;
    quad[corner] = *p;
  }
  std::array<double, 4> reach_px;
  reach_px.fill(options.reach_px);
  for (int round = 0; round < options.rounds; ++round) {
    const auto refined = refine_quad(grey, pinhole, quad, reach_px, options);
    if (!refined) return false;
    quad = *refined;
  }
  for (int corner = 0; corner < 4; ++corner) {
    const auto p = pinhole.distort(quad[corner]);
    if (!p) return false;
    tag.corners[corner] = *p;
  }
  return true;
}

}  // namespace

double measured_streak_px(const ImageU8& grey, const Camera& camera, const std::vector<TagObservation>& tags,
                          const RefinerOptions& options) {
  const Pinhole pinhole{camera};
  std::vector<double> streaks;
  for (const TagObservation& tag : tags) {
    Quad quad;
    bool seen = true;
    for (int corner = 0; corner < 4; ++corner) {
      const auto p = pinhole.undistort(tag.corners[corner]);
      seen = seen && p;
      if (p) quad[corner] = *p;
    }
    double widest = 0;
    for (int edge = 0; seen && edge < 4; ++edge)
      if (const auto points = edge_points(grey, pinhole, quad, edge, options.reach_px, options); !points.empty())
        widest = std::max(widest, slope_variance(points));
    if (widest > 0) streaks.push_back(streak_px(widest));
  }
  return streaks.empty() ? 0 : median(streaks);
}

void refine_corners(const ImageU8& grey, const Camera& camera, std::vector<TagObservation>& tags,
                    const RefinerOptions& options) {
  const Pinhole pinhole{camera};
  std::erase_if(tags, [&](TagObservation& tag) { return !refine_tag(grey, pinhole, tag, options); });
}

}  // namespace sheen
