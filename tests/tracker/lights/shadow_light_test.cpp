// SPDX-License-Identifier: Apache-2.0
#include "tracker/lights/shadow_light.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <Eigen/LU>
#include <random>

#include "tests/support/expect_error.h"
#include "tests/support/temp_folder.h"
#include "tracker/lights/shadow_file.h"

namespace sheen {
namespace {

using Pairs = std::vector<ShadowPair>;
using ::testing::ElementsAre;
using ::testing::HasSubstr;

/// Points above a table and where a lamp casts their shadows on it; then errors of `sigma` metres in each coordinate.
class Table {
 public:
  explicit Table(unsigned seed) : random_(seed) {}

  double uniform(double low, double high) { return std::uniform_real_distribution<double>(low, high)(random_); }
  Eigen::Vector3d error(double sigma) {
    std::normal_distribution<double> normal(0, sigma);
    return {normal(random_), normal(random_), normal(random_)};
  }
  Eigen::Vector3d lamp(double nearest, double farthest) {
    const double z = uniform(0.5, 1), turn = uniform(0, 2 * M_PI), flat = std::sqrt(1 - z * z);
    return uniform(nearest, farthest) * Eigen::Vector3d(flat * std::cos(turn), flat * std::sin(turn), z);
  }
  Pairs pairs(const Eigen::Vector3d& lamp, int count, double sigma) {
    Pairs pairs;
    for (int i = 0; i < count; ++i) {
      const Eigen::Vector3d object(uniform(-0.15, 0.15), uniform(-0.15, 0.15), uniform(0.04, 0.12));
      const Eigen::Vector3d shadow = object + (object - lamp) * object.z() / (lamp.z() - object.z());
      pairs.push_back({.shadow = shadow + error(sigma), .object = object + error(sigma)});
      pairs.back().shadow_covariance = pairs.back().object_covariance =
          (sigma > 0 ? sigma * sigma : 1) * Eigen::Matrix3d::Identity();
    }
    return pairs;
  }

