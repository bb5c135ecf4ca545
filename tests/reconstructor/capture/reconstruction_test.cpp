// SPDX-License-Identifier: Apache-2.0
#include "reconstructor/capture/reconstruction.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <optional>

#include "common/base/errors.h"
#include "common/geometry/mesh.h"
#include "common/session/session.h"
#include "reconstructor/capture/capture_set.h"
#include "tests/reconstructor/models/surface_light_field/light_field_checks.h"
#include "tests/support/expect_error.h"
#include "tests/support/expect_same_bits.h"
#include "tests/support/shared_data.h"
#include "tests/support/temp_folder.h"

namespace sheen {
namespace {

using analytic::eyes;
using analytic::Scene;

std::vector<Capture> named(std::vector<Capture> images) {
  for (std::size_t i = 0; i < images.size(); ++i) images[i].name = "image " + std::to_string(i);
  return images;
}

TEST(Reconstruction, AccountsForEveryCapture) {
  const Object object = square_object();
  const Scene scene{object.surface, analytic::diffuse(0.06)};
  std::vector<Capture> images = named(captures(scene, eyes(10, 0.5, 0.55)));
  images[0].pose.status = PoseStatus::kNoTags;
  images[4].pose.camera_from_object = look_at({0, 0, 0.5}, {0, 0, 1}, {0, 1, 0});
  images[5].pose.status = PoseStatus::kInconsistent;  // would have been held out
  SurfaceLightFieldOptions options;
  options.hold_out_every = 3;
  Reconstruction reconstruction(*object.mesh, options);
  for (const Capture& image : images) reconstruction.ingest(image);
  const FrameCounts& counts = reconstruction.account().counts();
  EXPECT_EQ(counts.received, 10u);
  EXPECT_EQ(counts.accepted, 5u);
  EXPECT_EQ(counts.held_out, 2u);
  EXPECT_EQ(counts.refused, (std::map<std::string, std::uint64_t>{{"no_pose", 2}, {"object_not_in_view", 1}}));
  ASSERT_EQ(reconstruction.held_out().size(), 2u);
  EXPECT_EQ(reconstruction.held_out()[0].name, "image 2");
  EXPECT_EQ(reconstruction.held_out()[1].name, "image 8");
  EXPECT_EQ(reconstruction.account().updates().count(), 5u);
  EXPECT_GT(reconstruction.account().images_per_s(), 0);
  for (const char* stage : {"decode", "visibility", "repetition", "exposure", "factorize"})
    EXPECT_EQ(reconstruction.account().stages().at(stage).count(), 5u) << stage;
}

TEST(Reconstruction, TheHeldOutViewsOfADiffuseSceneAreReproducedByBothModels) {
  const Object object = square_object();
  // Black, as pictures are where there is no surface: SSIM's windows look beyond the object's rim.
  const Scene scene{object.surface, analytic::diffuse(0.06), Eigen::Vector3d::Zero()};
  Reconstruction reconstruction(*object.mesh, SurfaceLightFieldOptions{});
  for (const Capture& image : captures(scene, eyes(32, 0.5, 0.55))) reconstruction.ingest(image);
  const auto [light_field, constant] = reconstruction.judge();
  ASSERT_EQ(light_field.views.size(), 4u);
  EXPECT_GT(light_field.psnr_db, 40);
  EXPECT_GT(light_field.ssim, 0.99);
  EXPECT_GT(constant.psnr_db, 40);
  EXPECT_LT(light_field.uncovered, 1e-3);
}

TEST(Reconstruction, ViewDependenceBeatsTheConstantColourByFar) {
  const Object object = square_object();
  const Scene scene{object.surface, analytic::two_terms(0.1)};
  Reconstruction reconstruction(*object.mesh, SurfaceLightFieldOptions{});
  for (const Capture& image : captures(scene, eyes(48, 0.5, 0.55))) reconstruction.ingest(image);
  const auto [light_field, constant] = reconstruction.judge();
  EXPECT_GT(light_field.psnr_db, 32);
  EXPECT_GT(light_field.psnr_db, constant.psnr_db + 10);
  EXPECT_GT(light_field.ssim, constant.ssim);
}

TEST(Reconstruction, NothingHeldOutGivesEmptyScores) {
  Reconstruction reconstruction(*square_object().mesh, SurfaceLightFieldOptions{});
  const auto [light_field, constant] = reconstruction.judge();
  EXPECT_TRUE(light_field.views.empty() && constant.views.empty());
  EXPECT_EQ(reconstruction.account().images_per_s(), 0);
}

/// Root of the mean squared error over the object's pixels of all held-out views.
double pooled_rms(Reconstruction& reconstruction) {
  return std::pow(10, -reconstruction.judge().model.psnr_pooled_db / 20);
}

TEST(Reconstruction, AnImageTakenOutOfARealCaptureLeavesTheErrorOfOneThatNeverSawIt) {
  const std::filesystem::path folder = shared_data("buddha_alicevision");
  if (!std::filesystem::exists(folder)) GTEST_SKIP() << "no shared data";
  const Mesh mesh = load_mesh(folder / "mesh_poisson_12k.ply").mesh;
  const CaptureSet set = open_capture_set(folder);
  SurfaceLightFieldOptions options;
  options.surface_map = 4;
  Reconstruction model(mesh, options), never(mesh, options);
  std::optional<Capture> hand;
  for (std::size_t i = 0; i < 40; i += 3) {
    Capture image = set.read(i);
    if (i == 24) {
      std::fill(image.image.bytes.begin(), image.image.bytes.end(), 200);
      hand = image;
    } else {
      never.ingest(image);
    }
    model.ingest(image);
  }
  const double without = pooled_rms(never), with = pooled_rms(model);
  ASSERT_EQ(model.withdraw(*hand), Reconstruction::Withdrawn::kNearly);
  const double ratio = pooled_rms(model) / without;
  std::printf("error with the image %.4f, taken out %.5f of that without\n", with / without, ratio);
  EXPECT_GT(with, 1.01 * without) << "it was worth taking out";
  EXPECT_LE(ratio, 1.005);
  EXPECT_EQ(model.account().counts().accepted, never.account().counts().accepted);
  EXPECT_EQ(model.account().counts().withdrawn, 1u);

  const std::string name = model.held_out().front().name;
  for (std::size_t i = 0; i < 40; i += 3)
    if (Capture image = set.read(i); image.name == name) {
      EXPECT_EQ(model.withdraw(image), Reconstruction::Withdrawn::kExactly);
    }
  EXPECT_EQ(model.held_out().size() + 1, never.held_out().size());
  EXPECT_EQ(model.account().counts().withdrawn, 2u);
}

TEST(SurfaceLightField, LooksAtTheRaySceneThatItWasGivenAlsoAfterImagesThatShowNothing) {
  const Object object = square_object();
  const Scene scene{object.surface, analytic::diffuse(0.06)};
  std::vector<Capture> images = captures(scene, eyes(4, 0.5, 0.8));
  for (int i = 0; i < 3; ++i) images[i].pose.camera_from_object = look_at({0, 0, 0.5}, {0, 0, 1}, {0, 1, 0});
  // A scene rebuilt of the model's own mesh would not have the lid that hides it.
  const auto lid = std::make_shared<const RayScene>(square_mesh(0.2f, 0.1f, 1));
  SurfaceLightField hidden(object.mesh, plain_options(), lid), open(object.mesh, plain_options());
  for (const Capture& image : images) {
    const IngestStatus expected = &image == &images.back() ? IngestStatus::kAccepted : IngestStatus::kRefused;
    EXPECT_EQ(open.ingest(image).status, expected);
    EXPECT_EQ(hidden.ingest(image).reason, "object_not_in_view");
  }
}

TEST(CaptureSet, ASessionGivesItsCapturesInOrderAndTheSameModelToTheBit) {
  const Object object = square_object();
  const Scene scene{object.surface, analytic::two_terms(0.1)};
  const std::vector<Capture> images = named(captures(scene, eyes(6, 0.5, 0.55)));
  const TempFolder folder;
  {
    Session session = Session::create(folder.path() / "session");
    for (const Capture& image : images) session.append(image);
  }
  const CaptureSet set = open_capture_set(folder.path() / "session");
  ASSERT_EQ(set.size, images.size());
  Reconstruction live(*object.mesh, SurfaceLightFieldOptions{}), replayed(*object.mesh, SurfaceLightFieldOptions{});
  for (std::size_t i = 0; i < images.size(); ++i) {
    const Capture read = set.read(i);
    testing::expect_same_bits(read, images[i]);
    live.ingest(images[i]);
    replayed.ingest(read);
  }
  expect_same_patches(*live.snapshot(), *replayed.snapshot());
}

TEST(CaptureSet, WhatIsNoCaptureSetIsNamed) {
  const TempFolder folder;
  expect_error([&] { open_capture_set(folder.path()); }, {folder.path().string()});
  expect_error([&] { open_capture_set(folder.path() / "absent"); }, {"absent"});
  folder.write("transforms.json", "{\"frames\": [");
  expect_error([&] { open_capture_set(folder.path()); }, {"transforms.json"});
}

}  // namespace
}  // namespace sheen
