// SPDX-License-Identifier: Apache-2.0
#include "reconstructor/capture/photograph_archive.h"

#include <gtest/gtest.h>

#include <cmath>
#include <filesystem>
#include <limits>

#include "common/datasets/dataset.h"
#include "common/image/color.h"
#include "tests/reconstructor/models/surface_light_field/light_field_checks.h"
#include "tests/support/temp_folder.h"

namespace sheen {
namespace {

namespace fs = std::filesystem;

CaptureSet set_of(std::vector<Capture> captures) {
  const auto all = std::make_shared<std::vector<Capture>>(std::move(captures));
  return {.size = all->size(), .read = [all](std::size_t i) { return (*all)[i]; }, .cameras = {}, .motion = {}};
}

std::uintmax_t bytes_in(const fs::path& folder) {
  std::uintmax_t bytes = 0;
  for (const auto& entry : fs::recursive_directory_iterator(folder))
    if (entry.is_regular_file()) bytes += entry.file_size();
  return bytes;
}

class PhotographArchiveTest : public ::testing::Test {
 protected:
  /// Of a texture that changes with the direction.
  std::vector<Capture> photographs(int count) const {
    return captures(analytic::Scene{object_.surface, radiance_}, analytic::eyes(count, 0.5, 0.55));
  }
  PhotographArchive archive(std::vector<Capture> captures, int every = 8) const {
    return {set_of(std::move(captures)), object_.mesh, every};
  }