 private:
  std::mt19937 random_;
};

/// Angle to the true lamp in standard deviations, seen from where the direction is.
double direction_sigmas(const ShadowLight& found, const Eigen::Vector3d& lamp) {
  const Eigen::Vector3d truth = (lamp - found.centre).normalized();
  return truth.cross(found.direction).norm() * 180 / M_PI / found.direction_uncertainty_deg;
}

TEST(ShadowLightTest, ExactPairsGiveTheExactLamp) {
  Table table(1);
  const Eigen::Vector3d lamp(0.3, -0.4, 0.9);
  const ShadowLight found = light_of_shadows(table.pairs(lamp, 4, 0), false);
  EXPECT_EQ(found.light.kind, LightKind::kPoint);
  EXPECT_LT((found.light.position - lamp).norm(), 1e-9);
  EXPECT_LT(found.rms, 1e-12);
  EXPECT_EQ(found.why_directional, "");
}

TEST(ShadowLightTest, ExactParallelPairsGiveADirection) {
  const Eigen::Vector3d towards = Eigen::Vector3d(0.2, 0.1, 0.9).normalized();
  Pairs pairs;
  for (const Eigen::Vector3d& shadow :
       {Eigen::Vector3d(0.1, 0, 0), Eigen::Vector3d(0, 0.2, 0), Eigen::Vector3d(-0.1, 0.05, 0)})
    pairs.push_back({.shadow = shadow, .object = shadow + (0.05 + shadow.y()) * towards});
  const ShadowLight found = light_of_shadows(pairs, false);
  EXPECT_EQ(found.light.kind, LightKind::kDirectional);
  EXPECT_LT((found.light.position - towards).norm(), 1e-12);
  EXPECT_THAT(found.why_directional, HasSubstr("nearly parallel"));
}

/// The squares of the position's errors, in its reported standard deviations, are chi-squared with three degrees of
/// freedom each: their sum over 100 runs is 300 +- 24.5, and is outside of 3.5 of these once in 2000 times.
TEST(ShadowLightTest, ErrsByAsMuchAsItSaysWhereTheNoiseIsTold) {
  double squares = 0, angles = 0;
  for (unsigned run = 0; run < 100; ++run) {
    Table table(run);
    const Eigen::Vector3d lamp = table.lamp(0.5, 1.2);
    const ShadowLight found = light_of_shadows(table.pairs(lamp, 8, 0.3e-3), true);
    ASSERT_EQ(found.light.kind, LightKind::kPoint) << run;
    const Eigen::Vector3d error = found.light.position - lamp;
    squares += error.dot(found.covariance.inverse() * error);
    angles += std::pow(direction_sigmas(found, lamp), 2);
    EXPECT_LT(found.direction_uncertainty_deg, 1);
  }
  EXPECT_NEAR(squares, 300, 86);
  EXPECT_NEAR(angles, 100, 50);
}

/// Where the residuals say the noise, each uncertainty holds the truth in 68 of 100 runs, +- 4.7.
TEST(ShadowLightTest, ErrsByAsMuchAsItSaysWhereTheResidualsSayTheNoise) {
  for (const int count : {3, 6}) {
    int held = 0;
    for (unsigned run = 0; run < 100; ++run) {
      Table table(1000 + run);
      const Eigen::Vector3d lamp = table.lamp(0.5, 1.2);
      const ShadowLight found = light_of_shadows(table.pairs(lamp, count, 0.3e-3), false);
      const double truth = 1 / (lamp - found.centre).norm();
      held += std::abs(found.inverse_distance - truth) < found.inverse_distance_uncertainty;
    }
    EXPECT_NEAR(held, 68, 15) << count;
  }
}

TEST(ShadowLightTest, ALampWhoseDistanceIsNotKnownIsADirection) {
  double angles = 0;
  for (unsigned run = 0; run < 100; ++run) {
    Table table(2000 + run);
    const Eigen::Vector3d lamp = table.lamp(40, 60);
    const ShadowLight found = light_of_shadows(table.pairs(lamp, 8, 1e-3), true);
    ASSERT_EQ(found.light.kind, LightKind::kDirectional) << run;
    EXPECT_THAT(found.why_directional, HasSubstr("1 / distance"));
    EXPECT_LT(std::abs(found.inverse_distance - 1 / lamp.norm()), 5 * found.inverse_distance_uncertainty);
    angles += std::pow(direction_sigmas(found, lamp), 2);
  }
  EXPECT_NEAR(angles, 100, 50);
  Table table(3);
  const ShadowLight near = light_of_shadows(table.pairs({0, 0, 0.8}, 8, 0.3e-3), true, true);
  EXPECT_EQ(near.light.kind, LightKind::kDirectional);
  EXPECT_LT(direction_sigmas(near, {0, 0, 0.8}), 30) << "asked for";
}

TEST(ShadowLightTest, PairsThatSayNothingOrContradictAreNamed) {
  Table table(4);
  const Eigen::Vector3d lamp(0.2, 0.3, 0.7);
  Pairs pairs = table.pairs(lamp, 8, 0.3e-3);
  for (const bool known : {true, false}) {
    EXPECT_TRUE(light_of_shadows(pairs, known).outliers.empty());
    Pairs wrong = pairs;
    wrong[5].shadow.x() += 0.03;
    const ShadowLight without = light_of_shadows(wrong, known);
    EXPECT_THAT(without.outliers, ElementsAre(5u));
    EXPECT_LT((without.light.position - lamp).norm(), 5 * std::sqrt(without.covariance.trace()));
    EXPECT_NEAR(without.residuals[5], 0.03, 0.01);
  }
  Pairs noisier = table.pairs(lamp, 8, 6e-3);
  for (ShadowPair& pair : noisier) pair.shadow_covariance = pair.object_covariance = 1e-8 * Eigen::Matrix3d::Identity();
  const ShadowLight told_too_little = light_of_shadows(noisier, true);
  EXPECT_TRUE(told_too_little.outliers.empty()) << "all err alike";
  EXPECT_GT(told_too_little.noise, 30);
  Pairs swapped = pairs;
  std::swap(swapped[2].shadow, swapped[2].object);
  expect_error<Error>([&] { light_of_shadows(swapped, true); }, {"pair 3", "swapped"});
  for (ShadowPair& pair : swapped = pairs) std::swap(pair.shadow, pair.object);
  expect_error<Error>([&] { light_of_shadows(swapped, true); }, {"swapped"});
  Pairs one(pairs.begin(), pairs.begin() + 1);
  expect_error<Error>([&] { light_of_shadows(one, false); }, {"one pair", "uncertainty"});
  EXPECT_THAT(light_of_shadows(one, true).why_directional, HasSubstr("one pair"));
  one[0].object = one[0].shadow;
  expect_error<Error>([&] { light_of_shadows(one, true); }, {"pair 1", "one point"});
  expect_error<Error>([&] { light_of_shadows({}, true); }, {"no pair"});
}

/// Points on a table and on a block, seen by a camera; a lamp casts the block's corners onto the table.
class ClickedPixels : public ::testing::Test {
 protected:
  ClickedPixels() {
    const auto quad = [&](const Eigen::Vector3f& a, const Eigen::Vector3f& u, const Eigen::Vector3f& v) {
      const auto first = static_cast<std::uint32_t>(mesh_.vertices.size());
      for (const Eigen::Vector3f& corner :
           {a, Eigen::Vector3f(a + u), Eigen::Vector3f(a + u + v), Eigen::Vector3f(a + v)})
        mesh_.vertices.push_back(corner);
      mesh_.triangles.push_back({first, first + 1, first + 2});
      mesh_.triangles.push_back({first, first + 2, first + 3});
    };
    quad({-1, -1, 0}, {2, 0, 0}, {0, 2, 0});
    quad({-0.1f, -0.1f, 0.1f}, {0.2f, 0, 0}, {0, 0.2f, 0});
  }
  ClickedLight clicks(const Eigen::Vector3d& lamp, double sigma_px, unsigned seed) const {
    Table table(seed);
    ClickedLight light{.image = "a.png"};
    while (light.pairs.size() < 8) {
      const Eigen::Vector3d object(table.uniform(-0.09, 0.09), table.uniform(-0.09, 0.09), 0.1);
      const Eigen::Vector3d shadow = object + (object - lamp) * 0.1 / (lamp.z() - 0.1);
      const auto click = [&](const Eigen::Vector3d& at) {
        return ClickedPoint{.pixel =
                                *view_.camera.project(view_.camera_from_object * at) + table.error(sigma_px).head<2>()};
      };
      // What the block hides of the table a person cannot click.
      if (std::abs(shadow.x()) < 0.125 && shadow.y() > -0.1) continue;
      light.pairs.push_back({click(shadow), click(object)});
    }
    return light;
  }

