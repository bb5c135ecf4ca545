// SPDX-License-Identifier: Apache-2.0
#include "reconstructor/evaluation/held_out.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

#include "common/base/errors.h"
#include "common/capture/linear_capture.h"
#include "common/image/color.h"
#include "common/image/exr.h"
#include "common/image/image_codec.h"
#include "reconstructor/radiance/radiance_image.h"

namespace sheen {
namespace {

constexpr int kEdge = 3;  // pixels: what a mesh or a mask is off by, and the reach of a pixel's filters

ImageF scaled(const ImageF& linear, float gain) {
  if (gain == 1) return linear;
  ImageF out = linear;
  for (std::size_t i = 0; i < out.size(); ++i) out.data()[i] *= gain;
  return out;
}

/// The pixels of the mask in a row.
template <typename T>
Image<T> in_a_row(const Image<T>& image, const ImageU8& mask) {
  const auto count = std::count_if(mask.data(), mask.data() + mask.size(), [](std::uint8_t m) { return m != 0; });
  Image<T> row(static_cast<int>(count), 1, image.channels());
  T* to = row.data();
  for (int y = 0; y < mask.height(); ++y)
    for (int x = 0; x < mask.width(); ++x)
      if (mask.at(x, y) != 0) to = std::copy_n(image.pixel(x, y), image.channels(), to);
  return row;
}

/// Of the picture times a gain, as it would be shown; some values at a time.
SquaredError error_with_gain(const ImageF& painted, const ImageU8& truth, float gain) {
  constexpr std::size_t kAtOnce = 4096;
  std::array<float, kAtOnce> scaled;
  std::array<std::uint8_t, kAtOnce> codes;
  SquaredError error{.sum = 0, .count = painted.size()};
  for (std::size_t first = 0; first < painted.size(); first += kAtOnce) {
    const std::size_t count = std::min(kAtOnce, painted.size() - first);
    for (std::size_t i = 0; i < count; ++i) scaled[i] = gain * painted.data()[first + i];
    to_srgb8({scaled.data(), count}, codes.data());
    int sum = 0;
    for (std::size_t i = 0; i < count; ++i) {
      const int difference = int(codes[i]) - int(truth.data()[first + i]);
      sum += difference * difference;
    }
    error.sum += sum;
  }
  return error;
}

/// Best PSNR over one scalar gain: golden-section search on the log of the gain, within a factor of four.
double gain_aligned_psnr(const ImageF& painted, const ImageU8& truth) {
  const auto psnr = [&](double log_gain) {
    return error_with_gain(painted, truth, static_cast<float>(std::exp(log_gain))).psnr_db();
  };
  constexpr double kGolden = 0.6180339887498949;
  double low = -std::log(4.0), high = std::log(4.0);
  double a = high - kGolden * (high - low), b = low + kGolden * (high - low);
  double at_a = psnr(a), at_b = psnr(b);
  while (high - low > 0.002) {
    if (at_a > at_b) {
      high = b;
      b = a;
      at_b = at_a;
      a = high - kGolden * (high - low);
      at_a = psnr(a);
    } else {
      low = a;
      a = b;
      at_a = at_b;
      b = low + kGolden * (high - low);
      at_b = psnr(b);
    }
  }
  return std::max({at_a, at_b, psnr(0)});
}

void keep_within(const ImageU8& mask, ImageU8& pixels) {
  for (std::size_t i = 0; i < mask.size(); ++i)
    if (mask.data()[i] == 0) pixels.data()[i] = 0;
}

/// The capture, divided by `gain`, as it would be shown; some rows at a time, of which few are there in floating point.
ImageU8 shown(const Capture& capture, float gain) {
  constexpr int kStrip = 128;  // rows
  const LinearReader reader = linear_reader(capture);
  const int width = capture.image.width, height = capture.image.height;
  ImageU8 picture(width, height, 3);
  for (int y = 0; y < height; y += kStrip) {
    const int rows = std::min(kStrip, height - y);
    ImageF strip(width, rows, 3);
    reader.read({0, y, width, y + rows}, 3, strip.data(), 3 * static_cast<std::size_t>(width));
    const ImageU8 encoded = to_srgb8(scaled(strip, 1 / gain));
    std::copy_n(encoded.data(), encoded.size(), picture.row(y));
  }
  return picture;
}

constexpr std::uint8_t kObject = 1, kInside = 2;  // bits of what is packed as a mask

RawImage raw_image(int width, int height) {
  return {.format = PixelFormat::kRGB8,
          .transfer = Transfer::kSrgb,
          .width = width,
          .height = height,
          .stride = 3 * static_cast<std::size_t>(width)};
}

ImageU8 with_bit(const ImageU8& bits, std::uint8_t bit) {
  ImageU8 pixels(bits.width(), bits.height(), 1);
  for (std::size_t i = 0; i < bits.size(); ++i) pixels.data()[i] = bits.data()[i] & bit ? 255 : 0;
  return pixels;
}

}  // namespace

JudgedPixels HeldOutView::pixels() const {
  RawImage image = raw_image(camera.width, camera.height);
  ImageU8 bits(camera.width, camera.height, 1);
  unpack_pixels(packed, Codec::kDeltaZstd, image, bits);
  JudgedPixels pixels{ImageU8(camera.width, camera.height, 3), with_bit(bits, kObject), with_bit(bits, kInside)};
  std::copy(image.bytes.begin(), image.bytes.end(), pixels.truth.data());
  return pixels;
}

void HeldOutView::pack(const JudgedPixels& pixels) {
  RawImage image = raw_image(camera.width, camera.height);
  image.bytes.assign(pixels.truth.data(), pixels.truth.data() + pixels.truth.size());
  ImageU8 bits(camera.width, camera.height, 1);
  for (std::size_t i = 0; i < bits.size(); ++i)
    bits.data()[i] =
        static_cast<std::uint8_t>((pixels.object.data()[i] ? kObject : 0) | (pixels.inside.data()[i] ? kInside : 0));
  packed = PixelPacker().pack(image, bits, Codec::kDeltaZstd);
}

HeldOutView make_held_out_view(const Capture& capture, float gain, const RayPainter& painter) {
  HeldOutView view{.name = capture.name,
                   .source_session = capture.source_session,
                   .sequence = capture.sequence,
                   .camera = capture.camera,
                   .camera_from_object = capture.pose.camera_from_object,
                   .light = capture.light};
  JudgedPixels pixels;
  pixels.truth = shown(capture, gain);
  pixels.object = painter.silhouette(view.camera, view.camera_from_object);
  if (capture.mask.empty())
    pixels.object = erode(pixels.object, kEdge);
  else
    keep_within(capture.mask, pixels.object);
  pixels.inside = capture.mask.empty() ? pixels.object : erode(pixels.object, kEdge);
  if (const ImageU8 usable = usable_pixels(capture); !usable.empty()) {
    keep_within(usable, pixels.object);
    keep_within(usable, pixels.inside);
  }
  view.pack(pixels);
  return view;
}

void take_truth_from(const std::filesystem::path& folder, HeldOutView& view) {
  const std::filesystem::path file = folder / std::filesystem::path(view.name).stem().concat(".exr");
  const ExrFile exr = read_exr(file);
  const ImageF& radiance = exr.parts.front().image;
  if (radiance.width() != view.camera.width || radiance.height() != view.camera.height || radiance.channels() != 3)
    throw FileError(file, "is " + std::to_string(radiance.width()) + "x" + std::to_string(radiance.height()) +
                              " with " + std::to_string(radiance.channels()) + " channels; the image " + view.name +
                              " asks for " + std::to_string(view.camera.width) + "x" +
                              std::to_string(view.camera.height) + " and R, G, B");
  JudgedPixels pixels = view.pixels();
  pixels.truth = to_srgb8(radiance);
  view.pack(pixels);
}

double predicted_psnr_db(const PaintedView& painted, const ImageU8& mask) {
  double squares = 0;
  std::size_t pixels = 0;
  for (std::size_t i = 0; i < mask.size(); ++i) {
    if (mask.data()[i] == 0) continue;
    const double error = painted.predicted_error.data()[i];
    squares += error * error;
    ++pixels;
  }
  return pixels > 0 ? -10 * std::log10(squares / static_cast<double>(pixels))
                    : std::numeric_limits<double>::quiet_NaN();
}

ViewScore score(const HeldOutView& view, const Appearance& model, const RayPainter& painter) {
  const auto [truth, object, inside] = view.pixels();
  const PaintedView painted = painter.paint(model, view.camera, view.camera_from_object, view.light);
  const ImageU8 picture = to_srgb8(painted.beauty);
  ViewScore score{.name = view.name, .source_session = view.source_session, .sequence = view.sequence};
  score.error = squared_error(picture, truth, object);
  score.psnr_db = score.error.psnr_db();
  score.ssim = ssim(picture, truth, object);
  score.psnr_inside_db = squared_error(picture, truth, inside).psnr_db();
  score.predicted_inside_db = predicted_psnr_db(painted, inside);
  score.psnr_gain_aligned_db = gain_aligned_psnr(in_a_row(painted.beauty, object), in_a_row(truth, object));
  score.full_psnr_db = squared_error(picture, truth, {}).psnr_db();
  score.full_ssim = ssim(picture, truth, {});
  std::size_t pixels = 0, uncovered = 0;
  for (std::size_t i = 0; i < object.size(); ++i) {
    pixels += object.data()[i] != 0;
    uncovered += object.data()[i] != 0 && painted.coverage.data()[i] < kCoverageImputed;
  }
  score.uncovered = pixels > 0 ? double(uncovered) / double(pixels) : 0;
  return score;
}

SquaredError object_error(const HeldOutView& view, const Appearance& model, const RayPainter& painter) {
  const JudgedPixels pixels = view.pixels();
  const ImageU8 picture = to_srgb8(painter.paint(model, view.camera, view.camera_from_object, view.light).beauty);
  return squared_error(picture, pixels.truth, pixels.object);
}

ObjectScore score_object(const HeldOutView& view, const Appearance& model, const RayPainter& painter) {
  const JudgedPixels pixels = view.pixels();
  const ImageU8 picture = to_srgb8(painter.paint(model, view.camera, view.camera_from_object, view.light).beauty);
  return {squared_error(picture, pixels.truth, pixels.object).psnr_db(), ssim(picture, pixels.truth, pixels.object)};
}

Scores score(const std::vector<HeldOutView>& views, const Appearance& model, const RayPainter& painter,
             const StepsDone& progress) {
  Scores scores;
  if (views.empty()) {  // nothing was judged, which is not the same as a score of 0
    const double none = std::numeric_limits<double>::quiet_NaN();
    scores.psnr_db = scores.ssim = scores.psnr_inside_db = scores.predicted_inside_db = scores.psnr_gain_aligned_db =
        none;
    scores.psnr_pooled_db = scores.full_psnr_db = scores.full_ssim = scores.uncovered = none;
    return scores;
  }
  SquaredError pooled;
  for (const HeldOutView& view : views) {
    if (progress) progress(scores.views.size(), views.size());
    const ViewScore& s = scores.views.emplace_back(score(view, model, painter));
    const double weight = 1.0 / double(views.size());
    scores.psnr_db += weight * s.psnr_db;
    scores.ssim += weight * s.ssim;
    scores.psnr_inside_db += weight * s.psnr_inside_db;
    scores.predicted_inside_db += weight * s.predicted_inside_db;
    scores.psnr_gain_aligned_db += weight * s.psnr_gain_aligned_db;
    scores.full_psnr_db += weight * s.full_psnr_db;
    scores.full_ssim += weight * s.full_ssim;
    scores.uncovered += weight * s.uncovered;
    pooled += s.error;
  }
  scores.psnr_pooled_db = pooled.psnr_db();
  return scores;
}

ErrorCalibration calibrate(const Scores& scores) {
  std::vector<double> differences;
  for (const ViewScore& view : scores.views) differences.push_back(view.psnr_inside_db - view.predicted_inside_db);
  return calibrate(differences);
}

CalibrationCheck check_calibration(const Scores& scores) {
  std::vector<double> predicted, measured;
  for (const ViewScore& view : scores.views) {
    predicted.push_back(view.predicted_inside_db);
    measured.push_back(view.psnr_inside_db);
  }
  return check_calibration(predicted, measured);
}

}  // namespace sheen
