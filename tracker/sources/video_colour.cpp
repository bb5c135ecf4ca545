// SPDX-License-Identifier: Apache-2.0
#include "tracker/sources/video_colour.h"

extern "C" {
#include <libavutil/frame.h>
#include <libavutil/pixfmt.h>
#include <libswscale/swscale.h>
}

#include <algorithm>
#include <array>
#include <cmath>
#include <vector>

#include "common/image/color.h"

namespace sheen {
namespace {

constexpr int kCodes = 1 << 16;       ///< of a channel of 16 bits
constexpr int kWhiteCode = 255 << 8;  ///< what swscale makes of white there
constexpr int kLevels = 1 << 14;      ///< of linear light as it is encoded: a fifth of an sRGB step where it is darkest
constexpr int kAsIs = 1 << 16;        ///< contrast and saturation of swscale
constexpr double kWhite_nits = 203;   ///< reference white of PQ

using Matrix = std::array<float, 9>;

/// Linear RGB to that of BT.709.
constexpr Matrix kFrom2020 = {1.6605f, -0.5876f, -0.0728f, -0.1246f, 1.1329f, -0.0083f, -0.0182f, -0.1006f, 1.1187f};
constexpr Matrix kFromP3 = {1.2249f, -0.2247f, 0, -0.0420f, 1.0419f, 0, -0.0197f, -0.0786f, 1.0979f};
constexpr Matrix kFrom709 = {1, 0, 0, 0, 1, 0, 0, 0, 1};

const Matrix& to_709(int primaries) {
  if (primaries == AVCOL_PRI_BT2020) return kFrom2020;
  if (primaries == AVCOL_PRI_SMPTE432 || primaries == AVCOL_PRI_SMPTE431) return kFromP3;
  return kFrom709;
}

/// Scene light of HLG (ITU-R BT.2100, table 5), of 0..1.
double hlg_light(double signal) {
  constexpr double a = 0.17883277, b = 0.28466892, c = 0.55991073;
  return signal <= 0.5 ? signal * signal / 3 : (std::exp((signal - c) / a) + b) / 12;
}

/// Display light of PQ (ITU-R BT.2100, table 4), cd/m2.
double pq_light(double signal) {
  constexpr double m1 = 0.1593017578125, m2 = 78.84375, c1 = 0.8359375, c2 = 18.8515625, c3 = 18.6875;
  const double power = std::pow(signal, 1 / m2);
  return 10000 * std::pow(std::max(power - c1, 0.0) / (c2 - c3 * power), 1 / m1);
}

bool is_ordinary(int transfer) {
  return transfer != AVCOL_TRC_ARIB_STD_B67 && transfer != AVCOL_TRC_SMPTE2084 && transfer != AVCOL_TRC_LINEAR &&
         transfer != AVCOL_TRC_LOG && transfer != AVCOL_TRC_LOG_SQRT;
}

/// Light of a signal of 0..1; 1 is full scale.
double light_of(int transfer, double signal) {
  switch (transfer) {
    case AVCOL_TRC_ARIB_STD_B67:
      return hlg_light(signal) / hlg_light(0.75);
    case AVCOL_TRC_SMPTE2084:
      return pq_light(signal) / kWhite_nits;
    case AVCOL_TRC_LINEAR:
      return signal;
    case AVCOL_TRC_LOG:
      return std::pow(10, 2 * (signal - 1));
    case AVCOL_TRC_LOG_SQRT:
      return std::pow(10, 2.5 * (signal - 1));
    default:
      return srgb_decode(static_cast<float>(signal));
  }
}

const std::vector<std::uint8_t>& codes_of_light() {
  static const std::vector<std::uint8_t> codes = [] {
    std::vector<std::uint8_t> all(kLevels);
    for (int i = 0; i < kLevels; ++i)
      all[i] = static_cast<std::uint8_t>(std::lround(255 * srgb_encode(float(i) / (kLevels - 1))));
    return all;
  }();
  return codes;
}

}  // namespace

struct VideoColour::Impl {
  SwsContext* scaler = nullptr;
  std::vector<std::uint16_t> wide;  ///< 16-bit RGB of a picture whose light is needed
  int transfer = -1;                ///< of `light`
  std::vector<float> light;