  Mesh mesh_;
  PosedCamera view_{
      {.width = 800, .height = 600, .fx = 700, .fy = 700, .cx = 400, .cy = 300, .distortion = {-0.1, 0.02, 0, 0, 0}},
      look_at({0, -0.9, 0.8}, {0, 0, 0}, {0, 0, 1})};
  const Eigen::Vector3d lamp_{0.5, 0.2, 0.6};
};

TEST_F(ClickedPixels, AreSeenOnTheMesh) {
  const ClickedLight exact = clicks(lamp_, 0, 1);
  const ShadowLight found = light_of_shadows(pairs_in_space(exact, {}, &view_, &mesh_), false);
  EXPECT_LT((found.light.position - lamp_).norm(), 1e-4);
  double squares = 0;
  for (unsigned run = 0; run < 100; ++run) {
    const auto pairs =
        pairs_in_space(clicks(lamp_, 0.15, run), {.lights = {}, .pixel_uncertainty_px = 0.15}, &view_, &mesh_);
    const ShadowLight noisy = light_of_shadows(pairs, true);
    ASSERT_EQ(noisy.light.kind, LightKind::kPoint);
    const Eigen::Vector3d error = noisy.light.position - lamp_;
    squares += error.dot(noisy.covariance.inverse() * error);
  }
  EXPECT_NEAR(squares, 300, 86);
}

TEST_F(ClickedPixels, ThatShowNoSurfaceAreNamed) {
  ClickedLight light = clicks(lamp_, 0, 1);
  light.pairs[1].object.pixel = {400, 3};
  mesh_.triangles.erase(mesh_.triangles.begin(), mesh_.triangles.begin() + 2);
  light.pairs[0].shadow.pixel = light.pairs[0].object.pixel;
  light.pairs[1].shadow.pixel = light.pairs[1].object.pixel;
  expect_error<Error>([&] { pairs_in_space(light, {}, &view_, &mesh_); },
                      {"a.png", "pair 2", "the shadow", "nothing of the mesh"});
  light.pairs[1].shadow.pixel = {900, 3};
  expect_error<Error>([&] { pairs_in_space(light, {}, &view_, &mesh_); }, {"pair 2", "outside of the image"});
}

TEST(ShadowFileTest, IsReadInItsUnit) {
  const TempFolder temp;
  const auto read = [&](const std::string& rest) {
    return load_shadow_file(temp.write("pairs.json", R"({"format": "sheen-shadows", "version": 1, )" + rest + "}"));
  };
  const ShadowFile file = read(R"("unit": "mm", "uncertainty": 0.5, "lights": [
      {"image": "a.png", "pairs": [{"shadow": [10, 20, 0], "object": [0, 0, 100]}]}])");
  EXPECT_DOUBLE_EQ(*file.uncertainty_m, 0.5e-3);
  EXPECT_EQ(*file.lights.at(0).pairs.at(0).shadow.place, Eigen::Vector3d(0.01, 0.02, 0));
  EXPECT_FALSE(file.any_pixels());
  EXPECT_TRUE(read(R"("lights": [{"image": "a", "pairs": [{"shadow": [1, 2], "object": [3, 4]}]}])").any_pixels());
  const std::string pairs = R"("pairs": [{"shadow": [1, 2, 3], "object": [1, 2, 9]}])";
  for (const auto& [rest, words] : std::vector<std::pair<std::string, std::vector<std::string>>>{
           {R"("lights": [])", {"\"lights\""}},
           {R"("unit": "feet", "lights": [{"image": "a", )" + pairs + "}]", {"\"unit\"", "mm"}},
           {R"("lights": [{"image": "a", )" + pairs + R"(}, {"image": "a", )" + pairs + "}]",
            {"lights[1].image", "second time"}},
           {R"("lights": [{"image": "a", "pairs": [{"shadow": [1], "object": [1, 2, 9]}]}])",
            {"lights[0].pairs[0].shadow"}},
           {R"("lights": [{"image": "a", "pairs": [{"shadow": [1, 2, "x"], "object": [1, 2, 9]}]}])",
            {"shadow[2]", "number"}},
           {R"("lights": [{"image": "a", "pairs": [{"shadow": [1, 2, 3]}]}])", {"pairs[0].object", "missing"}},
           {R"("lights": [{"image": "a", "pairs": [{"shadow": [1, 2, 3], "object": [5, 6]}]}])",
            {"pixel_uncertainty"}}})
    expect_error([&, rest = rest] { read(rest); }, words);
}

}  // namespace
}  // namespace sheen
