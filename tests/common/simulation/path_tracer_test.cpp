// SPDX-License-Identifier: Apache-2.0
#include "common/simulation/path_tracer.h"

#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <cmath>
#include <optional>

#include "common/base/errors.h"
#include "common/simulation/camera_path.h"

namespace sheen {
namespace {

using Eigen::Array3f;
using Eigen::Vector2d;
using Eigen::Vector3d;

constexpr BakeOptions kCoarse{
    .sky_directions = 256, .bounce_directions = 64, .bounces = 1, .area_light_samples = 4, .stage_cell_m = 0.01f};
constexpr double kBallRadius = 0.04;
const Vector3d kBall(0.01, -0.02, 0.045);

const PathTracer& ball_on_stage() {
  static const PathTracer tracer({make_sphere({.normal_reflectance = {0.1f, 0.1f, 0.1f}}, kBallRadius, kBall, 4),
                                  StageSurface(make_stage({})), make_studio()},
                                 kCoarse);
  return tracer;
}

Rigid3 pose_from(double azimuth_deg, double elevation_deg, double distance) {
  const double a = azimuth_deg * M_PI / 180, e = elevation_deg * M_PI / 180;
  const Vector3d target(0, 0, 0.03);
  return look_at(target + distance * Vector3d(std::cos(a) * std::cos(e), std::sin(a) * std::cos(e), std::sin(e)),
                 target, {0.1, 0.05, 1});
}

float grey(const ImageF& image, const Vector2d& p) {
  const int x = static_cast<int>(std::floor(p.x())), y = static_cast<int>(std::floor(p.y()));
  const float fx = float(p.x() - x), fy = float(p.y() - y);
  return (image.at(x, y, 1) * (1 - fx) + image.at(x + 1, y, 1) * fx) * (1 - fy) +
         (image.at(x, y + 1, 1) * (1 - fx) + image.at(x + 1, y + 1, 1) * fx) * fy;
}

struct Line {
  Vector2d point, direction;
};

/// The black-white edge near the segment a-b: on each of many normals the place that splits black from white by area,
/// then a line through those places.
Line find_edge(const ImageF& image, const Vector2d& a, const Vector2d& b) {
  constexpr double kReach = 3, kStep = 0.05;
  const Vector2d along = (b - a).normalized(), across(-along.y(), along.x());
  std::vector<Vector2d> crossings;
  for (double t = 0.2; t <= 0.8; t += 0.01) {
    const Vector2d middle = a + t * (b - a);
    const float first = grey(image, middle - kReach * across), last = grey(image, middle + kReach * across);
    double towards_last = 0;
    for (double s = -kReach + kStep / 2; s < kReach; s += kStep)
      towards_last += (grey(image, middle + s * across) - first) / (last - first) * kStep;
    crossings.push_back(middle + (kReach - towards_last) * across);
  }
  Vector2d mean = Vector2d::Zero();
  for (const Vector2d& p : crossings) mean += p / double(crossings.size());
  Eigen::Matrix2d scatter = Eigen::Matrix2d::Zero();
  for (const Vector2d& p : crossings) scatter += (p - mean) * (p - mean).transpose();
  const double angle = 0.5 * std::atan2(2 * scatter(0, 1), scatter(0, 0) - scatter(1, 1));
  return {mean, {std::cos(angle), std::sin(angle)}};
}

Vector2d meet(const Line& a, const Line& b) {
  Eigen::Matrix2d m;
  m << a.direction, -b.direction;
  const Vector2d offset = b.point - a.point;
  const double det = m(0, 0) * m(1, 1) - m(0, 1) * m(1, 0);
  return a.point + (offset.x() * m(1, 1) - m(0, 1) * offset.y()) / det * a.direction;
}

TEST(PathTracer, TagCornersStandWhereThePoseSaysToAFiftiethOfAPixel) {
  // No lens distortion here: over a tag it bends edges that the test takes for straight.
  Camera camera = simulated_camera(800, 600);
  camera.distortion.fill(0);
  const Rigid3 pose = pose_from(-70, 55, 0.55);
  const RenderedView view = ball_on_stage().render(LensRays(camera), pose);
  int corners = 0;
  double squared = 0;
  for (const StageTag& tag : make_stage({}).tags) {
    std::array<Vector2d, 4> truth;
    bool inside = true;
    for (int c = 0; c < 4; ++c) {
      const auto p = camera.project(pose * tag.corners_object[c]);
      inside = inside && p && camera.contains(*p, 8);
      if (p) truth[c] = *p;
    }
    if (!inside) continue;
    for (int c = 0; c < 4; ++c) {
      const Vector2d found = meet(find_edge(view.radiance, truth[(c + 3) % 4], truth[c]),
                                  find_edge(view.radiance, truth[c], truth[(c + 1) % 4]));
      EXPECT_LT((found - truth[c]).norm(), 0.06) << "tag " << tag.id << " corner " << c;
      squared += (found - truth[c]).squaredNorm();
      ++corners;
    }
  }
  ASSERT_GE(corners, 40);
  EXPECT_LT(std::sqrt(squared / corners), 0.02);
}

TEST(PathTracer, TheMaskIsTheBallsSilhouetteThroughTheLens) {
  const Camera camera = simulated_camera(320, 240);
  const Rigid3 pose = pose_from(30, 35, 0.45);
  const RenderedView view = ball_on_stage().render(LensRays(camera), pose);
  const Vector3d centre = pose * kBall;
  int inside = 0;
  for (int y = 0; y < camera.height; ++y)
    for (int x = 0; x < camera.width; ++x) {
      const Vector3d ray = *camera.ray({double(x), double(y)});
      const double off = centre.cross(ray).norm();
      if (std::abs(off - kBallRadius) < 2e-4) continue;  // where the facets end
      EXPECT_EQ(view.mask.at(x, y) != 0, off < kBallRadius) << x << ' ' << y;
      inside += off < kBallRadius;
    }
  EXPECT_GT(inside, 1000);
}

/// Lambert's law with the inverse square, the ball's own shade and the shadow that it casts, in closed form.
TEST(PathTracer, ALampLightsAMattBallAndTheStageAsAPointDoes) {
  constexpr float kAlbedo = 0.6f, kPower = 3;
  const Vector3d lamp(-0.25, 0.4, 0.35);
  static const PathTracer tracer({make_sphere({.albedo = Array3f::Constant(kAlbedo)}, kBallRadius, kBall, 5),
                                  StageSurface(make_stage({})), make_studio()},
                                 kCoarse);
  const Camera camera = simulated_camera(320, 240);
  const Rigid3 pose = pose_from(30, 55, 0.45), object_from_camera = pose.inverse();
  const Vector3d eye = camera_centre(pose);
  RenderOptions dark{.lighting = 0};
  dark.lamp = {lamp.cast<float>(), Array3f::Constant(kPower)};
  const RenderedView view = tracer.render(LensRays(camera), pose, dark);
  dark.lamp->position = Eigen::Vector3f(0, 0, 50);  // straight above: what paper and ink reflect, without a shadow
  dark.lamp->power *= 2500;
  const RenderedView flat = tracer.render(LensRays(camera), pose, dark);
  const auto ball_before = [](const Vector3d& from, const Vector3d& way) -> std::optional<double> {
    const Vector3d to = kBall - from;
    const double along = to.dot(way.normalized()), off2 = to.squaredNorm() - along * along;
    if (along < 0 || off2 > kBallRadius * kBallRadius) return std::nullopt;
    return along - std::sqrt(kBallRadius * kBallRadius - off2);
  };
  int lit = 0, dark_side = 0, stage = 0, shadow = 0;
  for (int y = 2; y < camera.height - 2; ++y)
    for (int x = 2; x < camera.width - 2; ++x) {
      const Vector3d ray = object_from_camera.rotation * *camera.ray({double(x), double(y)});
      const float seen = view.radiance.at(x, y, 1);
      if (const auto distance = ball_before(eye, ray)) {
        const Vector3d place = eye + *distance * ray.normalized(), n = (place - kBall) / kBallRadius,
                       to_lamp = lamp - place;
        const double cosine = n.dot(to_lamp.normalized());
        if (n.dot(-ray.normalized()) < 0.6) continue;  // the facets of the rim, and what Fresnel takes there
        if (cosine < -0.05) {
          EXPECT_EQ(seen, 0) << x << ' ' << y;
          ++dark_side;
        } else if (cosine > 0.1) {
          EXPECT_NEAR(seen, kAlbedo / M_PI * kPower * cosine / to_lamp.squaredNorm(), 0.02 * seen) << x << ' ' << y;
          ++lit;
        }
        continue;
      }
      const Vector3d place = eye - eye.z() / ray.z() * ray, to_lamp = lamp - place;
      const Vector3d to_ball = kBall - place;
      const double off = to_ball.cross(to_lamp.normalized()).norm();
      if (std::hypot(place.x(), place.y()) > 0.12 || to_ball.cross(Vector3d::UnitZ()).norm() < kBallRadius + 0.003 ||
          to_ball.cross((eye - place).normalized()).norm() < kBallRadius + 0.003)
        continue;
      if (off < kBallRadius - 0.004) {
        EXPECT_EQ(seen, 0) << x << ' ' << y;
        ++shadow;
      } else if (off > kBallRadius + 0.004) {
        const double expected = flat.radiance.at(x, y, 1) * to_lamp.normalized().z() / to_lamp.squaredNorm();
        EXPECT_NEAR(seen, expected, 0.02 * expected) << x << ' ' << y;
        ++stage;
      }
    }
  EXPECT_GT(lit, 500);
  EXPECT_GT(dark_side, 100);
  EXPECT_GT(stage, 1000);
  EXPECT_GT(shadow, 100);
}

TEST(PathTracer, TheSamePictureComesTwice) {
  const Camera camera = simulated_camera(64, 48);
  const Rigid3 pose = pose_from(100, 40, 0.5);
  const RenderedView first = ball_on_stage().render(LensRays(camera), pose);
  EXPECT_EQ(first.radiance, ball_on_stage().render(LensRays(camera), pose).radiance);
  for (std::size_t i = 0; i < first.radiance.size(); ++i) {
    ASSERT_TRUE(std::isfinite(first.radiance.data()[i]));
    ASSERT_GE(first.radiance.data()[i], 0);
  }
}

TEST(PathTracer, FewLobeSamplesStandForMany) {
  const Camera camera = simulated_camera(160, 120);
  const Rigid3 pose = pose_from(-120, 40, 0.35);
  const RenderedView few = ball_on_stage().render(LensRays(camera), pose);
  const RenderedView many = ball_on_stage().render(LensRays(camera), pose, {.lobe_samples = 1024});
  double squared = 0, level = 0;
  int count = 0;
  for (int y = 0; y < camera.height; ++y)
    for (int x = 0; x < camera.width; ++x) {
      if (!few.mask.at(x, y)) continue;
      squared += std::pow(few.radiance.at(x, y, 1) - many.radiance.at(x, y, 1), 2);
      level += many.radiance.at(x, y, 1);
      ++count;
    }
  EXPECT_LT(std::sqrt(squared / count), 0.015 * level / count) << "grain and bias together below 1.5 %";
}

TEST(StageSurface, PrintsTheLayoutsTags) {
  const StageLayout layout = make_stage({});
  const StageSurface surface(layout);
  using Region = StageSurface::Region;
  for (const StageTag& tag : layout.tags) {
    const TagPattern pattern = tag_pattern(tag.id);
    const Vector3d right = (tag.corners_object[1] - tag.corners_object[0]) / 8,
                   down = (tag.corners_object[3] - tag.corners_object[0]) / 8;
    for (int row = -1; row <= 8; ++row)
      for (int column = -1; column <= 8; ++column) {
        const Vector3d p = tag.corners_object[0] + (column + 0.5) * right + (row + 0.5) * down;
        const bool in_tag = row >= 0 && row < 8 && column >= 0 && column < 8;
        const bool white = !in_tag || pattern.white[row][column];
        EXPECT_EQ(surface.region(float(p.x()), float(p.y())), white ? Region::kPaper : Region::kInk)
            << tag.id << ' ' << row << ' ' << column;
      }
  }
  EXPECT_EQ(surface.region(0, 0), Region::kPaper);
  EXPECT_EQ(surface.region(0.21f, 0), Region::kTable);
  EXPECT_EQ(surface.region(1, 0), Region::kNothing);
}

TEST(LensRays, RefusesALensThatFolds) {
  Camera camera = simulated_camera(64, 48);
  camera.distortion = {-3, 0, 0, 0, 0};
  EXPECT_THROW(LensRays{camera}, ConfigError);
  camera = simulated_camera(64, 48);
  camera.fx = 0;
  EXPECT_THROW(LensRays{camera}, ConfigError);
}

TEST(LensRays, AgreesWithTheCameraBetweenPixels) {
  const Camera camera = simulated_camera(128, 96);
  const LensRays lens(camera);
  for (double y = -0.4; y < 95.4; y += 7.3)
    for (double x = -0.4; x < 127.4; x += 9.1) {
      const Vector2d back = *camera.project(lens.direction(float(x), float(y)).cast<double>());
      EXPECT_NEAR(back.x(), x, 1e-3);
      EXPECT_NEAR(back.y(), y, 1e-3);
    }
}

}  // namespace
}  // namespace sheen
