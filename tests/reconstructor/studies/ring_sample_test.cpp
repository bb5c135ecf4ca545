// SPDX-License-Identifier: Apache-2.0
#include "reconstructor/studies/ring_sample.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <numeric>
#include <random>

#include "tests/support/test_matrices.h"

namespace sheen {
namespace {

using testing::ElementsAre;

RingMatrix ring_of(const Eigen::MatrixXf& columns, std::vector<std::uint32_t> images) {
  return {.columns = columns,
          .known = KnownValues::Ones(columns.rows(), columns.cols()),
          .directions = {},
          .cosines = {},
          .images = std::move(images)};
}

Eigen::MatrixXf noise(int rows, int columns, unsigned seed) {
  std::mt19937 generator(seed);
  std::normal_distribution<float> normal;
  return Eigen::MatrixXf::NullaryExpr(rows, columns, [&] { return normal(generator); });
}

TEST(RingSample, OrdersRunAsTheImagesDo) {
  const std::vector<RingMatrix> rings = {ring_of(noise(4, 3, 1), {0, 2, 5}), ring_of(noise(4, 2, 2), {1, 4})};
  const std::vector<std::uint32_t> images = {5, 4, 3, 2, 1, 0};
  const auto orders = orders_by_image(rings, images);
  EXPECT_THAT(orders[0], ElementsAre(2, 1, 0));
  EXPECT_THAT(orders[1], ElementsAre(1, 0));
}

TEST(RingSample, OrdersByNormRiseAndFall) {
  Eigen::MatrixXf columns = Eigen::MatrixXf::Zero(3, 3);
  columns.diagonal() << 2, 3, 1;
  const std::vector<RingMatrix> rings = {ring_of(columns, {0, 1, 2})};
  EXPECT_THAT(orders_by_norm(rings, true)[0], ElementsAre(2, 0, 1));
  EXPECT_THAT(orders_by_norm(rings, false)[0], ElementsAre(1, 0, 2));
}

TEST(RingSample, ErrorsAreThoseOfTheSingularValues) {
  Eigen::MatrixXf columns = Eigen::MatrixXf::Zero(6, 4);
  columns.diagonal() << 4, 3, 2, 1;  // singular values
  const std::vector<RingMatrix> rings = {ring_of(columns, {0, 1, 2, 3}), ring_of(columns, {0, 1, 2, 3})};
  EXPECT_NEAR(batch_error(rings, 2), std::sqrt((4.0 + 1) / 30), 1e-6);
  EXPECT_NEAR(batch_error(rings, 4), 0, 1e-6);
  const std::vector<std::uint32_t> images = {3, 1, 0, 2};
  const double online =
      online_error(rings, orders_by_image(rings, images), {.max_rank = 2, .internal_rank = 4, .tolerance = 0});
  EXPECT_NEAR(online, std::sqrt((4.0 + 1) / 30), 1e-4) << "nothing is lost inside";
}

TEST(RingSample, OnlineIsNeverBetterThanTheBestThereIs) {
  const std::vector<RingMatrix> rings = {ring_of(noise(40, 30, 3), {}), ring_of(noise(60, 25, 4), {})};
  std::vector<RingMatrix> numbered = rings;
  for (RingMatrix& ring : numbered)
    for (int j = 0; j < ring.views(); ++j) ring.images.push_back(static_cast<std::uint32_t>(j));
  for (const int rank : {1, 3, 8}) {
    const double online = online_error(numbered, orders_by_norm(numbered, true),
                                       {.max_rank = rank, .internal_rank = rank, .tolerance = 0});
    EXPECT_GT(online, batch_error(numbered, rank) * (1 - 1e-6));
    EXPECT_LT(online, 1);
  }
}

TEST(RingSample, WithHolesNoOrderExplainsWhatIsKnownBetterThanTheBatch) {
  std::vector<RingMatrix> rings;
  std::mt19937 generator(5);
  for (unsigned r = 0; r < 3; ++r) {
    std::vector<std::uint32_t> images(24);
    std::iota(images.begin(), images.end(), 0u);
    RingMatrix ring = ring_of(ring_like_matrix(48, 24, 6, 0.05f, 30 + 40 * r), images);
    for (int j = 0; j < ring.views(); ++j)
      if (generator() % 3 > 0) ring.known.col(j).head(3 * static_cast<Eigen::Index>(generator() % 12)).setZero();
    rings.push_back(std::move(ring));
  }
  const double best = batch_surprise(rings, 3);
  std::vector<std::uint32_t> images(24);
  std::iota(images.begin(), images.end(), 0u);
  double least = 1e9, most = -1e9;
  for (int order = 0; order < 4; ++order) {
    for (const int inside : {3, 6}) {
      const double online = online_surprise(rings, orders_by_image(rings, images),
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
