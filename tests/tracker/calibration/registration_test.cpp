// SPDX-License-Identifier: Apache-2.0
#include "tracker/calibration/registration.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <Eigen/Cholesky>
#include <Eigen/Geometry>
#include <cmath>
#include <random>

#include "tests/common/registration/lopsided_object.h"
#include "tests/support/expect_error.h"
#include "tests/support/temp_folder.h"
#include "tests/support/test_meshes.h"

namespace sheen {
namespace {

using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::IsEmpty;

constexpr double kRadius = 0.08;

Mesh ball() {
  return sphere_mesh(static_cast<float>(kRadius), 4);
}

Similarity random_place(std::mt19937& rng, double scale = 1) {
  std::normal_distribution<double> normal;
  Similarity place;
  place.scale = scale;
  place.rotation =
      Eigen::Quaterniond(normal(rng), normal(rng), normal(rng), normal(rng)).normalized().toRotationMatrix();
  place.translation = 0.1 * Eigen::Vector3d(normal(rng), normal(rng), normal(rng));
  return place;
}

Eigen::Vector3d random_vector(std::mt19937& rng, double sigma) {
  std::normal_distribution<double> normal(0, sigma);
  const double x = normal(rng), y = normal(rng), z = normal(rng);
  return {x, y, z};
}

/// Points of the ball's vertices and where they are on the stage, exactly.
Correspondences exact_points(const Mesh& mesh, int count, const Similarity& place, std::mt19937& rng) {
  std::uniform_int_distribution<std::size_t> any(0, mesh.vertices.size() - 1);
  Correspondences picked;
  for (int i = 0; i < count; ++i) {
    const Eigen::Vector3d point = mesh.vertices[any(rng)].cast<double>();
    picked.points.push_back({.name = "p" + std::to_string(i), .mesh = point, .stage = place * point});
  }
  return picked;
}

Correspondences octahedron(const Similarity& place) {
  Correspondences picked;
  for (int i = 0; i < 6; ++i) {
    const Eigen::Vector3d point = (i % 2 ? kRadius : -kRadius) * Eigen::Vector3d::Unit(i / 2);
    picked.points.push_back({.name = "p" + std::to_string(i), .mesh = point, .stage = place * point});
  }
  return picked;
}

PointRegistration by_points(const Correspondences& picked, const Mesh& mesh, PointOptions options = {}) {
  return register_points(picked, mesh, {}, options);
}

double largest_difference(const Similarity& a, const Similarity& b, const Mesh& mesh) {
  double largest = 0;
  for (const Eigen::Vector3f& v : mesh.vertices)
    largest = std::max(largest, (a * v.cast<double>() - b * v.cast<double>()).norm());
  return largest;
}

TEST(RegisterPoints, FindsTheExactPlace) {
  std::mt19937 rng(1);
  const Mesh mesh = ball();
  for (int run = 0; run < 20; ++run) {
    const Similarity truth = random_place(rng);
    const PointRegistration found = by_points(octahedron(truth), mesh);
    EXPECT_LT(largest_difference(found.placement.stage_from_mesh, truth, mesh), 1e-9);
    EXPECT_LT(found.rms_m, 1e-9);
  }
}

TEST(RegisterPoints, FindsTheScaleToo) {
  std::mt19937 rng(2);
  Mesh millimetres = ball();
  for (Eigen::Vector3f& v : millimetres.vertices) v *= 1000;
  const Similarity truth = random_place(rng, 0.00102);
  Correspondences picked;
  for (int i = 0; i < 6; ++i) {
    const Eigen::Vector3d point = (i % 2 ? 1000 : -1000) * kRadius * Eigen::Vector3d::Unit(i / 2);
    picked.points.push_back({.name = "p" + std::to_string(i), .mesh = point, .stage = truth * point});
  }
  const PointRegistration found = by_points(picked, millimetres, {.free_scale = true, .scale = 0.001});
  EXPECT_NEAR(found.placement.stage_from_mesh.scale / truth.scale, 1, 1e-9);
  EXPECT_LT(largest_difference(found.placement.stage_from_mesh, truth, millimetres), 1e-9);
}

/// Normalised squared errors of many runs with noise, and their mean.
double mean_nees(int runs, int points, bool free_scale, double noise_m, std::optional<double> told) {
  std::mt19937 rng(3);
  const Mesh mesh = ball();
  const int n = free_scale ? 7 : 6;
  double sum = 0;
  for (int run = 0; run < runs; ++run) {
    const Similarity truth = random_place(rng);
    Correspondences picked = exact_points(mesh, points, truth, rng);
    for (PickedPoint& point : picked.points) *point.stage += random_vector(rng, noise_m);
    picked.stage_uncertainty_m = told;
    const PointRegistration found = by_points(picked, mesh, {.free_scale = free_scale});
    const PlacementStep error = step_between(found.placement.stage_from_mesh, truth, found.placement.centre);
    const Eigen::MatrixXd covariance = found.placement.covariance.topLeftCorner(n, n);
    sum += error.head(n).dot(covariance.ldlt().solve(Eigen::VectorXd(error.head(n))));
  }
  return sum / runs;
}

// The sum over runs of a squared error in its units is chi-squared: mean n, variance 2 n / runs; 99.9 % of it.
TEST(RegisterPoints, ErrsByAsMuchAsItSaysWhereTheNoiseIsTold) {
  for (const bool free_scale : {false, true}) {
    const double n = free_scale ? 7 : 6;
    EXPECT_NEAR(mean_nees(100, 8, free_scale, 1e-3, 1e-3), n, 3.3 * std::sqrt(2 * n / 100)) << free_scale;
  }
}

// With the noise from v degrees of freedom it is n times Fisher's F: mean n v / (v - 2),
// variance 2 n v^2 (n + v - 2) / ((v - 2)^2 (v - 4)) over the runs.
TEST(RegisterPoints, ErrsByAsMuchAsItSaysWhereTheResidualsTellTheNoise) {
  for (const double noise_m : {0.1e-3, 1e-3, 3e-3}) {
    const double n = 6, v = 3 * 12 - n;
    const double mean = n * v / (v - 2);
    const double variance = 2 * n * v * v * (n + v - 2) / (std::pow(v - 2, 2) * (v - 4));
    EXPECT_NEAR(mean_nees(100, 12, false, noise_m, {}), mean, 3.3 * std::sqrt(variance / 100)) << noise_m;
  }
}

TEST(RegisterPoints, NamesTheOutlierAndLeavesItOut) {
  std::mt19937 rng(4);
  const Mesh mesh = ball();
  for (int run = 0; run < 50; ++run) {
    const Similarity truth = random_place(rng);
    Correspondences picked = octahedron(truth);
    for (PickedPoint& point : picked.points) *point.stage += random_vector(rng, 0.3e-3);
    *picked.points[2].stage += random_vector(rng, 1).normalized() * 0.02;
    const PointRegistration found = by_points(picked, mesh);
    for (std::size_t i = 0; i < 6; ++i) EXPECT_EQ(found.points[i].used, i != 2) << run << " " << i;
    ASSERT_FALSE(found.warnings.empty());
    EXPECT_THAT(found.warnings[0], HasSubstr("\"p2\" is an outlier"));
    EXPECT_LT(largest_difference(found.placement.stage_from_mesh, truth, mesh), 2e-3);
  }
}

TEST(RegisterPoints, TwoThatAreMixedUpAreBothNamed) {
  std::mt19937 rng(5);
  Correspondences picked = exact_points(ball(), 8, random_place(rng), rng);
  for (PickedPoint& point : picked.points) *point.stage += random_vector(rng, 0.3e-3);
  std::swap(picked.points[1].stage, picked.points[5].stage);
  const PointRegistration found = by_points(picked, ball());
  for (std::size_t i = 0; i < 8; ++i) EXPECT_EQ(found.points[i].used, i != 1 && i != 5) << i;
}

TEST(RegisterPoints, CleanPointsHaveNoOutlier) {
  std::mt19937 rng(6);
  const Mesh mesh = ball();
  int named = 0;
  for (int run = 0; run < 200; ++run) {
    Correspondences picked = exact_points(mesh, 6, random_place(rng), rng);
    for (PickedPoint& point : picked.points) *point.stage += random_vector(rng, run % 2 ? 0.3e-3 : 2e-3);
    for (const RegisteredPoint& point : by_points(picked, mesh).points) named += !point.used;
  }
  EXPECT_LE(named, 4);
}

TEST(RegisterPoints, PixelsInTwoImagesPlaceAPoint) {
  std::mt19937 rng(7);
  const Mesh mesh = ball();
  const Camera camera{.width = 1000, .height = 800, .fx = 1200, .fy = 1200, .cx = 500, .cy = 400};
  std::map<std::string, PosedCamera> views;
  const Similarity truth = random_place(rng);
  for (int i = 0; i < 3; ++i) {
    const Eigen::Vector3d eye = truth.translation + Eigen::Vector3d(0.5 * std::cos(i), 0.5 * std::sin(i), 0.3);
    views["images/" + std::to_string(i) + ".png"] = {camera, look_at(eye, truth.translation, Eigen::Vector3d::UnitZ())};
  }
  double sum = 0;
  for (int run = 0; run < 100; ++run) {
    Correspondences picked = octahedron(truth);
    picked.pixel_uncertainty_px = 0.5;
    for (PickedPoint& point : picked.points) {
      for (const auto& [name, view] : views) {
        const Eigen::Vector2d pixel = *view.camera.project(view.camera_from_object * *point.stage);
        point.pixels.push_back({run % 2 ? name : name.substr(7), pixel + random_vector(rng, 0.5).head<2>()});
      }
      point.stage.reset();
    }
    const PointRegistration found = register_points(picked, mesh, views, {});
    const PlacementStep error = step_between(found.placement.stage_from_mesh, truth, found.placement.centre);
    sum += error.head<6>().dot(found.placement.covariance.topLeftCorner<6, 6>().ldlt().solve(error.head<6>()));
    EXPECT_LT(found.points[0].residual_px, 3);
  }
  EXPECT_NEAR(sum / 100, 6, 3.3 * std::sqrt(12.0 / 100));
}

TEST(RegisterPoints, NamesWhatCannotBeRegistered) {
  std::mt19937 rng(8);
  const Mesh mesh = ball();
  const Correspondences good = octahedron(random_place(rng));

  Correspondences few = good;
  few.points.resize(2);
  expect_error<ConfigError>([&] { by_points(few, mesh); }, {"2 points", "three or more"});

  Correspondences line = good;
  for (std::size_t i = 0; i < 6; ++i) {
    line.points[i].mesh = Eigen::Vector3d(0.01 * double(i), 0, 0);
    line.points[i].stage = Eigen::Vector3d(0, 0.01 * double(i), 0.1);
  }
  expect_error<ConfigError>([&] { by_points(line, mesh); }, {"on one line"});

  Correspondences one_place = good;
  for (PickedPoint& point : one_place.points) point.mesh = Eigen::Vector3d(0.08, 0, 0);
  expect_error<ConfigError>([&] { by_points(one_place, mesh); }, {"at one place"});

  Correspondences mirrored = exact_points(mesh, 8, random_place(rng), rng);
  for (PickedPoint& point : mirrored.points) point.mesh.x() = -point.mesh.x();
  expect_error<ConfigError>([&] { by_points(mirrored, mesh); }, {"mirrored", "wrong sign"});

  Correspondences millimetres = good;
  for (PickedPoint& point : millimetres.points) point.mesh *= 1000;
  Mesh large = mesh;
  for (Eigen::Vector3f& v : large.vertices) v *= 1000;
  expect_error<ConfigError>([&] { by_points(millimetres, large); }, {"millimetres", "--unit mm"});

  Correspondences other_size = good;
  for (PickedPoint& point : other_size.points) point.mesh *= 3;
  Mesh thrice = mesh;
  for (Eigen::Vector3f& v : thrice.vertices) v *= 3;
  expect_error<ConfigError>([&] { by_points(other_size, thrice); }, {"as far apart", "--free-scale"});
  expect_error<ConfigError>([&] { by_points(good, large); }, {"not on the mesh"});
}

TEST(RegisterPoints, SaysThatTheMeshIsALittleTooSmall) {
  std::mt19937 rng(9);
  const Correspondences picked = octahedron(random_place(rng, 1.02));
  const PointRegistration found = by_points(picked, ball());
  ASSERT_THAT(found.warnings, ElementsAre(HasSubstr("too small")));
  EXPECT_THAT(by_points(picked, ball(), {.free_scale = true}).warnings, IsEmpty());
}

/// The lopsided object's mesh, turned by 180 degrees about x.
Mesh turned_over() {
  Mesh mesh = lopsided_mesh();
  for (Eigen::Vector3f& v : mesh.vertices) v = Eigen::Vector3f(v.x(), -v.y(), -v.z());
  return mesh;
}

TEST(RegisterMesh, AMeshInAnotherFrameIsTurnedBackAndThatIsSaid) {
  for (const bool masks : {false, true}) {
    const Registration found = register_mesh(turned_over(), nullptr, {}, from_three_sides(lopsided(), masks), {});
    EXPECT_EQ(found.not_found, "") << masks;
    EXPECT_THAT(found.undone, HasSubstr("turn it by 180 degrees about x")) << masks;
    const Mesh back = placed(turned_over(), found.placement.stage_from_mesh), right = lopsided_mesh();
    for (std::size_t v = 0; v < right.vertices.size(); v += 100)
      EXPECT_LT((back.vertices[v] - right.vertices[v]).norm(), 2 * kPixel) << masks;
  }
}

TEST(RegisterMesh, AnotherObjectsMeshIsNotFound) {
  Mesh other = sphere_mesh(0.05f, 4);
  for (Eigen::Vector3f& v : other.vertices) v += Eigen::Vector3f(-0.03f, 0.04f, -0.02f);
  EXPECT_NE(register_mesh(other, nullptr, {}, from_three_sides(lopsided(), true), {}).not_found, "");
}

TEST(Correspondences, AreReadAndRefusedByField) {
  const TempFolder folder;
  const auto file = folder.write("points.json", R"({"format": "sheen-correspondences", "version": 1,
    "stage_unit": "mm", "stage_uncertainty": 0.5, "points": [
      {"name": "nose", "mesh": [1, 2, 3], "stage": [10, 20, 30]},
      {"name": "ear", "mesh": [4, 5, 6], "pixels": {"a.png": [1, 2], "b.png": [3, 4]}}]})");
  const Correspondences read = load_correspondences(file);
  ASSERT_EQ(read.points.size(), 2u);
  EXPECT_LT((*read.points[0].stage - Eigen::Vector3d(0.01, 0.02, 0.03)).norm(), 1e-12);
  EXPECT_DOUBLE_EQ(*read.stage_uncertainty_m, 0.5e-3);
  EXPECT_EQ(read.points[1].pixels[1].image, "b.png");
  const auto refused = [&](const std::string& points, const std::string& field) {
    const auto wrong =
        folder.write("wrong.json", R"({"format": "sheen-correspondences", "version": 1, "points": )" + points + "}");
    expect_error([&] { load_correspondences(wrong); }, {"wrong.json", field});
  };
  refused("[]", "points");
  refused(R"([{"name": "a", "mesh": [1, 2], "stage": [1, 2, 3]}])", "points[0].mesh");
  refused(R"([{"name": "a", "mesh": [1, 2, 3]}])", "points[0].stage");
  refused(R"([{"name": "a", "mesh": [1, 2, 3], "stage": [1, 2, "x"]}])", "points[0].stage[2]");
  refused(R"([{"name": "a", "mesh": [1, 2, 3], "pixels": {"a.png": [1, 2]}}])", "points[0].pixels");
}

}  // namespace
}  // namespace sheen