  ~Impl() { sws_freeContext(scaler); }
  bool to_rgb(const AVFrame& frame, AVPixelFormat format, int pixel_bytes, void* rgb);
  void encode(std::size_t pixels, int primaries, std::uint8_t* rgb) const;
};

VideoColour::VideoColour() : impl_(std::make_unique<Impl>()) {}
VideoColour::~VideoColour() = default;

bool VideoColour::Impl::to_rgb(const AVFrame& frame, AVPixelFormat format, int pixel_bytes, void* rgb) {
  scaler =
      sws_getCachedContext(scaler, frame.width, frame.height, AVPixelFormat(frame.format), frame.width, frame.height,
                           format, SWS_BICUBIC | SWS_ACCURATE_RND | SWS_FULL_CHR_H_INT, nullptr, nullptr, nullptr);
  if (!scaler) return false;
  const int* matrix = sws_getCoefficients(frame.colorspace);  // of an unnamed one those of BT.601, as players do
  sws_setColorspaceDetails(scaler, matrix, frame.color_range == AVCOL_RANGE_JPEG, sws_getCoefficients(SWS_CS_DEFAULT),
                           1, 0, kAsIs, kAsIs);
  std::uint8_t* const planes[4] = {static_cast<std::uint8_t*>(rgb)};
  const int strides[4] = {frame.width * pixel_bytes};
  return sws_scale(scaler, frame.data, frame.linesize, 0, frame.height, planes, strides) == frame.height;
}

void VideoColour::Impl::encode(std::size_t pixels, int primaries, std::uint8_t* rgb) const {
  const Matrix& m = to_709(primaries);
  const std::vector<std::uint8_t>& codes = codes_of_light();
  for (std::size_t i = 0; i < pixels; ++i) {
    const float r = light[wide[3 * i]], g = light[wide[3 * i + 1]], b = light[wide[3 * i + 2]];
    for (int c = 0; c < 3; ++c) {
      const float value = m[3 * c] * r + m[3 * c + 1] * g + m[3 * c + 2] * b;
      rgb[3 * i + c] = codes[static_cast<int>(std::clamp(value, 0.f, 1.f) * (kLevels - 1) + 0.5f)];
    }
  }
}

bool VideoColour::convert(const AVFrame& frame, std::uint8_t* rgb) {
  Impl& self = *impl_;
  if (is_ordinary(frame.color_trc) && &to_709(frame.color_primaries) == &kFrom709)
    return self.to_rgb(frame, AV_PIX_FMT_RGB24, 3, rgb);
  if (self.transfer != frame.color_trc) {
    self.transfer = frame.color_trc;
    self.light.resize(kCodes);
    for (int i = 0; i < kCodes; ++i)
      self.light[i] = static_cast<float>(light_of(self.transfer, std::min(1.0, double(i) / kWhiteCode)));
  }
  const std::size_t pixels = std::size_t(frame.width) * frame.height;
  self.wide.resize(3 * pixels);
  if (!self.to_rgb(frame, AV_PIX_FMT_RGB48, 6, self.wide.data())) return false;
  self.encode(pixels, frame.color_primaries, rgb);
  return true;
}

std::string colour_warning(int transfer, int primaries) {
  const std::string gamut = &to_709(primaries) == &kFrom709 ? "" : " of a wide gamut";
  const auto said = [&](const std::string& kind) {
    return "is " + kind + " video" + gamut + "; its colours are converted to sRGB";
  };
  switch (transfer) {
    case AVCOL_TRC_ARIB_STD_B67:
      return said("HLG (high dynamic range)") +
             ", and what is brighter than its reference white (a signal of 75 %) is clipped";
    case AVCOL_TRC_SMPTE2084:
      return said("PQ (high dynamic range)") + ", and what is brighter than its reference white (203 cd/m2) is clipped";
    case AVCOL_TRC_LINEAR:
      return said("linear");
    case AVCOL_TRC_LOG:
    case AVCOL_TRC_LOG_SQRT:
      return said("logarithmic");
    case AVCOL_TRC_SMPTE428:
      return "has colours of digital cinema (SMPTE 428), which are read as sRGB: they are wrong. Convert it first";
    default:
      return gamut.empty() ? "" : said("ordinary");
  }
}

}  // namespace sheen
