// SPDX-License-Identifier: Apache-2.0
// Surface maps become coarser where nothing fine is displayed, and finer where a nearer image comes.
#include "reconstructor/models/surface_light_field/map_detail.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numeric>

#include "reconstructor/surface/map_layout.h"
#include "tests/reconstructor/models/surface_light_field/light_field_checks.h"

namespace sheen {
namespace {

using analytic::eyes;
using analytic::Scene;

constexpr double kDistance = 0.5, kLowest = 0.55;

/// A map whose samples are waves of so many samples along i, by a root mean square of 1, alike in all channels.
Eigen::VectorXf wave(int side, double samples) {
  Eigen::VectorXf map(3 * lattice_samples(side));
  for (int i = 0; i < side; ++i)
    for (int j = 0; i + j < side; ++j)
      map.segment<3>(3 * lattice_index(side, i, j)).setConstant(static_cast<float>(std::cos(2 * M_PI * i / samples)));
  return map * std::sqrt(static_cast<float>(map.size())) / map.norm();
}

TEST(SufficientSides, AreHalvedAsLongAsLittleIsMissed) {
  constexpr std::uint8_t kSide = 17;
  const Eigen::MatrixXf once = Eigen::MatrixXf::Ones(1, 3);  // three views that show the same
  const auto enough = [&](double samples, float detail) {
    return sufficient_sides({kSide}, wave(kSide, samples), once, detail)[0];
  };
  EXPECT_EQ(enough(2, 0.5f), kSide) << "every second sample is another";
  EXPECT_EQ(enough(10, 0.3f), 9) << "ten samples a wave become five";
  EXPECT_EQ(enough(10, 0.01f), kSide);
  EXPECT_EQ(enough(40, 0.3f), 5);
  EXPECT_EQ(sufficient_sides({3}, wave(3, 40), once, 10)[0], 3) << "the smallest";
}

TEST(SufficientSides, WeighWhatIsDisplayedAndEachMapForItself) {
  const MapSides sides{9, 9};
  Eigen::MatrixXf basis = Eigen::MatrixXf::Zero(2 * wave(9, 2).size(), 2);
  basis.col(0).head(wave(9, 2).size()) = wave(9, 2);
  basis.col(1).tail(wave(9, 2).size()) = wave(9, 2);
  Eigen::MatrixXf displayed(2, 4);
  displayed << 1, -1, 1, -1,  // in the first map
      0.01f, 0.01f, 0, 0;     // hardly ever in the second
  EXPECT_EQ(sufficient_sides(sides, basis, displayed, 0.1f), (MapSides{9, 3}));
  EXPECT_EQ(sufficient_sides(sides, basis, displayed, 0.001f), sides);
}

TEST(ResampledMaps, HaveTheRowsOfEachMapInItsPlace) {
  const MapSides from{5, 4, 9}, to{9, 4, 5};
  const RowResampling by = resampled_maps(from, to);
  const int old_rows = 3 * (lattice_samples(5) + lattice_samples(4) + lattice_samples(9));
  EXPECT_EQ(by.rows, 3 * (lattice_samples(9) + lattice_samples(4) + lattice_samples(5)));
  ASSERT_EQ(by.between.size(), static_cast<std::size_t>(by.rows / 3));
  Eigen::MatrixXf marked(old_rows, 1);
  marked << Eigen::VectorXf::Constant(3 * lattice_samples(5), 1), Eigen::VectorXf::Constant(3 * lattice_samples(4), 2),
      Eigen::VectorXf::Constant(3 * lattice_samples(9), 3);
  const Eigen::MatrixXf rows = by.columns(marked);
  for (int s = 0; s < by.rows / 3; ++s) {
    const float map = s < lattice_samples(9) ? 1 : s < lattice_samples(9) + lattice_samples(4) ? 2 : 3;
    EXPECT_NEAR(rows(3 * s, 0), map, 1e-5f) << s;
    for (const int group : by.between[static_cast<std::size_t>(s)]) EXPECT_EQ(marked(3 * group, 0), map) << s;
  }
}

class MapDetail : public ::testing::Test {
 protected:
  static SurfaceLightFieldOptions with_detail(double detail) {
    SurfaceLightFieldOptions options = plain_options();
    options.map_detail = detail;
    return options;
  }
  static std::size_t samples(const SurfaceLightField& model) { return model.maps()->total_samples(); }

