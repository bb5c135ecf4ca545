// SPDX-License-Identifier: Apache-2.0
// A camera that moves about a model: a folder of pictures, or a video.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <nlohmann/json.hpp>

#include "common/base/files.h"
#include "common/image/image_io.h"
#include "tests/loopback/ball_dataset.h"
#include "tests/loopback/daemons.h"
#include "tests/support/temp_folder.h"

namespace sheen::testing {
namespace {

namespace fs = std::filesystem;
using Json = nlohmann::json;

class RenderMoves : public ::testing::Test {
 protected:
  RenderMoves() {
    data_.write();
    expect_outcome(run_to_end(reconstructor({"build", data_.folder, "--mesh", data_.mesh(), "--config", data_.scene(),
                                             "--no-refine", "--out", model_, "--loss", "0dB"})),
                   0, {});
  }
  Outcome render(const Words& words) const { return run_to_end(reconstructor({"render", model_}) + words); }
  MaskedImage picture(const fs::path& folder, int number) const {
    return read_masked_image(folder / ("0000" + std::to_string(number) + ".png"));
  }
  /// RMS difference of two pictures in levels.
  double off(const fs::path& folder, int a, int b) const {
    const auto p = picture(folder, a).image.bytes, q = picture(folder, b).image.bytes;
    double squares = 0;
    for (std::size_t i = 0; i < p.size(); ++i) squares += std::pow(double(p[i]) - double(q[i]), 2);
    return std::sqrt(squares / static_cast<double>(p.size()));
  }

  const TempFolder temp_;
  const BallDataset data_{.folder = temp_.path() / "data"};
  const fs::path model_ = temp_.path() / "model", out_ = temp_.path() / "out", film_ = temp_.path() / "film.mp4";
};

TEST_F(RenderMoves, ATurntableAsPictures) {
  expect_outcome(render({"--turntable", "9", "--size", "120x90", "--out", out_}), 0, {"9 views rendered"});
  EXPECT_TRUE(fs::exists(out_ / "00009.png"));
  EXPECT_FALSE(fs::exists(out_ / "00001.exr")) << "of a film nobody asked for linear light";
  EXPECT_GT(off(out_, 1, 2), 1) << "a pattern turns";
  EXPECT_GT(off(out_, 9, 1), 1) << "the first comes again after the last, not with it";
  const ImageU8 mask = picture(out_, 1).mask;
  EXPECT_EQ(mask.at(0, 0), 0);
  EXPECT_EQ(mask.at(60, 45), 255);
  EXPECT_EQ(mask.at(60, 8), 255) << "it fills nine tenths of the picture";
  EXPECT_EQ(mask.at(60, 2), 0);
}

TEST_F(RenderMoves, AsAVideo) {
  const fs::path report = temp_.path() / "report.json";
  expect_outcome(render({"--orbit", "8", "--size", "120x90", "--fps", "10", "--out", film_, "--json", report}), 0,
                 {"film.mp4 written: 8 pictures of 120 x 90"});
  EXPECT_EQ(Json::parse(read_file(report))["video"]["frames"], 8);
  EXPECT_GT(fs::file_size(film_), 1000u);
  if (!fs::exists("/usr/bin/ffprobe")) GTEST_SKIP() << "no ffprobe here (Debian: ffmpeg)";
  const Outcome probed = run_to_end({"/usr/bin/ffprobe", "-v", "error", "-count_frames", "-show_streams", film_});
  expect_outcome(probed, 0,
                 {"codec_name=h264", "width=120", "pix_fmt=yuv420p", "color_space=bt709", "color_primaries=bt709",
                  "color_transfer=bt709", "color_range=tv", "nb_read_frames=8", "avg_frame_rate=10/1"});
}

TEST_F(RenderMoves, ThroughKeysOfAFileOrOfAPagesAddress) {
  const fs::path keys = temp_.write(
      "keys.json",
      R"({"keys": [{"eye": [0.2, 0, 0.05], "target": [0, 0, 0]}, "https://a.org/#eye=0,0.2,0.05&target=0,0,0"]})");
  expect_outcome(render({"--path", keys, "--frames", "3", "--size", "64x48", "--out", out_}), 0, {"3 views rendered"});
  EXPECT_TRUE(fs::exists(out_ / "00003.png"));
  for (const auto& [text, words] : std::vector<std::pair<std::string, Words>>{
           {"{}", {"keys.json", "\"keys\""}},
           {"[", {"keys.json", "JSON"}},
           {R"({"keys": [1, 2]})", {"keys[0]"}},
           {R"({"keys": ["#eye=1,2", "#eye=1,2,3"]})", {"keys[0]", "eye=x,y,z"}},
           {R"({"keys": [{"eye": [0,0,1], "target": [0,0,1]}, ""]})", {"keys[0]", "nowhere"}}}) {
    write_file(keys, text);
    expect_outcome(render({"--path", keys, "--out", out_}), 1, words);
  }
}

TEST_F(RenderMoves, PhotographsBesideTheirPictures) {
  const fs::path report = temp_.path() / "report.json", scores = temp_.path() / "scores.json";
  expect_outcome(render({"--compare", data_.folder, "--out", out_, "--json", report}), 0,
                 {"16 photographs", "1004.png: ", "held out", "built from"});
  expect_outcome(run_to_end(reconstructor({"evaluate", model_, data_.folder, "--json", scores})), 0, {});
  const Json pictures = Json::parse(read_file(report))["comparison"], scored = Json::parse(read_file(scores))["views"];
  EXPECT_EQ(pictures[4]["photograph"], "held out");
  EXPECT_NEAR(pictures[4]["psnr_db"].get<double>(), scored[0]["psnr_db"].get<double>(), 1e-9);
  const RawImage both = read_image(out_ / "1004.png"), photograph = read_image(data_.folder / "images/1004.png");
  ASSERT_EQ(both.width, 2 * photograph.width);
  for (int y = 0; y < photograph.height; ++y)
    for (int x = 0; x < 3 * photograph.width; ++x)
      ASSERT_EQ(both.bytes[y * both.stride + x], photograph.bytes[y * photograph.stride + x]) << "to the left";
  double squares = 0;  // of the ball's middle
  for (int y = 40; y < 80; ++y)
    for (int x = 3 * 60; x < 3 * 100; ++x)
      squares += std::pow(double(both.bytes[y * both.stride + x]) - both.bytes[y * both.stride + 3 * 160 + x], 2);
  EXPECT_LT(std::sqrt(squares / (40 * 120)), 20) << "levels";
}

TEST_F(RenderMoves, WrongUseIsTold) {
  const auto refused = [&](const Words& words, const Words& said) { expect_outcome(render(words), 2, said); };
  refused({"--turntable", "1", "--out", out_}, {"--turntable"});
  refused({"--turntable", "8", "--orbit", "8", "--out", out_}, {"--orbit"});
  refused({"--turntable", "8", "--cameras", data_.folder / "transforms.json", "--out", out_}, {"--cameras"});
  refused({"--turntable", "8", "--size", "121x90", "--out", film_}, {"121 x 90", "even"});
  refused({"--turntable", "8", "--background", "white", "--out", film_}, {"--background", "#ffffff"});
  refused({"--turntable", "8", "--demand", "--out", film_}, {"--demand"});
  refused({"--compare", data_.folder, "--out", film_}, {"--compare", "folder"});
  refused({"--frames", "8", "--turntable", "8", "--out", film_}, {"--frames"});
  EXPECT_FALSE(fs::exists(film_)) << "nothing is left of what failed";
}

}  // namespace
}  // namespace sheen::testing