  const Object object_ = square_object();
  const analytic::Radiance radiance_ = analytic::two_terms(0.1);
  const TempFolder temp_;
  const fs::path folder_ = temp_.path() / "small";
  const SurfaceLightFieldOptions settings_;
};

TEST_F(PhotographArchiveTest, ItsCamerasSeeWhatTheScenesDo) {
  const std::vector<Capture> originals = photographs(12);
  archive(originals).write(folder_, 100);
  const Dataset dataset = load_dataset(folder_);
  ASSERT_EQ(dataset.views.size(), originals.size());
  for (std::size_t i = 0; i < originals.size(); ++i) {
    const Capture small = read_capture(dataset, i);
    EXPECT_LT(small.image.width * small.image.height, 160 * 120) << "cut to the object";
    const Eigen::Vector3d eye = camera_centre(small.pose.camera_from_object);
    EXPECT_LT((eye - camera_centre(originals[i].pose.camera_from_object)).norm(), 1e-6);
    int inside = 0;
    for (double x = -0.08; x <= 0.08; x += 0.01)
      for (double y = -0.08; y <= 0.08; y += 0.01) {
        const Eigen::Vector3d point(x, y, 0);
        const auto pixel = small.camera.project(small.pose.camera_from_object * point);
        ASSERT_TRUE(pixel);
        const Eigen::Vector2d nearest(std::round(pixel->x()), std::round(pixel->y()));
        // The truth at the pixel's own centre, on the square.
        const Rigid3 object_from_camera = small.pose.camera_from_object.inverse();
        const Eigen::Vector3d ray = object_from_camera.rotation * *small.camera.ray({nearest.x(), nearest.y()});
        const Eigen::Vector3d there = eye - eye.z() / ray.z() * ray;
        const Eigen::Vector3d truth = radiance_(there, (eye - there).normalized());
        const std::uint8_t* seen = small.image.bytes.data() +
                                   static_cast<std::size_t>(nearest.y()) * small.image.stride +
                                   3 * static_cast<std::size_t>(nearest.x());
        EXPECT_NEAR(seen[1] / 255.0, srgb_encode(static_cast<float>(truth.y())), 0.04) << i;
        ++inside;
      }
    EXPECT_EQ(inside, 17 * 17);
  }
}

TEST_F(PhotographArchiveTest, AModelOfTheBestQualityIsNearlyThatOfThePhotographsAndTheWorstIsNot) {
  const PhotographArchive archive = this->archive(photographs(48));
  ASSERT_TRUE(archive.holds_out_any());
  const double original = archive.psnr_db(settings_);
  archive.write(folder_, 100);
  EXPECT_GT(archive.psnr_db(settings_, folder_), original - 1.5) << "which is 48 dB; WebP is no more exact";
  archive.write(folder_, 0);
  EXPECT_LT(archive.psnr_db(settings_, folder_), original - 3);
}

TEST_F(PhotographArchiveTest, KeepsToItsBytesAndSaysWhatItTakes) {
  const PhotographArchive archive = this->archive(photographs(12));
  std::uintmax_t before = 0;
  for (const int quality : {20, 50, 80}) {
    const std::uintmax_t bytes = archive.write(folder_, quality) + 10;
    const int within = archive.quality_within(bytes);
    EXPECT_GE(within, quality);
    const std::uintmax_t written = archive.write(folder_, within);
    EXPECT_EQ(written, bytes_in(folder_));
    EXPECT_LE(written, bytes);
    EXPECT_GT(written, before);
    before = written;
    EXPECT_GT(archive.write(temp_.path() / "better", within + 1), bytes);
  }
  EXPECT_EQ(archive.quality_within(10), 0);
}

TEST_F(PhotographArchiveTest, ViewsThatJudgeStillDo) {
  std::vector<Capture> originals = photographs(12);
  originals[4].purpose = Purpose::kHeldOut;  // the fifth, beside every fourth
  archive(originals, 4).write(folder_, 50);
  const Dataset dataset = load_dataset(folder_);
  for (std::size_t i = 0; i < dataset.views.size(); ++i)
    EXPECT_EQ(dataset.views[i].purpose == Purpose::kHeldOut, i == 4 || (i + 1) % 4 == 0) << i;
}

TEST_F(PhotographArchiveTest, LeavesOutWhatNoModelCanUse) {
  std::vector<Capture> originals = photographs(12);
  originals[0].pose.status = PoseStatus::kNoTags;
  originals[5].pose.camera_from_object = look_at({0, 0, 0.5}, {0, 0, 1}, {0, 1, 0});
  const PhotographArchive archive = this->archive(originals);
  EXPECT_EQ(archive.size(), 10u);
  EXPECT_EQ(archive.left_out(), 2u);
  archive.write(folder_, 50);
  EXPECT_EQ(load_dataset(folder_).views[0].name, "images/0002.webp") << "they keep their numbers";
}

TEST_F(PhotographArchiveTest, WhatWasMaskedStaysMasked) {
  std::vector<Capture> originals = photographs(3);
  originals[1].mask = ImageU8(160, 120, 1, 255);
  for (int y = 0; y < 120; ++y) std::fill_n(originals[1].mask.row(y), 80, std::uint8_t{0});
  archive(originals).write(folder_, 100);
  const Dataset dataset = load_dataset(folder_);
  ASSERT_EQ(dataset.views.size(), 3u);
  const ImageU8 none = read_capture(dataset, 0).mask, half = read_capture(dataset, 1).mask;
  EXPECT_EQ(*std::min_element(none.data(), none.data() + none.size()), 255);
  // The cut-out begins left of the middle, by as many pixels as its principal point says.
  const int middle = static_cast<int>(std::lround(dataset.views[1].camera.cx + 0.5));
  for (int x = 0; x < half.width(); ++x) EXPECT_EQ(half.at(x, half.height() / 2), x < middle ? 0 : 255) << x;
}

TEST_F(PhotographArchiveTest, PixelsThatAreNoNumbersAreMasked) {
  std::vector<Capture> originals = photographs(2);
  const float nan = std::numeric_limits<float>::quiet_NaN();
  std::memcpy(originals[0].image.bytes.data() + 60 * originals[0].image.stride + 12 * 80, &nan, sizeof nan);
  archive(originals).write(folder_, 100);
  const Dataset dataset = load_dataset(folder_);
  const Capture small = read_capture(dataset, 0);
  const int x = static_cast<int>(std::lround(small.camera.cx + 0.5)),
            y = static_cast<int>(std::lround(small.camera.cy + 0.5));
  EXPECT_EQ(small.mask.at(x, y), 0);
  EXPECT_EQ(small.mask.at(x + 1, y), 255);
}

TEST_F(PhotographArchiveTest, KnownExposuresBecomeOne) {
  std::vector<Capture> originals = photographs(48), changing = originals;
  for (std::size_t i = 0; i < changing.size(); ++i) {
    Capture& capture = changing[i];
    capture.exposure = {.exposure_s = i % 3 == 1 ? 0.005 : 0.01};
    if (i % 3 != 1) continue;
    auto* values = reinterpret_cast<float*>(capture.image.bytes.data());
    for (std::size_t k = 0; k < capture.image.bytes.size() / sizeof(float); ++k) values[k] *= 0.5f;
  }
  const fs::path other = temp_.path() / "other";
  archive(originals).write(folder_, 80);
  const PhotographArchive of_changing = archive(changing);
  of_changing.write(other, 80);
  const Dataset one = load_dataset(folder_), two = load_dataset(other);
  for (std::size_t i = 0; i < originals.size(); ++i) {
    EXPECT_EQ(read_capture(one, i).image, read_capture(two, i).image) << i;
    EXPECT_TRUE(read_capture(two, i).exposure.locked);
  }
  EXPECT_NEAR(of_changing.psnr_db(settings_), archive(originals).psnr_db(settings_), 0.01);

  for (Capture& capture : changing) capture.exposure = {};  // nobody knows
  archive(changing).write(other, 80);
  EXPECT_FALSE(read_capture(load_dataset(other), 0).exposure.locked);
}

}  // namespace
}  // namespace sheen
