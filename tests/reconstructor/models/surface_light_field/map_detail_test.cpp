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

/// A map whose samples are waves of so many samples along i, by a root mean square of 1.
Eigen::VectorXf wave(int side, double samples) {
  Eigen::VectorXf map(lattice_samples(side));
  for (int i = 0; i < side; ++i)
    for (int j = 0; i + j < side; ++j)
      map[lattice_index(side, i, j)] = static_cast<float>(std::cos(2 * M_PI * i / samples));
  return map * std::sqrt(static_cast<float>(map.size())) / map.norm();
}

constexpr int kPlanes = 3;

TEST(SufficientSides, AreHalvedAsLongAsLittleIsMissed) {
  constexpr std::uint8_t kSide = 17;
  const Eigen::MatrixXf once = Eigen::MatrixXf::Ones(1, 3);  // three views that show the same
  const auto enough = [&](double samples, float detail) {
    return sufficient_sides({kSide}, wave(kSide, samples).replicate(kPlanes, 1), once, detail)[0];
  };
  EXPECT_EQ(enough(2, 0.5f), kSide) << "every second sample is another";
  EXPECT_EQ(enough(10, 0.3f), 9) << "ten samples a wave become five";
  EXPECT_EQ(enough(10, 0.01f), kSide);
  EXPECT_EQ(enough(40, 0.3f), 5);
  EXPECT_EQ(sufficient_sides({3}, wave(3, 40).replicate(kPlanes, 1), once, 10)[0], 3) << "the smallest";
}

TEST(SufficientSides, WeighWhatIsDisplayedAndEachMapForItself) {
  const MapSides sides{9, 9};
  const Eigen::Index rows = lattice_samples(9);
  Eigen::MatrixXf plane = Eigen::MatrixXf::Zero(2 * rows, 2);
  plane.col(0).head(rows) = wave(9, 2);
  plane.col(1).tail(rows) = wave(9, 2);
  const Eigen::MatrixXf basis = plane.replicate(kPlanes, 1);
  Eigen::MatrixXf displayed(2, 4);
  displayed << 1, -1, 1, -1,  // in the first map
      0.01f, 0.01f, 0, 0;     // hardly ever in the second
  EXPECT_EQ(sufficient_sides(sides, basis, displayed, 0.1f), (MapSides{9, 3}));
  EXPECT_EQ(sufficient_sides(sides, basis, displayed, 0.001f), sides);
}

TEST(ResampledPlanes, HaveTheRowsOfEachMapInItsPlace) {
  const ColourPlanes from({5, 4, 9}, {3, 4, 5}), to({9, 4, 5}, {9, 3, 3});
  const RowResampling by = resampled_planes(from, to);
  ASSERT_EQ(by.rows.rows(), to.rows());
  ASSERT_EQ(by.between.size(), static_cast<std::size_t>(to.rows()));
  // Each map of one colour: what is colour on the new maps is that colour, whatever rows stand for it.
  const Eigen::Vector3f colours[] = {{0.1f, 0.2f, 0.3f}, {0.9f, 0.5f, 0.1f}, {0.2f, 0.8f, 0.6f}};
  const auto marked = [&](const ColourPlanes& planes) {
    Eigen::VectorXf all(3 * planes.samples());
    for (std::size_t t = 0; t < 3; ++t) {
      const ColourPlanes::Triangle& triangle = planes.triangles()[t];
      all.segment(3 * triangle.first_sample, 3 * lattice_samples(triangle.side)) =
          colours[t].replicate(lattice_samples(triangle.side), 1);
    }
    return planes.rows_of(all, std::vector<std::uint8_t>(static_cast<std::size_t>(planes.samples()), 1));
  };
  const Eigen::VectorXf old_rows = marked(from), new_rows = marked(to), resampled = by.columns(old_rows);
  EXPECT_LT((resampled - new_rows).cwiseAbs().maxCoeff(), 1e-5f);
  for (int row = 0; row < to.rows(); ++row) {
    const int first = by.between[static_cast<std::size_t>(row)][0];
    for (const int other : by.between[static_cast<std::size_t>(row)])
      EXPECT_NEAR(old_rows[other], old_rows[first], 1e-5f) << "of the same map, row " << row;
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

/// A fine grey print: its colours vary no more finely than waves of half a metre.
analytic::Radiance grey_print() {
  return analytic::encoded([](const Eigen::Vector3d& p, const Eigen::Vector3d&) {
    const double grey = 0.1 * std::sin(2 * M_PI / 0.01 * p.x()) * std::cos(2 * M_PI / 0.01 * p.y());
    return Eigen::Vector3d(analytic::waves(p, 0.5).array() + grey);
  });
}

TEST_F(MapDetail, ChromaIsNoFinerThanTheImagesShowIt) {
  const auto bytes_and_error = [&](const analytic::Radiance& radiance, double detail) {
    const Scene scene{object_.surface, radiance};
    SurfaceLightField model(object_.mesh, with_detail(detail));
    ingest_all(model, captures(scene, eyes(30, kDistance, kLowest)));
    return std::pair(static_cast<double>(model.bytes()), compare(*model.snapshot(), scene, unseen_eyes()).rms);
  };
  // So little detail may be lost that what images display is never coarsened.
  const auto [grey, grey_error] = bytes_and_error(grey_print(), 1e-6);
  const auto [grey_full, grey_full_error] = bytes_and_error(grey_print(), 0);
  std::printf("grey print: %.2f of %.2f MB, off by %.5f, with full chroma %.5f\n", grey / 1e6, grey_full / 1e6,
              grey_error, grey_full_error);
  EXPECT_LT(grey, 0.75 * grey_full);
  EXPECT_LT(grey_error, grey_full_error + 0.1 / 255);
  const auto [coloured, error] = bytes_and_error(analytic::diffuse(0.01), 1e-6);
  const auto [full, full_error] = bytes_and_error(analytic::diffuse(0.01), 0);
  std::printf("coloured print: %.2f of %.2f MB, off by %.5f, with full chroma %.5f\n", coloured / 1e6, full / 1e6,
              error, full_error);
  EXPECT_LT(error, 1.01 * full_error);
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
