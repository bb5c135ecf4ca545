// SPDX-License-Identifier: Apache-2.0
#include "reconstructor/studies/patch_sample.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <numeric>
#include <random>

#include "tests/support/test_matrices.h"

namespace sheen {
namespace {

using testing::ElementsAre;

PatchMatrix patch_of(const Eigen::MatrixXf& columns, std::vector<std::uint32_t> images) {
  return {.columns = columns,
          .known = KnownValues::Ones(columns.rows(), columns.cols()),
          .eyes = {},
          .reliability = {},
          .images = std::move(images)};
}

Eigen::MatrixXf noise(int rows, int columns, unsigned seed) {
  std::mt19937 generator(seed);
  std::normal_distribution<float> normal;
  return Eigen::MatrixXf::NullaryExpr(rows, columns, [&] { return normal(generator); });
}

TEST(PatchSample, OrdersRunAsTheImagesDo) {
  const std::vector<PatchMatrix> patches = {patch_of(noise(4, 3, 1), {0, 2, 5}), patch_of(noise(4, 2, 2), {1, 4})};
  const std::vector<std::uint32_t> images = {5, 4, 3, 2, 1, 0};
  const auto orders = orders_by_image(patches, images);
  EXPECT_THAT(orders[0], ElementsAre(2, 1, 0));
  EXPECT_THAT(orders[1], ElementsAre(1, 0));
}

TEST(PatchSample, OrdersByNormRiseAndFall) {
  Eigen::MatrixXf columns = Eigen::MatrixXf::Zero(3, 3);
  columns.diagonal() << 2, 3, 1;
  const std::vector<PatchMatrix> patches = {patch_of(columns, {0, 1, 2})};
  EXPECT_THAT(orders_by_norm(patches, true)[0], ElementsAre(2, 0, 1));
  EXPECT_THAT(orders_by_norm(patches, false)[0], ElementsAre(1, 0, 2));
}

TEST(PatchSample, ErrorsAreThoseOfTheSingularValues) {
  Eigen::MatrixXf columns = Eigen::MatrixXf::Zero(6, 4);
  columns.diagonal() << 4, 3, 2, 1;  // singular values
  const std::vector<PatchMatrix> patches = {patch_of(columns, {0, 1, 2, 3}), patch_of(columns, {0, 1, 2, 3})};
  EXPECT_NEAR(batch_error(patches, 2), std::sqrt((4.0 + 1) / 30), 1e-6);
  EXPECT_NEAR(batch_error(patches, 4), 0, 1e-6);
  const std::vector<std::uint32_t> images = {3, 1, 0, 2};
  const double online =
      online_error(patches, orders_by_image(patches, images), {.max_rank = 2, .internal_rank = 4, .tolerance = 0});
  EXPECT_NEAR(online, std::sqrt((4.0 + 1) / 30), 1e-4) << "nothing is lost inside";
}

TEST(PatchSample, OnlineIsNeverBetterThanTheBestThereIs) {
  const std::vector<PatchMatrix> patches = {patch_of(noise(40, 30, 3), {}), patch_of(noise(60, 25, 4), {})};
  std::vector<PatchMatrix> numbered = patches;
  for (PatchMatrix& patch : numbered)
    for (int j = 0; j < patch.views(); ++j) patch.images.push_back(static_cast<std::uint32_t>(j));
  for (const int rank : {1, 3, 8}) {
    const double online = online_error(numbered, orders_by_norm(numbered, true),
                                       {.max_rank = rank, .internal_rank = rank, .tolerance = 0});
    EXPECT_GT(online, batch_error(numbered, rank) * (1 - 1e-6));
    EXPECT_LT(online, 1);
  }
}

TEST(PatchSample, WithHolesNoOrderExplainsWhatIsKnownBetterThanTheBatch) {
  std::vector<PatchMatrix> patches;
  std::mt19937 generator(5);
  for (unsigned r = 0; r < 3; ++r) {
    std::vector<std::uint32_t> images(24);
    std::iota(images.begin(), images.end(), 0u);
    PatchMatrix patch = patch_of(patch_like_matrix(48, 24, 6, 0.05f, 30 + 40 * r), images);
    for (int j = 0; j < patch.views(); ++j)
      if (generator() % 3 > 0) patch.known.col(j).head(3 * static_cast<Eigen::Index>(generator() % 12)).setZero();
    patches.push_back(std::move(patch));
  }
  const double best = batch_surprise(patches, 3);
  std::vector<std::uint32_t> images(24);
  std::iota(images.begin(), images.end(), 0u);
  double least = 1e9, most = -1e9;
  for (int order = 0; order < 4; ++order) {
    for (const int inside : {3, 6}) {
      const double online = online_surprise(patches, orders_by_image(patches, images),
                                            {.max_rank = 3, .internal_rank = inside, .tolerance = 0});
      least = std::min(least, online);
      most = std::max(most, online);
    }
    std::shuffle(images.begin(), images.end(), generator);
  }
  EXPECT_GE(least, best - 1e-5);
  EXPECT_GT(most, best + 1e-3) << "and some are worse";
}

}  // namespace
}  // namespace sheen
