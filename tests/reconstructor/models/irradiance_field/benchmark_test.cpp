// SPDX-License-Identifier: Apache-2.0
// Rendered scenes with published lights and held-out images (SynthRTI, Dulecha et al. 2020), beside the data only.
#include <gtest/gtest.h>

#include "common/datasets/light_list.h"
#include "common/image/color.h"
#include "common/image/image_metrics.h"
#include "reconstructor/irradiance_field_file/encode/field_encoding.h"
#include "reconstructor/models/irradiance_field/field_file.h"
#include "reconstructor/models/irradiance_field/irradiance_field.h"
#include "reconstructor/models/irradiance_field/picture_plane.h"
#include "reconstructor/radiance/radiance_image.h"
#include "tests/support/shared_data.h"

namespace sheen {
namespace {

/// Mean over the held-out lights of the PSNR of a file of at most so many bytes.
double psnr_in_bytes(const std::filesystem::path& scene, double bytes) {
  const LightList lights = load_light_list(scene / "Dome" / "dirs.lp"),
                  tests = load_light_list(scene / "Test" / "dirs.lp");
  IrradianceField model(std::make_shared<const Mesh>(picture_plane(lights.camera)), {});
  for (std::size_t i = 0; i < lights.views.size(); ++i)
    EXPECT_EQ(model.ingest(read_capture(lights, i)).status, IngestStatus::kAccepted);
  const auto small =
      std::dynamic_pointer_cast<const IrradianceFieldSnapshot>(model.snapshot()->compressed({.bytes = bytes}).snapshot);
  EXPECT_LE(static_cast<double>(encode_field(small->scene(), small->field()).size()), bytes);
  double sum = 0;
  for (std::size_t i = 0; i < tests.views.size(); ++i) {
    const Capture truth = read_capture(tests, i);
    sum += squared_error(to_srgb8(small->picture(truth.light)), to_srgb8(level_radiance(truth, 1)), {}).psnr_db();
  }
  return sum / static_cast<double>(tests.views.size());
}

/// The best published program at that size, relight's bilinear18 at quality 95, has 38.67 dB in the mean of the scenes
/// of one material and 31.76 dB of those of several. A scene of each: this one must be ahead of it by more than the
/// goal asks for in the mean.
TEST(RelightingBenchmarkTest, IsAheadOfTheBestPeerInItsBytes) {
  const auto data = shared_data("relighting") / "synthrti_object1";
  if (!std::filesystem::exists(data)) GTEST_SKIP() << "no " << data;
  EXPECT_GT(psnr_in_bytes(data / "Single/Object1/material8", 639000), 41.0);
  EXPECT_GT(psnr_in_bytes(data / "Multi/Object1/material3", 639000), 34.2);
}

}  // namespace
}  // namespace sheen
