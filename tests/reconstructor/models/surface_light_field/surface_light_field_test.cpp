// SPDX-License-Identifier: Apache-2.0
#include "reconstructor/models/surface_light_field/surface_light_field.h"

#include <gtest/gtest.h>
#include <tbb/global_control.h>

#include <algorithm>
#include <random>

#include "common/image/color.h"
#include "common/image/linear_reader.h"
#include "reconstructor/models/surface_light_field/files/model_files.h"
#include "tests/reconstructor/models/surface_light_field/light_field_checks.h"
#include "tests/support/expect_error.h"
#include "tests/support/temp_folder.h"

namespace sheen {
namespace {

using analytic::eyes;
using analytic::Scene;

constexpr double kDistance = 0.5, kLowest = 0.55;

std::vector<Eigen::Vector3d> training_eyes(int count = 24) {
  return eyes(count, kDistance, kLowest);
}
/// Elsewhere than the training eyes, and inside what they span.
TEST(SurfaceLightField, ADiffuseSquareHasRankOneAndIsReproduced) {
  const Object object = square_object();
  const Scene scene{object.surface, analytic::diffuse(0.06)};
  SurfaceLightField model(object.mesh, plain_options());
  ingest_all(model, captures(scene, training_eyes()));
  EXPECT_EQ(share_of_rank_up_to(model, 1), 1.0);
  const Comparison result = compare(*model.snapshot(), scene, unseen_eyes());
  EXPECT_GT(result.psnr_db(), 45);
  EXPECT_GT(result.pixels, 15'000u);
  EXPECT_EQ(result.unseen, 0u);
  EXPECT_EQ(model.figures().images, 24u);
}

TEST(SurfaceLightField, ADiffuseSphereHasRankOneAndIsReproduced) {
  const Object object = sphere_object();
  const Scene scene{object.surface, analytic::diffuse(0.08)};
  SurfaceLightField model(object.mesh, plain_options());
  ingest_all(model, captures(scene, training_eyes(30)));
  EXPECT_GT(share_of_rank_up_to(model, 1), 0.9);
  EXPECT_GT(compare(*model.snapshot(), scene, unseen_eyes()).psnr_db(), 40);
}

TEST(SurfaceLightField, ItsAverageLookIsTheMeanOfAllViews) {
  const Object object = square_object();
  const Scene scene{object.surface, analytic::two_terms(0.2)};
  SurfaceLightField model(object.mesh, plain_options());
  ingest_all(model, captures(scene, training_eyes()));
  const auto snapshot = model.snapshot();
  const auto look = snapshot->average_look();
  for (std::uint32_t t = 0; t < object.mesh->triangles.size(); ++t) {
    const Eigen::Vector3d place =
        (object.mesh->corner(t, 0) + object.mesh->corner(t, 1) + object.mesh->corner(t, 2)).cast<double>() / 3;
    Eigen::Vector3d mean = Eigen::Vector3d::Zero();
    for (const Eigen::Vector3d& eye : training_eyes())
      mean += scene.radiance(place, (eye - place).normalized()).unaryExpr([](double v) {
        return double{srgb_encode(static_cast<float>(v))};
      });
    mean /= static_cast<double>(training_eyes().size());
    const Eigen::Vector3f shown = look->shader->shade(t, 1 / 3.0f, 1 / 3.0f).rgb;
    for (int c = 0; c < 3; ++c) EXPECT_NEAR(srgb_encode(shown[c]), mean[c], 3.0 / 255) << t << " " << c;
  }
}

TEST(SurfaceLightField, APrintOnTwoLargeTrianglesIsNotBlurred) {
  const Object two{std::make_shared<Mesh>(square_mesh(0.1f, 0, 1)), analytic::square(0.1, 0)};
  const Scene print{two.surface, analytic::diffuse(0.02)};  // waves of ten pixels, on edges of a hundred and more
  SurfaceLightField model(two.mesh, plain_options());
  ingest_all(model, captures(print, training_eyes()));
  EXPECT_GT(compare(*model.snapshot(), print, unseen_eyes()).psnr_db(), 30);
}

TEST(SurfaceLightField, TwoTermsOfViewDependenceAreRecovered) {
  const Object object = square_object();
  const Scene scene{object.surface, analytic::two_terms(0.2)};
  constexpr double kFarAway = 8;  // where a direction is the same all over a patch
  SurfaceLightField model(object.mesh, plain_options());
  ingest_all(model, captures(scene, eyes(40, kFarAway, kLowest)));
  // Patches at the square's rim hold samples that some views lack and that were completed: they may need more.
  const auto snapshot = model.light_field_snapshot();
  for (std::size_t p = 0; p < snapshot->patches().size(); ++p) {
    const auto& vertices = snapshot->shapes().patches[p].vertices;
    const bool inside = std::all_of(vertices.begin(), vertices.end(), [](std::uint32_t v) {
      const std::uint32_t i = v % 9, j = v / 9;
      return std::min({i, j, 8 - i, 8 - j}) >= 1;
    });
    if (inside)
      EXPECT_EQ(snapshot->patches()[p]->rank(), 2) << "patch " << p;
    else
      EXPECT_GE(snapshot->patches()[p]->rank(), 2);
  }
  const std::vector<Eigen::Vector3d> from = eyes(5, kFarAway, kLowest + 0.08, 0.95);
  const Comparison light_field = compare(*model.snapshot(), scene, from);
  const Comparison constant = compare(*model.constant_colour(), scene, from);
  EXPECT_GT(light_field.psnr_db(), 38);
  EXPECT_LT(constant.psnr_db(), 24);
}

TEST(SurfaceLightField, TheConstantColourIsTheMeanOfWhatWasShown) {
  const Object object = square_object();
  const auto level = [](double x) { return 0.5 + 0.3 * x; };
  const Scene scene{object.surface, analytic::encoded([&](const Eigen::Vector3d& p, const Eigen::Vector3d& d) {
                      return Eigen::Vector3d::Constant(level((kDistance * d + p).x() / kDistance));  // by the eye alone
                    })};
  const std::vector<Eigen::Vector3d> from = training_eyes(9);
  SurfaceLightField model(object.mesh, plain_options());
  ingest_all(model, captures(scene, from));
  const auto snapshot = model.constant_colour();
  const auto shader = snapshot->shader_for({{0, 0, 1}});
  double mean = 0;
  for (const Eigen::Vector3d& eye : from) mean += level(eye.x() / kDistance) / 9;
  const std::uint32_t middle = 2 * (4 * 8 + 4);  // at the origin, where distance to the eye is exact
  const SurfaceSample sample = shader->shade(middle, 0, 0);
  EXPECT_EQ(sample.state, SampleState::kMeasured);
  for (int c = 0; c < 3; ++c) EXPECT_NEAR(srgb_encode(sample.rgb[c]), mean, 2e-3);
}

TEST(SurfaceLightField, TheOrderOfTheImagesHardlyMatters) {
  const Object object = square_object();
  const Scene scene{object.surface, analytic::two_terms(0.06)};
  std::vector<Capture> images = captures(scene, training_eyes(30));
  for (int order = 0; order < 3; ++order) {
    SurfaceLightField model(object.mesh, plain_options());
    ingest_all(model, images);
    EXPECT_GT(compare(*model.snapshot(), scene, unseen_eyes()).psnr_db(), 36) << "order " << order;
    std::shuffle(images.begin(), images.end(), std::mt19937(order));
  }
}

TEST(SurfaceLightField, TheSameImagesInTheSameOrderGiveTheSameBitsOnAnyNumberOfThreads) {
  const Object object = sphere_object();
  const Scene scene{object.surface, analytic::two_terms(0.08)};
  const std::vector<Capture> images = captures(scene, training_eyes(16));
  std::vector<std::shared_ptr<const SurfaceLightFieldSnapshot>> results;
  for (const std::size_t threads : {1, 4, 2, 4}) {
    const tbb::global_control limit(tbb::global_control::max_allowed_parallelism, threads);
    SurfaceLightField model(object.mesh, plain_options());
    for (std::size_t i = 0; i < images.size(); ++i) {
      ASSERT_EQ(model.ingest(images[i]).status, IngestStatus::kAccepted);
      if (threads == 2 && i % 3 == 0) model.snapshot();  // looking on changes nothing
    }
    results.push_back(model.light_field_snapshot());
  }
  for (std::size_t i = 1; i < results.size(); ++i) expect_same_patches(*results[0], *results[i]);
}

TEST(SurfaceLightField, SnapshotsDoNotChangeAndShareWhatStayedTheSame) {
  const Object object = sphere_object();
  const Scene scene{object.surface, analytic::diffuse(0.08)};
  const std::vector<Capture> images = captures(scene, {{0.5, 0, 0}, {0.49, 0.1, 0}, {-0.5, 0, 0}});
  SurfaceLightField model(object.mesh, plain_options());
  ingest_all(model, {images[0], images[1]});
  const auto before = model.light_field_snapshot();
  const SurfaceLightFieldSnapshot::Patches kept = before->patches();
  const Eigen::MatrixXf coefficients = before->coefficients_for({0.5, 0.05, 0});
  ingest_all(model, {images[2]});
  const auto after = model.light_field_snapshot();
  EXPECT_GT(after->version(), before->version());
  EXPECT_EQ(before->coefficients_for({0.5, 0.05, 0}), coefficients);
  for (std::size_t p = 0; p < kept.size(); ++p) {
    const float x = object.mesh->vertices[before->shapes().patches[p].vertices.front()].x();
    if (x > 0.04f) EXPECT_EQ(after->patches()[p], kept[p]) << "the third image does not reach this patch";
    if (x < -0.06f) EXPECT_TRUE(!kept[p] && after->patches()[p]);
  }
}

TEST(SurfaceLightField, PatchesThatTheSameImagesShowShareTheirViewsAtAVertexAndWhenReopened) {
  const Object object = square_object();
  SurfaceLightField model(object.mesh, plain_options());
  ingest_all(model, captures({object.surface, analytic::two_terms(0.2)}, training_eyes(12)));
  const TempFolder folder;
  const auto grown = model.light_field_snapshot();
  save_model(*grown, folder.path(), {});
  for (const auto& snapshot : {grown, load_model(folder.path())}) {
    const PatchShapes& shapes = snapshot->shapes();
    const Eigen::Vector3d eye(0.1, 0.05, 0.5);
    const Eigen::MatrixXf together = snapshot->coefficients_for(eye);
    for (std::size_t v = 0; v < object.mesh->vertices.size(); ++v) {
      const VertexInterpolant* first = nullptr;
      for (const auto& [p, i] : shapes.round(v)) {
        const VertexInterpolant& at = snapshot->patches()[p]->vertices[i];
        if (!first) first = &at;
        EXPECT_EQ(at.views, first->views) << "vertex " << v;
        const Eigen::VectorXf alone = at.coefficients((eye.cast<float>() - object.mesh->vertices[v]).normalized());
        EXPECT_LE((together.col(shapes.first_column[p] + i).head(alone.size()) - alone).norm(), 1e-6 * alone.norm());
      }
    }
  }
}

TEST(SurfaceLightField, FinishedItIsWhatItWasAndTakesNoImage) {
  const Object object = sphere_object();
  const Scene scene{object.surface, analytic::two_terms(0.1)};
  const std::vector<Capture> images = captures(scene, eyes(21, 0.5, 0.2));
  SurfaceLightField model(object.mesh, plain_options()), goes_on(object.mesh, plain_options());
  model.finish();  // before any image there is nothing to finish
  ingest_all(model, images);
  ingest_all(goes_on, images);
  const ModelFigures figures = model.figures();
  const double counted = model.memory({}).total();
  model.finish();
  expect_same_patches(*model.snapshot(), *goes_on.snapshot());
  EXPECT_EQ(model.snapshot(), model.snapshot());
  EXPECT_EQ(model.figures().images, figures.images);
  EXPECT_EQ(model.figures().bytes, figures.bytes);
  EXPECT_EQ(model.figures().rank_histogram, figures.rank_histogram);
  EXPECT_EQ(model.memory({}).total(), counted);
  EXPECT_THROW(model.ingest(images[0]), std::logic_error);
  EXPECT_FALSE(model.withdraw(images[3]));

  std::weak_ptr<const ModelSnapshot> kept = model.snapshot();
  model.give_snapshot();
  EXPECT_TRUE(kept.expired()) << "who is given it has it alone";
  EXPECT_THROW(model.snapshot(), std::logic_error);
  EXPECT_EQ(model.figures().bytes, figures.bytes);
}

TEST(SurfaceLightField, AnImageThatComesAgainAndAgainAddsNothing) {
  const Object object = square_object();
  const Scene scene{object.surface, analytic::two_terms(0.06)};
  const Eigen::Vector3d eye(0.1, 0.05, 0.45);
  const std::vector<Capture> once = captures(scene, {eye});
  SurfaceLightField model(object.mesh, plain_options());
  ingest_all(model, once);
  const Comparison first = compare(*model.snapshot(), scene, {eye});
  for (int i = 0; i < 30; ++i) {
    const IngestReport report = model.ingest(once[0]);
    ASSERT_EQ(report.status, IngestStatus::kAccepted);
    EXPECT_LT(report.relative_residual, 1e-5);
  }
  EXPECT_EQ(share_of_rank_up_to(model, 1), 1.0);
  const Comparison last = compare(*model.snapshot(), scene, {eye});
  EXPECT_NEAR(last.rms, first.rms, 1e-4);
  EXPECT_LT(last.rms, 3e-3);
}

TEST(SurfaceLightField, RefusedImagesSayWhyAndChangeNothing) {
  const Object object = square_object();
  const Scene scene{object.surface, analytic::two_terms(0.06)};
  const std::vector<Capture> images = captures(scene, training_eyes(6));
  SurfaceLightField model(object.mesh, plain_options());
  ingest_all(model, images);
  const auto before = model.light_field_snapshot();
  const auto expect_refused = [&](const Capture& capture, const std::string& reason) {
    const IngestReport report = model.ingest(capture);
    EXPECT_EQ(report.status, IngestStatus::kRefused);
    EXPECT_EQ(report.reason, reason);
    EXPECT_EQ(report.patches_updated, 0u);
  };
  for (const PoseStatus status :
       {PoseStatus::kUnspecified, PoseStatus::kNoTags, PoseStatus::kTooFewTags, PoseStatus::kInconsistent}) {
    Capture lost = images[0];
    lost.pose.status = status;
    expect_refused(lost, "no_pose");
  }
  Capture broken_pose = images[0];
  broken_pose.pose.camera_from_object.translation.y() = std::nan("");
  expect_refused(broken_pose, "no_pose");
  Capture other_size = images[0];
  other_size.camera = other_size.camera.scaled(80, 60);
  expect_refused(other_size, "image_size");
  Capture short_image = images[0];
  short_image.image.bytes.resize(short_image.image.bytes.size() - 1);
  expect_refused(short_image, "image_size");
  Capture other_mask = images[0];
  other_mask.mask = ImageU8(159, 120, 1, 255);
  expect_refused(other_mask, "image_size");
  Capture away = images[0];
  away.pose.camera_from_object = look_at({0, 0, 0.5}, {0, 0, 1}, {0, 1, 0});
  expect_refused(away, "object_not_in_view");
  Capture from_below = images[0];
  from_below.pose.camera_from_object = look_at({0.1, 0, -0.5}, {0, 0, 0}, {0, 1, 0});
  expect_refused(from_below, "object_not_in_view");
  Capture masked = images[0];
  masked.mask = ImageU8(160, 120, 1, 0);
  expect_refused(masked, "object_not_in_view");
  Capture blind = images[0];
  blind.image = analytic::float_image(ImageF(160, 120, 3, std::nanf("")));
  expect_refused(blind, "object_not_in_view");

  EXPECT_EQ(model.figures().images, 6u);
  expect_same_patches(*before, *model.light_field_snapshot());
}

TEST(SurfaceLightField, ARefusedFirstImageDoesNotDecideTheResolution) {
  const Object object = square_object();
  const Scene scene{object.surface, analytic::diffuse(0.06)};
  const std::vector<Capture> images = captures(scene, training_eyes(3));
  Capture far_away = images[0];
  far_away.pose.camera_from_object = look_at({0, 0, 50}, {0, 0, 100}, {0, 1, 0});
  SurfaceLightField model(object.mesh, plain_options()), reference(object.mesh, plain_options());
  EXPECT_EQ(model.ingest(far_away).reason, "object_not_in_view");
  ingest_all(model, images);
  ingest_all(reference, images);
  expect_same_patches(*model.light_field_snapshot(), *reference.light_field_snapshot());
}

TEST(SurfaceLightField, TheMapsHaveASampleAPixelUnlessTheSceneSaysOtherwise) {
  const Object object = square_object();
  const Scene scene{object.surface, analytic::diffuse(0.06)};
  const std::vector<Capture> images = captures(scene, {{0, 0, 0.5}});
  SurfaceLightField model(object.mesh, plain_options());
  ingest_all(model, images);
  // 0.025 m cells at 500 px a metre: the diagonal has 17.7 pixels.
  EXPECT_EQ(model.light_field_snapshot()->maps().resolution(0), 19);
  SurfaceLightFieldOptions fixed = plain_options();
  fixed.surface_map = 6;
  SurfaceLightField coarse(object.mesh, fixed);
  ingest_all(coarse, images);
  for (std::size_t t = 0; t < object.mesh->triangles.size(); ++t)
    EXPECT_EQ(coarse.light_field_snapshot()->maps().resolution(t), 6);
}

TEST(SurfaceLightField, PixelsThatAreNoNumbersAreAsIfNotThere) {
  const Object object = square_object();
  const Scene scene{object.surface, analytic::diffuse(0.06)};
  std::vector<Capture> images = captures(scene, training_eyes(12));
  std::mt19937 engine(3);
  for (Capture& image : images) {
    ImageF pixels = to_linear_rgb(image.image);
    for (int k = 0; k < 150; ++k)
      pixels.data()[engine() % pixels.size()] = k % 2 ? std::nanf("") : std::numeric_limits<float>::infinity();
    image.image = analytic::float_image(pixels);
  }
  SurfaceLightField model(object.mesh, plain_options());
  ingest_all(model, images);
  const Comparison result = compare(*model.snapshot(), scene, unseen_eyes());
  EXPECT_GT(result.psnr_db(), 40);
  EXPECT_LT(result.worst, 0.05) << "no dark spot where a pixel was broken";
}

TEST(SurfaceLightField, ViewsBeyondTheBoundAreMergedAndMemoryStaysWhereItIs) {
  const Object object = square_object();
  const Scene scene{object.surface, analytic::two_terms(0.06)};
  SurfaceLightFieldOptions options = plain_options();
  options.patch.max_views = 8;
  SurfaceLightField model(object.mesh, options);
  const std::vector<Capture> images = captures(scene, training_eyes(60));
  ingest_all(model, images);
  const std::size_t bytes = model.bytes();
  EXPECT_GT(bytes, 0u);
  ingest_all(model, images);
  EXPECT_LE(model.bytes(), bytes + bytes / 100);
  const auto snapshot = model.light_field_snapshot();
  for (const auto& patch : snapshot->patches()) {
    ASSERT_TRUE(patch);
    for (const VertexInterpolant& vertex : patch->vertices) {
      EXPECT_EQ(vertex.views->directions.cols(), 8);
      EXPECT_EQ(vertex.weights.rows(), 8);
      EXPECT_GT(vertex.views_folded, 100);
      for (Eigen::Index j = 0; j < 8; ++j) EXPECT_NEAR(vertex.views->directions.col(j).norm(), 1, 1e-5);
    }
  }
  const double thinned = compare(*snapshot, scene, unseen_eyes()).psnr_db();
  EXPECT_GT(thinned, 28) << "eight directions still tell a slope";
  EXPECT_GT(thinned, compare(*model.constant_colour(), scene, unseen_eyes()).psnr_db() + 6);
}

TEST(SurfaceLightField, EveryNthImageIsHeldOutAndTeachesNothing) {
  const Object object = square_object();
  const Scene scene{object.surface, analytic::diffuse(0.06)};
  std::vector<Capture> images = captures(scene, training_eyes(12));
  SurfaceLightFieldOptions options = plain_options();
  options.hold_out_every = 4;
  SurfaceLightField model(object.mesh, options), reference(object.mesh, plain_options());
  for (int i = 0; i < 12; ++i) {
    if (i == 1 || i == 6) continue;  // one that is missing does not change what becomes of the others
    const IngestStatus status = model.ingest(images[i]).status;
    EXPECT_EQ(status, (i + 1) % 4 == 0 ? IngestStatus::kHeldOut : IngestStatus::kAccepted) << i;
    if (status == IngestStatus::kAccepted) reference.ingest(images[i]);
  }
  EXPECT_EQ(model.figures().images, 7u);
  expect_same_patches(*model.light_field_snapshot(), *reference.light_field_snapshot());
}

TEST(SurfaceLightField, ThePurposeOfAnImageIsHonoured) {
  const Object object = square_object();
  const Scene scene{object.surface, analytic::diffuse(0.06)};
  std::vector<Capture> images = captures(scene, training_eyes(6));
  SurfaceLightFieldOptions options = plain_options();
  options.hold_out_every = 2;
  SurfaceLightField model(object.mesh, options);
  for (Capture& image : images) {
    image.purpose = Purpose::kTraining;
    EXPECT_EQ(model.ingest(image).status, IngestStatus::kAccepted);
  }
  for (Capture& image : images) {
    image.purpose = Purpose::kHeldOut;
    EXPECT_EQ(model.ingest(image).status, IngestStatus::kHeldOut);
  }
  EXPECT_EQ(model.figures().images, 6u);
}

TEST(SurfaceLightField, BeforeTheFirstImageEverythingIsUnseen) {
  const Object object = sphere_object();
  SurfaceLightField model(object.mesh, plain_options());
  for (const std::shared_ptr<const Appearance>& snapshot :
       {std::shared_ptr<const Appearance>(model.snapshot()), model.constant_colour()}) {
    const auto shader = snapshot->shader_for({{0, 0, 1}});
    for (std::uint32_t t = 0; t < object.mesh->triangles.size(); ++t)
      EXPECT_EQ(shader->shade(t, 0.3f, 0.3f).state, SampleState::kUnseen);
  }
  EXPECT_EQ(model.light_field_snapshot()->max_rank(), 0);
  EXPECT_TRUE(model.figures().rank_histogram.empty());
  EXPECT_EQ(model.figures().bytes_per_patch, 0);
}

TEST(SurfaceLightField, OptionsOutOfRangeAreNamed) {
  const Object object = square_object();
  const auto expect_named = [&](auto change, const std::string& name) {
    SurfaceLightFieldOptions options;
    change(options);
    expect_error<ConfigError>([&] { SurfaceLightField(object.mesh, options); }, {name});
  };
  expect_named([](auto& o) { o.surface_map = 1; }, "surface_map");
  expect_named([](auto& o) { o.surface_map = 65; }, "surface_map");
  expect_named([](auto& o) { o.hold_out_every = 1; }, "hold_out_every");
  expect_named([](auto& o) { o.hold_out_every = -2; }, "hold_out_every");
  expect_named([](auto& o) { o.patch.factor.max_rank = 0; }, "max_rank");
  expect_named([](auto& o) { o.patch.factor.tolerance = 1; }, "tolerance");
  expect_named([](auto& o) { o.patch.factor.tolerance = std::nan(""); }, "tolerance");
  expect_named([](auto& o) { o.patch.max_views = 7; }, "max_views");
  expect_named([](auto& o) { o.patch.min_visible = 1.5; }, "min_visible");
  expect_named([](auto& o) { o.patch.min_visible = std::nan(""); }, "min_visible");
  expect_named([](auto& o) { o.visibility.erosion_px = -1; }, "erosion_px");
}

TEST(SurfaceLightFieldSnapshot, FiguresCountWhatImagesShowed) {
  auto mesh = std::make_shared<Mesh>();
  mesh->vertices = {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {1, 1, 0}, {2, 1, 0}};
  mesh->triangles = {{0, 1, 2}, {2, 1, 3}, {1, 4, 3}};
  const auto maps = std::make_shared<MapLayout>(std::vector<std::uint8_t>{2, 3, 3});
  const auto shapes = std::make_shared<const PatchShapes>(cut_into_patches(*mesh, *maps, {.triangles = 1}));
  SurfaceLightFieldSnapshot::Patches data(3);
  const auto patch = [&](std::size_t p, int rank, std::size_t measured) {
    auto made = std::make_shared<PatchSnapshot>();
    made->basis = Eigen::MatrixXf(Eigen::MatrixXf::Zero(3 * shapes->patches[p].samples, rank));
    made->shown.assign(shapes->patches[p].samples, 0);
    std::fill_n(made->shown.begin(), measured, 255);
    if (measured == 2) made->shown[0] = 100;
    data[p] = made;
  };
  patch(0, 2, 3);  // all of its 3 samples
  patch(1, 5, 2);  // of 6
  patch(2, 9, 0);  // a guess: counts for nothing
  const SnapshotFigures figures = SurfaceLightFieldSnapshot(mesh, maps, shapes, data, 1).figures();
  EXPECT_DOUBLE_EQ(figures.median_rank, 3.5);
  EXPECT_EQ(figures.most_rank, 5);
  EXPECT_DOUBLE_EQ(figures.seen, 5.0 / 15);
  EXPECT_DOUBLE_EQ(figures.measured, 4.0 / 15) << "one is imputed";
}

}  // namespace
}  // namespace sheen
