// SPDX-License-Identifier: Apache-2.0
#include "reconstructor/studies/depth_merging.h"

#include <gtest/gtest.h>

#include <cmath>
#include <vector>

namespace sheen {
namespace {

TEST(DepthMergingTest, IsTheWeightedMean) {
  const std::vector<ImageF> depths{ImageF(2, 1, 1, 1.0f), ImageF(2, 1, 1, 4.0f)};
  std::vector<ImageF> confidences{ImageF(2, 1, 1, 1.0f), ImageF(2, 1, 1, 0.5f)};
  confidences[0].at(1, 0) = confidences[1].at(1, 0) = 0;
  const ImageF merged = merge_depths(depths, confidences);
  EXPECT_NEAR(merged.at(0, 0), 2, 1e-6);
  EXPECT_NEAR(merged.at(1, 0), 1, 1e-6) << "where nobody is sure, the first";
}

TEST(DepthMergingTest, OnlyTextureInTwoDirectionsIsTrusted) {
  ImageF flat(40, 40, 1, 0.5f), stripes = flat, spots = flat;
  for (int y = 0; y < 40; ++y)
    for (int x = 0; x < 40; ++x) {
      stripes.at(x, y) = 0.5f + 0.3f * std::sin(0.8f * static_cast<float>(x));
      spots.at(x, y) = stripes.at(x, y) + 0.3f * std::sin(0.8f * static_cast<float>(y));
    }
  EXPECT_LT(texture_confidence(flat).at(20, 20), 1e-8);
  EXPECT_LT(texture_confidence(stripes).at(20, 20), 1e-6);
  EXPECT_GT(texture_confidence(spots).at(20, 20), 1e-4);
}

}  // namespace
}  // namespace sheen
