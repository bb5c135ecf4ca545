// SPDX-License-Identifier: Apache-2.0
#include "reconstructor/surface/colour_planes.h"

#include <gtest/gtest.h>

#include <cmath>

#include "tests/support/test_matrices.h"

namespace sheen {
namespace {

std::vector<std::uint8_t> all_of(const ColourPlanes& planes) {
  return std::vector<std::uint8_t>(static_cast<std::size_t>(planes.samples()), 1);
}

const MapSides kSides{9, 4, 16}, kHalves{5, 3, 9};

/// RGB of each sample, by the sample's place in its triangle.
template <typename Colour>
Eigen::VectorXf colours(const MapSides& sides, Colour colour) {
  Eigen::VectorXf all(0);
  for (const int side : sides)
    for (int i = 0; i < side; ++i)
      for (int j = 0; i + j < side; ++j) {
        all.conservativeResize(all.size() + 3);
        all.tail<3>() = colour(static_cast<float>(i) / static_cast<float>(side - 1),
                               static_cast<float>(j) / static_cast<float>(side - 1));
      }
  return all;
}

Eigen::Vector3f linear(float u, float v) {
  return {0.2f + 0.5f * u - 0.3f * v, 0.1f + v, 1 - 0.7f * u};
}

/// Grey varies from sample to sample, what the channels differ by is linear.
Eigen::Vector3f fine_grey(float u, float v) {
  return linear(u, v).array() + 0.3f * std::sin(40 * u + 17 * v);
}

TEST(OpponentColours, AreOrthonormalAndGreyHasLumaAlone) {
  const Eigen::Matrix3f& m = opponent_colours();
  EXPECT_LT((m * m.transpose() - Eigen::Matrix3f::Identity()).norm(), 1e-6f);
  EXPECT_LT((m * Eigen::Vector3f::Ones() - Eigen::Vector3f(std::sqrt(3.0f), 0, 0)).norm(), 1e-6f);
}

TEST(ColourPlanes, OfFullSidesHoldAnyColoursAndTheirEnergy) {
  const ColourPlanes planes(kSides, kSides);
  const Eigen::VectorXf any = gaussian_matrix(3 * planes.samples(), 1, 3);
  const Eigen::VectorXf rows = planes.rows_of(any, all_of(planes));
  ASSERT_EQ(rows.size(), any.size());
  EXPECT_NEAR(rows.norm(), any.norm(), 1e-4f * any.norm());
  EXPECT_LT((planes.colours_of(rows) - any).norm(), 1e-5f * any.norm());
}

TEST(ColourPlanes, OfHalfSidesHoldFineGreyAndLinearChromaExactly) {
  const ColourPlanes planes(kSides, kHalves);
  const Eigen::VectorXf shown = colours(kSides, fine_grey);
  ASSERT_EQ(shown.size(), 3 * planes.samples());
  EXPECT_LT(planes.rows(), 0.6 * static_cast<double>(shown.size()));
  EXPECT_LT((planes.colours_of(planes.rows_of(shown, all_of(planes))) - shown).cwiseAbs().maxCoeff(), 1e-5f);
}

TEST(ColourPlanes, AUniformColourHasTheEnergyOfItsSamples) {
  const ColourPlanes planes(kSides, kHalves);
  const Eigen::VectorXf red = colours(kSides, [](float, float) { return Eigen::Vector3f(0.8f, 0.1f, 0.2f); });
  EXPECT_NEAR(planes.rows_of(red, all_of(planes)).norm(), red.norm(), 1e-4f * red.norm());
}

TEST(ColourPlanes, ColoursOfATriangleAreItsPartOfAll) {
  const ColourPlanes planes(kSides, kHalves);
  const Eigen::VectorXf rows = gaussian_matrix(planes.rows(), 1, 5), all = planes.colours_of(rows);
  for (const ColourPlanes::Triangle& triangle : planes.triangles())
    EXPECT_EQ(planes.colours_of(rows, triangle.first_sample),
              all.segment(3 * triangle.first_sample, 3 * lattice_samples(triangle.side)));
}

TEST(ColourPlanes, WhateverSamplesAreVisibleTheirColourIsGuessed) {
  const ColourPlanes planes({9}, {5});
  const Eigen::Vector3f green(0.1f, 0.8f, 0.3f);
  for (int only = 0; only < planes.samples(); ++only) {
    std::vector<std::uint8_t> visible(static_cast<std::size_t>(planes.samples()), 0);
    visible[static_cast<std::size_t>(only)] = 1;
    Eigen::VectorXf shown = Eigen::VectorXf::Constant(3 * planes.samples(), 9);
    shown.segment<3>(3 * only) = green;
    const std::vector<std::uint8_t> known = planes.guessed_places(visible), rows = planes.known_rows(known);
    ASSERT_EQ(known.size(), static_cast<std::size_t>(planes.samples() + planes.chroma_samples()));
    ASSERT_EQ(rows.size(), static_cast<std::size_t>(planes.rows()));
    Eigen::VectorXf values = planes.rows_of(shown, visible);
    for (int row = 0; row < planes.rows(); ++row)
      if (!rows[static_cast<std::size_t>(row)]) values[row] = 0;
    EXPECT_LT((planes.colours_of(values).segment<3>(3 * only) - green).norm(), 1e-3f) << only;
  }
}

TEST(ColourPlanes, ChromaThatVariesEvenlyIsTheSameHoweverMuchOfItIsVisible) {
  const ColourPlanes planes(kSides, kHalves);
  Eigen::VectorXf shown = colours(kSides, linear);
  const Eigen::VectorXf whole = planes.rows_of(shown, all_of(planes));
  std::vector<std::uint8_t> visible = all_of(planes);
  for (const ColourPlanes::Triangle& triangle : planes.triangles())
    for (int s = 0; s < lattice_samples(triangle.side) / 3; ++s) {
      visible[static_cast<std::size_t>(triangle.first_sample + s)] = 0;
      shown.segment<3>(3 * (triangle.first_sample + s)).setConstant(3);
    }
  const Eigen::VectorXf part = planes.rows_of(shown, visible);
  const std::vector<std::uint8_t> known = planes.known_rows(planes.guessed_places(visible));
  for (int row = 0; row < planes.rows(); ++row)
    if (known[static_cast<std::size_t>(row)]) EXPECT_NEAR(part[row], whole[row], 0.02f) << row;
}

TEST(ColourPlanes, ChromaOfWhatIsHiddenIsNotKnown) {
  const ColourPlanes planes({9}, {5});
  std::vector<std::uint8_t> visible(static_cast<std::size_t>(planes.samples()), 1);
  for (int i = 0; i < 9; ++i)
    for (int j = 0; i + j < 9; ++j)
      if (i < 5) visible[static_cast<std::size_t>(lattice_index(9, i, j))] = 0;
  const std::vector<std::uint8_t> known = planes.known_places(visible), guessed = planes.guessed_places(visible);
  for (int i = 0; i < 5; ++i)
    for (int j = 0; i + j < 5; ++j) {
      const auto place = static_cast<std::size_t>(planes.samples() + lattice_index(5, i, j));
      EXPECT_EQ(known[place], i >= 3) << i << ", " << j;
      EXPECT_EQ(guessed[place], i >= 2) << i << ", " << j;
    }
}

TEST(ColourPlanes, TheMeanIsThatOfWhatIsKnown) {
  const ColourPlanes planes(kSides, kHalves);
  const Eigen::Vector3f blue(0.1f, 0.2f, 0.9f);
  Eigen::VectorXf shown = colours(kSides, [&](float, float) { return blue; });
  std::vector<std::uint8_t> visible(static_cast<std::size_t>(planes.samples()), 1);
  for (int s = 0; s < planes.samples() / 2; ++s) {
    visible[static_cast<std::size_t>(s)] = 0;
    shown.segment<3>(3 * s).setConstant(7);
  }
  const Eigen::MatrixXf mean = planes.mean_colours(planes.rows_of(shown, visible), planes.known_places(visible));
  EXPECT_LT((mean - blue).norm(), 1e-5f);
}

TEST(ColourPlanes, TrianglesWhoseChromaVariesFinelyAskForAllOfIt) {
  const ColourPlanes planes(kSides, kHalves);
  std::vector<std::uint8_t> visible(static_cast<std::size_t>(planes.samples()), 1);
  EXPECT_EQ(planes.sides_for_chroma_of(colours(kSides, fine_grey), visible, 0.004f), kHalves);
  Eigen::VectorXf stripes = colours(kSides, linear);
  const ColourPlanes::Triangle& last = planes.triangles()[2];
  for (int s = 0; s < lattice_samples(last.side); ++s) stripes[3 * (last.first_sample + s)] += s % 2 ? 0.1f : -0.1f;
  EXPECT_EQ(planes.sides_for_chroma_of(stripes, visible, 0.004f), (MapSides{5, 3, 16}));
  EXPECT_EQ(planes.sides_for_chroma_of(stripes, visible, 0.2f), kHalves) << "no more than may be missed";
  visible.back() = 0;
  stripes.tail<3>().setConstant(50);
  EXPECT_EQ(planes.sides_for_chroma_of(stripes, visible, 0.004f), (MapSides{5, 3, 16})) << "by what is visible of it";
  EXPECT_EQ(planes.sides_for_chroma_of(stripes, visible, 0.2f), kHalves);
  std::fill(visible.begin() + last.first_sample, visible.end(), 0);
  EXPECT_EQ(planes.sides_for_chroma_of(stripes, visible, 0.004f), kHalves);
}

TEST(ColourPlanes, AtAChromaSampleTheColourIsWhatWasShownThere) {
  const ColourPlanes planes({9}, {5});
  const Eigen::VectorXf any = gaussian_matrix(3 * planes.samples(), 1, 11),
                        drawn = planes.colours_of(planes.rows_of(any, all_of(planes)));
  for (int i = 0; i < 9; i += 2)
    for (int j = 0; i + j < 9; j += 2) {
      const int sample = lattice_index(9, i, j);
      EXPECT_LT((drawn.segment<3>(3 * sample) - any.segment<3>(3 * sample)).norm(), 1e-5f) << i << ", " << j;
    }
  const int between = lattice_index(9, 1, 2), a = lattice_index(9, 0, 2), b = lattice_index(9, 2, 2);
  const Eigen::Vector3f chroma = opponent_colours() * drawn.segment<3>(3 * between),
                        mean = opponent_colours() * (any.segment<3>(3 * a) + any.segment<3>(3 * b)) / 2;
  EXPECT_LT((chroma - mean).tail<2>().norm(), 1e-5f);
}

}  // namespace
}  // namespace sheen
