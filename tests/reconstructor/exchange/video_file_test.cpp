// SPDX-License-Identifier: Apache-2.0
// Videos, decoded to their planes of luma and chroma and compared with BT.709's own formula.
#include "reconstructor/exchange/video_file.h"

#include <gtest/gtest.h>

#include <array>
#include <vector>

extern "C" {
#include <libavcodec/avcodec.h>
#include <libavformat/avformat.h>
}

#include "common/base/files.h"
#include "tests/support/expect_error.h"
#include "tests/support/temp_folder.h"

namespace sheen {
namespace {

constexpr int kFrames = 12, kWidth = 96, kHeight = 64;
using Colour = std::array<double, 3>;
constexpr std::array<Colour, 6> kColours{
    {{255, 255, 255}, {0, 0, 0}, {230, 30, 20}, {20, 180, 40}, {30, 40, 220}, {128, 128, 128}}};

/// A column of one colour each, which wander by one with each frame.
Colour colour_at(int x, int frame) {
  return kColours[static_cast<std::size_t>((x / 16 + frame) % 6)];
}

ImageU8 frame(int number) {
  ImageU8 picture(kWidth, kHeight, 3);
  for (int y = 0; y < kHeight; ++y)
    for (int x = 0; x < kWidth; ++x)
      for (int c = 0; c < 3; ++c)
        picture.at(x, y, c) = static_cast<std::uint8_t>(colour_at(x, number)[static_cast<std::size_t>(c)]);
  return picture;
}

/// Y, Cb, Cr of 8 bits, limited range (ITU-R BT.709-6, 3.2 to 3.4).
Colour bt709(const Colour& rgb) {
  const double r = rgb[0] / 255, g = rgb[1] / 255, b = rgb[2] / 255;
  const double y = 0.2126 * r + 0.7152 * g + 0.0722 * b;
  return {16 + 219 * y, 128 + 224 * (b - y) / 1.8556, 128 + 224 * (r - y) / 1.5748};
}

struct Decoded {
  AVCodecID codec = AV_CODEC_ID_NONE;
  AVPixelFormat format = AV_PIX_FMT_NONE;
  AVColorSpace space = AVCOL_SPC_UNSPECIFIED;
  AVColorPrimaries primaries = AVCOL_PRI_UNSPECIFIED;
  AVColorTransferCharacteristic transfer = AVCOL_TRC_UNSPECIFIED;
  AVColorRange range = AVCOL_RANGE_UNSPECIFIED;
  double frames_per_s = 0;
  std::vector<std::array<Colour, 6>> frames;  ///< Y, Cb, Cr in the middle of each column
};

Decoded decoded(const std::filesystem::path& path) {
  Decoded out;
  AVFormatContext* file = nullptr;
  if (avformat_open_input(&file, path.c_str(), nullptr, nullptr) != 0) return out;
  avformat_find_stream_info(file, nullptr);
  const AVCodecParameters& stream = *file->streams[0]->codecpar;
  AVCodecContext* codec = avcodec_alloc_context3(avcodec_find_decoder(stream.codec_id));
  avcodec_parameters_to_context(codec, &stream);
  avcodec_open2(codec, nullptr, nullptr);
  AVPacket* packet = av_packet_alloc();
  AVFrame* picture = av_frame_alloc();
  const auto take = [&] {
    while (avcodec_receive_frame(codec, picture) == 0) {
      auto& columns = out.frames.emplace_back();
      for (int i = 0; i < 6; ++i) {
        const int x = 16 * i + 8, y = kHeight / 2;
        columns[static_cast<std::size_t>(i)] = {double(picture->data[0][y * picture->linesize[0] + x]),
                                                double(picture->data[1][y / 2 * picture->linesize[1] + x / 2]),
                                                double(picture->data[2][y / 2 * picture->linesize[2] + x / 2])};
      }
    }
  };
  while (av_read_frame(file, packet) == 0) {
    avcodec_send_packet(codec, packet);
    av_packet_unref(packet);
    take();
  }
  avcodec_send_packet(codec, nullptr);
  take();
  out.codec = stream.codec_id;
  out.format = codec->pix_fmt;
  out.space = codec->colorspace;
  out.primaries = codec->color_primaries;
  out.transfer = codec->color_trc;
  out.range = codec->color_range;
  out.frames_per_s = av_q2d(file->streams[0]->avg_frame_rate);
  av_frame_free(&picture);
  av_packet_free(&packet);
  avcodec_free_context(&codec);
  avformat_close_input(&file);
  return out;
}

void write(const std::filesystem::path& path, VideoKind kind) {
  VideoFile video(path, kind, {kWidth, kHeight}, 25);
  for (int i = 0; i < kFrames; ++i) video.add(frame(i));
  video.finish();
}

void expect_the_frames(const Decoded& video) {
  EXPECT_EQ(video.format, AV_PIX_FMT_YUV420P);
  EXPECT_EQ(video.space, AVCOL_SPC_BT709);
  EXPECT_EQ(video.primaries, AVCOL_PRI_BT709);
  EXPECT_EQ(video.transfer, AVCOL_TRC_BT709);
  EXPECT_EQ(video.range, AVCOL_RANGE_MPEG);
  EXPECT_NEAR(video.frames_per_s, 25, 1e-6);
  ASSERT_EQ(video.frames.size(), static_cast<std::size_t>(kFrames));
  for (int i = 0; i < kFrames; ++i)
    for (int column = 0; column < 6; ++column) {
      const Colour truth = bt709(colour_at(16 * column, i));
      for (std::size_t k = 0; k < 3; ++k)
        EXPECT_NEAR(video.frames[static_cast<std::size_t>(i)][static_cast<std::size_t>(column)][k], truth[k], 4)
            << "frame " << i << ", column " << column << ", "
            << "YBR"[k];
    }
}

TEST(VideoFileTest, Mp4IsH264InBt709ThatBeginsAtOnce) {
  const TempFolder temp;
  const auto file = temp.path() / "a.mp4.part";  // whatever it is called
  write(file, VideoKind::kMp4);
  const Decoded video = decoded(file);
  EXPECT_EQ(video.codec, AV_CODEC_ID_H264);
  expect_the_frames(video);
  const std::string bytes = read_file(file);
  EXPECT_LT(bytes.find("moov"), bytes.find("mdat")) << "what a player needs first comes first";
}

TEST(VideoFileTest, WebmIsVp9InBt709) {
  const TempFolder temp;
  const auto file = temp.path() / "a.webm";
  write(file, VideoKind::kWebm);
  const Decoded video = decoded(file);
  EXPECT_EQ(video.codec, AV_CODEC_ID_VP9);
  expect_the_frames(video);
}

TEST(VideoFileTest, WhatCannotBeIsTold) {
  EXPECT_EQ(video_kind("a/b.mp4"), VideoKind::kMp4);
  EXPECT_EQ(video_kind("b.webm"), VideoKind::kWebm);
  EXPECT_FALSE(video_kind("folder"));
  expect_error(
      [&] {
        VideoFile("/nowhere/a.mp4", VideoKind::kMp4, {64, 64}, 30);
      },
      {"/nowhere/a.mp4", "cannot be written"});
  const TempFolder temp;
  VideoFile video(temp.path() / "a.mp4", VideoKind::kMp4, {64, 64}, 30);
  expect_error([&] { video.add(ImageU8(32, 64, 3)); }, {"one size"});
}

}  // namespace
}  // namespace sheen