  const Object object_ = square_object();
};

TEST_F(MapDetail, WhereNothingFineIsMapsBecomeCoarserAndThePictureStays) {
  const Scene scene{object_.surface, analytic::two_terms(0.2)};
  const std::vector<Capture> images = captures(scene, eyes(30, kDistance, kLowest));
  SurfaceLightField adapted(object_.mesh, with_detail(0.1)), kept(object_.mesh, with_detail(0));
  ingest_all(adapted, images);
  ingest_all(kept, images);
  const Comparison coarse = compare(*adapted.snapshot(), scene, unseen_eyes()),
                   fine = compare(*kept.snapshot(), scene, unseen_eyes());
  std::printf("%zu of %zu samples, %.2f of %.2f dB, %.2f of %.2f MB\n", samples(adapted), samples(kept),
              coarse.psnr_db(), fine.psnr_db(), adapted.bytes() / 1e6, kept.bytes() / 1e6);
  EXPECT_LT(samples(adapted), 0.7 * samples(kept));
  EXPECT_LT(adapted.bytes(), kept.bytes());
  EXPECT_LT(coarse.rms, fine.rms + 0.5 / 255);
  EXPECT_EQ(coarse.unseen, fine.unseen);
}

TEST_F(MapDetail, AFinePrintKeepsItsMaps) {
  const Scene print{object_.surface, analytic::diffuse(0.01)};  // five pixels a wave
  const std::vector<Capture> images = captures(print, eyes(30, kDistance, kLowest));
  SurfaceLightField adapted(object_.mesh, with_detail(0.1)), kept(object_.mesh, with_detail(0));
  ingest_all(adapted, images);
  ingest_all(kept, images);
  EXPECT_EQ(samples(adapted), samples(kept));
}

TEST_F(MapDetail, TheSameImagesGiveTheSameModelToTheBit) {
  const Scene scene{object_.surface, analytic::two_terms(0.2)};
  const std::vector<Capture> images = captures(scene, eyes(24, kDistance, kLowest));
  SurfaceLightField one(object_.mesh, with_detail(0.1)), other(object_.mesh, with_detail(0.1));
  ingest_all(one, images);
  for (const Capture& image : images) {
    ingest_all(other, {image});
    other.snapshot();  // looking changes nothing
  }
  expect_same_patches(*one.snapshot(), *other.snapshot());
}

TEST_F(MapDetail, AnImageIsTakenOutOfMapsThatHaveBecomeCoarser) {
  const Scene scene{object_.surface, analytic::two_terms(0.2)};
  std::vector<Capture> images = captures(scene, eyes(30, kDistance, kLowest));
  SurfaceLightField model(object_.mesh, with_detail(0.1)), never(object_.mesh, with_detail(0.1));
  ingest_all(model, images);
  ASSERT_TRUE(model.withdraw(images[2])) << "from before maps changed";
  ASSERT_TRUE(model.withdraw(images[20])) << "and from after";
  images.erase(images.begin() + 20);
  images.erase(images.begin() + 2);
  ingest_all(never, images);
  EXPECT_LT(compare(*model.snapshot(), scene, unseen_eyes()).rms,
            1.05 * compare(*never.snapshot(), scene, unseen_eyes()).rms);
  EXPECT_LT(compare(*model.constant_colour(), scene, unseen_eyes()).rms,
            1.01 * compare(*never.constant_colour(), scene, unseen_eyes()).rms);
}

TEST_F(MapDetail, ANearerImageMakesMapsFiner) {
  const Scene print{object_.surface, analytic::diffuse(0.01)};
  std::vector<Eigen::Vector3d> far_away = eyes(8, 4 * kDistance, kLowest), near_by = eyes(24, kDistance, kLowest);
  const Camera camera = camera_at(near_by[0]);  // the same for all
  std::vector<Capture> images;
  for (const auto& from : {far_away, near_by})
    for (const Eigen::Vector3d& eye : from) {
      images.push_back(analytic::capture(print, camera, analytic::towards_origin(eye)));
      images.back().sequence = images.size();
    }
  SurfaceLightField grown(object_.mesh, with_detail(0.03)), kept(object_.mesh, with_detail(0));
  ingest_all(grown, {images.begin(), images.begin() + 8});
  const std::size_t before = samples(grown);
  ingest_all(grown, {images.begin() + 8, images.end()});
  ingest_all(kept, images);
  const Comparison sharp = compare(*grown.snapshot(), print, unseen_eyes()),
                   blurred = compare(*kept.snapshot(), print, unseen_eyes());
  std::printf("%zu samples, then %zu; %.2f dB, without %.2f dB\n", before, samples(grown), sharp.psnr_db(),
              blurred.psnr_db());
  EXPECT_GT(samples(grown), 4 * before);
  EXPECT_GT(sharp.psnr_db(), blurred.psnr_db() + 3);
  EXPECT_GT(compare(*grown.constant_colour(), print, unseen_eyes()).psnr_db(), blurred.psnr_db());
}

TEST_F(MapDetail, MapsOfAGivenSideDoNotGrow) {
  const Scene scene{object_.surface, analytic::diffuse(0.01)};
  SurfaceLightFieldOptions options = with_detail(0.03);
  options.surface_map = 6;
  SurfaceLightField model(object_.mesh, options);
  const Camera camera = camera_at({0, 0, 2});
  for (const double distance : {2.0, 0.5}) {
    Capture image = analytic::capture(scene, camera, analytic::towards_origin({0, 0, distance}));
    image.sequence = static_cast<std::uint64_t>(distance * 10);
    ingest_all(model, {image});
    EXPECT_EQ(model.maps()->resolution(0), 6);
  }
}

TEST_F(MapDetail, WhenMemoryIsShortMapsAreCoarsenedBeforeTermsAreCut) {
  const Scene scene{object_.surface, analytic::two_terms(0.1)};
  const std::vector<Capture> images = captures(scene, eyes(30, kDistance, kLowest));
  SurfaceLightField model(object_.mesh, with_detail(0.001));
  ingest_all(model, images);
  const auto ranks = model.figures().rank_histogram;
  const std::size_t before = samples(model);
  ASSERT_TRUE(model.reduce_memory());
  ASSERT_TRUE(model.reduce_memory());
  EXPECT_LT(samples(model), before);
  EXPECT_EQ(model.settings().patch.factor.max_rank, plain_options().patch.factor.max_rank);
  ASSERT_TRUE(model.reduce_memory());
  EXPECT_LT(model.settings().patch.factor.max_rank, plain_options().patch.factor.max_rank);
  ingest_all(model, captures(scene, eyes(31, kDistance, kLowest)));  // it goes on
  EXPECT_GT(compare(*model.snapshot(), scene, unseen_eyes()).psnr_db(), 28);
}

}  // namespace
}  // namespace sheen
