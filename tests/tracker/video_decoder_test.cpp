// SPDX-License-Identifier: Apache-2.0
// Video files that the test writes and whose headers it then changes, as a phone would have written them.
#include "tracker/sources/video_decoder.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <fstream>
#include <functional>
#include <opencv2/core.hpp>
#include <opencv2/videoio.hpp>

#include "common/base/files.h"
#include "tests/support/temp_folder.h"
#include "tracker/sources/video_source.h"

namespace sheen {
namespace {

using ::testing::HasSubstr;

constexpr int kWidth = 192, kHeight = 128;

std::string big_endian(std::uint32_t value) {
  return {char(value >> 24), char(value >> 16), char(value >> 8), char(value)};
}

void grow(std::string& file, std::size_t type_at, std::uint32_t bytes) {
  std::uint32_t size = 0;
  for (std::size_t i = type_at - 4; i < type_at; ++i) size = size << 8 | std::uint8_t(file[i]);
  file.replace(type_at - 4, 4, big_endian(size + bytes));
}

/// Four quarters of different grey: 40 and 100 above, 160 and 220 below.
cv::Mat quarters() {
  cv::Mat bgr(kHeight, kWidth, CV_8UC3);
  for (int y = 0; y < kHeight; ++y)
    for (int x = 0; x < kWidth; ++x)
      bgr.at<cv::Vec3b>(y, x) = cv::Vec3b::all(40 + 60 * (x >= kWidth / 2) + 120 * (y >= kHeight / 2));
  return bgr;
}

class DecodedVideo : public ::testing::Test {
 protected:
  std::string write(const cv::Mat& picture) {
    const std::string file = (temp_.path() / "phone.mp4").string();
    cv::VideoWriter video(file, cv::VideoWriter::fourcc('m', 'p', '4', 'v'), 25, picture.size());
    EXPECT_TRUE(video.isOpened());
    for (int i = 0; i < 3; ++i) video.write(picture);
    return file;
  }
  /// Writes the matrix of the track's header: x' = a x + c y, y' = b x + d y.
  void turn(const std::string& name, double a, double b, double c, double d) {
    std::string file = read_file(name);
    const std::size_t matrix = file.rfind("tkhd") + 44;
    const auto fixed = [](double value) { return big_endian(std::uint32_t(std::int32_t(std::lround(value * 65536)))); };
    file.replace(matrix, 8, fixed(a) + fixed(b));
    file.replace(matrix + 12, 8, fixed(c) + fixed(d));
    std::ofstream(name, std::ios::binary) << file;
  }
  /// Adds a `colr` box with these numbers of ITU-T H.273 to the track's description.
  void colour(const std::string& name, int primaries, int transfer, int matrix) {
    std::string file = read_file(name);
    const std::string box =
        big_endian(19) + "colrnclx" + std::string{0, char(primaries), 0, char(transfer), 0, char(matrix), 0};
    const std::size_t entry = file.rfind("mp4v"), size_at = entry - 4;
    std::uint32_t size = 0;
    for (std::size_t i = size_at; i < entry; ++i) size = size << 8 | std::uint8_t(file[i]);
    file.insert(size_at + size, box);
    for (const char* type : {"moov", "trak", "mdia", "minf", "stbl", "stsd", "mp4v"})
      grow(file, file.rfind(type), static_cast<std::uint32_t>(box.size()));
    std::ofstream(name, std::ios::binary) << file;
  }
  static int grey_at(const RawImage& image, double x, double y) {
    return image.bytes[std::size_t(y * image.height) * image.stride + 3 * std::size_t(x * image.width)];
  }
  const TempFolder temp_;
};

TEST_F(DecodedVideo, IsTurnedAsItsFileSays) {
  struct Case {
    const char* name;
    double a, b, c, d;
    int width;
    int quarters[4];  ///< upper left, upper right, lower left, lower right, as they are shown
  };
  for (const Case& c : {Case{"as stored", 1, 0, 0, 1, kWidth, {40, 100, 160, 220}},
                        {"clockwise by 90", 0, 1, -1, 0, kHeight, {160, 40, 220, 100}},
                        {"by 180", -1, 0, 0, -1, kWidth, {220, 160, 100, 40}},
                        {"clockwise by 270", 0, -1, 1, 0, kHeight, {100, 220, 40, 160}},
                        {"mirrored", -1, 0, 0, 1, kWidth, {100, 40, 220, 160}},
                        {"transposed", 0, 1, 1, 0, kHeight, {40, 160, 100, 220}}}) {
    SCOPED_TRACE(c.name);
    const std::string file = write(quarters());
    turn(file, c.a, c.b, c.c, c.d);
    VideoDecoder video(file);
    EXPECT_EQ(video.width(), c.width);
    EXPECT_EQ(video.height(), kWidth + kHeight - c.width);
    EXPECT_EQ(video.warning(), "");
    EXPECT_TRUE(video.lossy());
    const auto picture = video.next();
    ASSERT_TRUE(picture);
    EXPECT_EQ(validation_error(picture->image), "");
    EXPECT_EQ(picture->image.width, c.width);
    const double quarter[4][2] = {{0.25, 0.25}, {0.75, 0.25}, {0.25, 0.75}, {0.75, 0.75}};
    for (int i = 0; i < 4; ++i)
      EXPECT_NEAR(grey_at(picture->image, quarter[i][0], quarter[i][1]), c.quarters[i], 4) << i;
  }
}

TEST_F(DecodedVideo, AtAnOddAngleIsNamed) {
  const std::string file = write(quarters());
  turn(file, 0.966, 0.259, -0.259, 0.966);
  const auto source = open_video(file, {});
  EXPECT_THAT(source->remarks(), HasSubstr("no multiple of 90 degrees"));
  ASSERT_TRUE(source->next(std::chrono::milliseconds(0)));
}

double srgb(double light) {
  return light >= 1 ? 255 : 255 * (1.055 * std::pow(light, 1 / 2.4) - 0.055);
}

/// By the standards' formulas, of the level that the same file has without its header's numbers: the encoder is lossy.
/// HLG: a signal up to 1/2 is the root of 3 times scene light, reference white is a light of 0.265. PQ: a signal of
/// 0.440 is 50 cd/m2, of 0.508 100 cd/m2, reference white 203.
TEST_F(DecodedVideo, OfHighDynamicRangeIsBroughtToLightAndSaysSo) {
  struct Case {
    int transfer;
    const char* name;
    double signal;
    std::function<double(double)> light;
  };
  const auto hlg = [](double s) { return s * s / 3 / 0.265; };
  const auto pq = [](double s) { return 50.0 / 203 * std::pow(2, (s - 0.440) / 0.068); };
  for (const Case& c : {Case{18, "HLG", 0.3, hlg},
                        {18, "HLG", 0.48, hlg},
                        {18, "HLG", 0.9, [](double) { return 1; }},
                        {16, "PQ", 0.44, pq},
                        {16, "PQ", 0.49, pq},
                        {16, "PQ", 0.7, [](double) { return 1; }}}) {
    SCOPED_TRACE(testing::Message() << c.name << ' ' << c.signal);
    const std::string file = write(cv::Mat(kHeight, kWidth, CV_8UC3, cv::Scalar::all(std::lround(255 * c.signal))));
    const double stored = grey_at(VideoDecoder(file).next()->image, 0.5, 0.5) / 255.0;
    colour(file, 9, c.transfer, 9);
    const auto source = open_video(file, {});
    EXPECT_THAT(source->remarks(), HasSubstr(c.name));
    EXPECT_THAT(source->remarks(), HasSubstr(file));
    const auto frame = source->next(std::chrono::milliseconds(0));
    ASSERT_TRUE(frame);
    EXPECT_NEAR(grey_at(frame->image, 0.5, 0.5), srgb(c.light(stored)), 5);
  }
}

/// A red whose Y'CbCr is made with one matrix and read with the other differs by a dozen levels and more.
TEST_F(DecodedVideo, IsReadByTheMatrixThatItNames) {
  const cv::Mat red(kHeight, kWidth, CV_8UC3, cv::Scalar(40, 60, 200));
  const auto read = [&](int matrix) {
    const std::string file = write(red);  // by the matrix of BT.601
    colour(file, 1, 1, matrix);
    const auto picture = VideoDecoder(file).next();
    return cv::Vec3i(picture->image.bytes[0], picture->image.bytes[1], picture->image.bytes[2]);
  };
  EXPECT_LT(cv::norm(read(6) - cv::Vec3i(200, 60, 40)), 6);
  // Y' = 100.6, Cb - 128 = -30.0 and Cr - 128 = 62.2 of the red, by the coefficients of BT.709.
  const double luma = 0.299 * 200 + 0.587 * 60 + 0.114 * 40, cb = (40 - luma) / 1.772, cr = (200 - luma) / 1.402;
  const cv::Vec3i by_709(int(luma + 1.5748 * cr), int(luma - 0.18733 * cb - 0.46812 * cr), int(luma + 1.8556 * cb));
  EXPECT_LT(cv::norm(read(1) - by_709), 6);
  EXPECT_GT(cv::norm(read(1) - read(6)), 10);
}

}  // namespace
}  // namespace sheen
