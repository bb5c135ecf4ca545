// SPDX-License-Identifier: Apache-2.0
#include "common/simulation/simulated_rig.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <unistd.h>

#include <fstream>
#include <sstream>

#include "common/base/errors.h"
#include "common/base/files.h"
#include "common/datasets/dataset.h"
#include "common/image/exr.h"
#include "common/image/image_io.h"

namespace sheen {
namespace {

namespace fs = std::filesystem;
using testing::HasSubstr;

SimulationOptions small_rig(int frames) {
  SimulationOptions options;
  options.object = "sphere";
  options.frames = frames;
  options.width = 96;
  options.height = 72;
  options.truth = true;
  options.bake = {
      .sky_directions = 128, .bounce_directions = 64, .bounces = 1, .area_light_samples = 4, .stage_cell_m = 0.02f};
  return options;
}

const SimulatedRig& shared_rig() {
  static const SimulatedRig rig(small_rig(24));
  return rig;
}

class Recording : public testing::Test {
 protected:
  void SetUp() override {
    const auto* info = testing::UnitTest::GetInstance()->current_test_info();
    folder_ = fs::temp_directory_path() / (std::string("sheen_rig_") + info->name() + std::to_string(getpid()));
    fs::remove_all(folder_);
  }
  void TearDown() override { fs::remove_all(folder_); }
  fs::path folder_;
};

TEST(SimulatedRig, ExposesTheObjectWell) {
  const SimulatedRig& rig = shared_rig();
  std::size_t clipped = 0, object = 0;
  double sum = 0;
  for (std::size_t i = 0; i < rig.size(); i += 5) {
    const SimulatedFrame frame = rig.frame(i);
    for (std::size_t p = 0; p < frame.mask.size(); ++p) {
      const float* rgb = frame.radiance.data() + 3 * p;
      const float brightest = std::max({rgb[0], rgb[1], rgb[2]});
      if (!frame.mask.data()[p]) {
        EXPECT_LT(brightest, 1) << "paper and table stay below white";
        continue;
      }
      clipped += brightest > 1;
      sum += brightest;
      ++object;
    }
  }
  EXPECT_LT(double(clipped), 0.01 * double(object));
  EXPECT_GT(sum / double(object), 0.2);
}

TEST(SimulatedRig, RawIsTheRadianceWithNoiseOfTwoLevelsAtMost) {
  const SimulatedFrame frame = shared_rig().frame(2);
  ASSERT_EQ(validation_error(frame.raw), "");
  const ImageF clean = mosaic_rggb(frame.radiance);
  double squared = 0;
  for (std::size_t i = 0; i < clean.size(); ++i)
    squared += std::pow(frame.raw.bytes[i] - std::min(255.0f, 255 * clean.data()[i]), 2);
  const double sigma = std::sqrt(squared / double(clean.size()));
  EXPECT_GT(sigma, 0.5);
  EXPECT_LT(sigma, 2.1);
}

TEST(SimulatedRig, OnlyMovingFramesAreBlurred) {
  SimulationOptions options = small_rig(21);  // frame 20 is the first jerk
  options.width = 320;
  options.height = 240;
  const SimulatedRig rig(options);
  const auto sharpness = [&](std::size_t i) {
    const SimulatedFrame frame = rig.frame(i);
    double sum = 0;
    for (int y = 0; y < 240; ++y)
      for (int x = 0; x + 1 < 320; ++x) sum += std::pow(frame.radiance.at(x + 1, y, 1) - frame.radiance.at(x, y, 1), 2);
    return sum;
  };
  EXPECT_EQ(rig.frame(19).blur_px, 0);
  EXPECT_GT(rig.frame(20).blur_px, 5);
  EXPECT_LT(sharpness(20), 0.8 * sharpness(19));
}

TEST(SimulatedRig, RefusesSizesNoSensorHas) {
  SimulationOptions options = small_rig(1);
  options.width = 97;
  EXPECT_THROW(SimulatedRig{options}, ConfigError);
  options = small_rig(1);
  options.height = 0;
  EXPECT_THROW(SimulatedRig{options}, ConfigError);
  options = small_rig(0);
  EXPECT_THROW(SimulatedRig{options}, ConfigError);
}

TEST_F(Recording, HoldsEveryFrameAndReadsBack) {
  const RigRecording written = write_recording(shared_rig(), folder_);
  const RigRecording read = load_rig_recording(folder_);
  EXPECT_EQ(read.camera, shared_rig().camera());
  EXPECT_EQ(read.parameters_hash, written.parameters_hash);
  EXPECT_EQ(read.frame_rate_hz, 12);
  EXPECT_TRUE(read.exposure.locked);
  ASSERT_EQ(read.frames.size(), shared_rig().size());
  for (std::size_t i = 0; i < read.frames.size(); ++i) {
    const RigFrame& frame = read.frames[i];
    const Rigid3& truth = shared_rig().path()[i].camera_from_object;
    EXPECT_NEAR((frame.camera_from_object.translation - truth.translation).norm(), 0, 1e-15);
    EXPECT_NEAR(frame.camera_from_object.rotation.angularDistance(truth.rotation), 0, 1e-7);
    EXPECT_EQ(fs::file_size(frame.raw_file), 96u * 72);
  }
  const SimulatedFrame again = shared_rig().frame(3);
  const std::string raw = read_file(read.frames[3].raw_file);
  EXPECT_TRUE(std::equal(raw.begin(), raw.end(), again.raw.bytes.begin(),
                         [](char a, std::uint8_t b) { return static_cast<std::uint8_t>(a) == b; }));
  EXPECT_EQ(read_mask(folder_ / "masks" / "frame_0003.png"), again.mask);
  EXPECT_EQ(load_stage(read.stage_file()).hash(), shared_rig().stage().hash());
  EXPECT_EQ(load_mesh(read.mesh_file()).diagnosis.warnings(), std::vector<std::string>{});
  const ExrFile truth = read_exr(folder_ / "truth" / "frame_0003.exr");
  ASSERT_EQ(truth.parts.size(), 1u);
  for (std::size_t k = 0; k < again.radiance.size(); ++k)
    ASSERT_NEAR(truth.parts[0].image.data()[k], again.radiance.data()[k], 1e-3f * (0.1f + again.radiance.data()[k]));
}

TEST_F(Recording, CanBeLookedAtWhileItIsRendered) {
  const RigRecording planned = planned_recording(shared_rig(), folder_);
  int before = 0;
  const RigRecording written = write_recording(shared_rig(), folder_, [&](int done, int total) {
    EXPECT_GE(done, before);
    EXPECT_EQ(total, int(planned.frames.size()));
    for (int i = before; i < done; ++i) EXPECT_EQ(fs::file_size(planned.frames[std::size_t(i)].raw_file), 96u * 72);
    EXPECT_FALSE(fs::exists(folder_ / "rig.json"));
    before = done;
  });
  EXPECT_EQ(before, int(planned.frames.size()));
  ASSERT_EQ(written.frames.size(), planned.frames.size());
  for (std::size_t i = 0; i < planned.frames.size(); ++i) {
    EXPECT_EQ(written.frames[i].raw_file, planned.frames[i].raw_file);
    EXPECT_EQ(planned.frames[i].blur_px, shared_rig().frame(i).blur_px);
  }
}

TEST_F(Recording, IsADatasetOfItsSharpFrames) {
  const RigRecording recording = write_recording(shared_rig(), folder_);
  const Dataset dataset = load_dataset(folder_);
  EXPECT_EQ(dataset.views.size(), 23u) << "one frame of 24 is jerked";
  std::size_t held_out = 0, matched = 0;
  for (const DatasetView& view : dataset.views) {
    held_out += view.purpose == Purpose::kHeldOut;
    EXPECT_TRUE(view.mask_path);
    EXPECT_NEAR(view.camera.cx, recording.camera.cx, 1e-9);
    for (std::size_t i = 0; i < recording.frames.size(); ++i) {
      char name[64];
      std::snprintf(name, sizeof name, "images/frame_%04zu.png", i);
      if (view.name != name) continue;
      ++matched;
      EXPECT_NEAR((view.camera_from_object.translation - recording.frames[i].camera_from_object.translation).norm(), 0,
                  1e-9);
    }
  }
  EXPECT_EQ(held_out, 3u);
  EXPECT_EQ(matched, 23u);
}

TEST_F(Recording, IsRenderedOnceAndAgainWhenItMustBe) {
  SimulationOptions options = small_rig(3);
  options.truth = false;
  int calls = 0;
  const auto count = [&](int, int total) {
    ++calls;
    EXPECT_EQ(total, 3);
  };
  EXPECT_TRUE(cached_recording(options, folder_, count).rendered);
  EXPECT_EQ(calls, 3);
  EXPECT_FALSE(cached_recording(options, folder_, count).rendered);
  EXPECT_EQ(calls, 3);
  fs::resize_file(folder_ / "frames" / "frame_0001.raw", 10);
  EXPECT_TRUE(cached_recording(options, folder_, count).rendered) << "a truncated frame";
  options.seed = 2;
  EXPECT_TRUE(cached_recording(options, folder_, count).rendered) << "another seed";
  fs::remove(folder_ / "rig.json");
  EXPECT_TRUE(cached_recording(options, folder_, count).rendered) << "a render that was cut short";
}

TEST_F(Recording, ErrorsNameTheField) {
  write_recording(shared_rig(), folder_);
  const std::string good = read_file(folder_ / "rig.json");
  const auto error_after = [&](const std::string& from, const std::string& to) -> std::string {
    std::string text = good;
    const auto at = text.find(from);
    EXPECT_NE(at, std::string::npos) << from;
    text.replace(at, from.size(), to);
    std::ofstream(folder_ / "rig.json") << text;
    try {
      load_rig_recording(folder_);
    } catch (const FileError& error) {
      return error.what();
    }
    return "no error";
  };
  EXPECT_THAT(error_after("\"fx\"", "\"f\""), HasSubstr("camera.fx"));
  EXPECT_THAT(error_after("\"width\": 96", "\"width\": -96"), HasSubstr("camera.width"));
  EXPECT_THAT(error_after("BayerRG8", "Bayer"), HasSubstr("pixel_format"));
  EXPECT_THAT(error_after("\"frame_rate_hz\": 12.0", "\"frame_rate_hz\": 0"), HasSubstr("frame_rate_hz"));
  EXPECT_THAT(error_after("\"blur_px\": 0.0", "\"blur_px\": \"no\""), HasSubstr("frames[0].blur_px"));
  EXPECT_THAT(error_after("\"rotation_xyzw\": [", "\"rotation_xyzw\": [0.5,"), HasSubstr("rotation_xyzw"));
  EXPECT_THAT(error_after("\"version\": 1", "\"version\": 9"), HasSubstr("version"));
  EXPECT_THAT(error_after("{", ""), HasSubstr("rig.json"));
  EXPECT_THROW(load_rig_recording(folder_ / "absent"), FileError);
}

}  // namespace
}  // namespace sheen
