// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "common/base/progress.h"
#include "common/capture/capture.h"
#include "common/image/image.h"
#include "common/image/image_metrics.h"
#include "reconstructor/evaluation/error_calibration.h"
#include "reconstructor/models/appearance_model.h"
#include "reconstructor/render/ray_painter.h"

namespace sheen {

/// What a picture is compared with.
struct JudgedPixels {
  ImageU8 truth;   ///< RGB, 8-bit sRGB
  ImageU8 object;  ///< pixels of the object: first hit a front face, and inside the mask, or eroded by 3 without one;
                   ///< pixels that are NaN or infinite do not count
  ImageU8 inside;  ///< of these, eroded by 3 with a mask too: none that mixes the object with what is behind it
};

/// A view the model never saw, ready to be compared with. A capture keeps some until its end: packed, without loss.
struct HeldOutView {
  std::string name;
  std::string source_session;  ///< with `sequence`, of the capture
  std::uint64_t sequence = 0;
  Camera camera;
  Rigid3 camera_from_object;
  LightState light;
  std::vector<std::uint8_t> packed;  ///< of `pixels`

  JudgedPixels pixels() const;
  void pack(const JudgedPixels& pixels);
};
/// `gain`: how much brighter the image is than the model's level; the truth is divided by it.
HeldOutView make_held_out_view(const Capture& capture, float gain, const RayPainter& painter);

/// Replaces the photograph, which has noise, by a picture of linear radiance that has none (or less) and the same
/// scale: `folder`/NAME.exr, where NAME is the view's without folder and extension. Throws FileError.
void take_truth_from(const std::filesystem::path& folder, HeldOutView& view);

/// PSNR by the errors that a model predicts of its picture, over the pixels where `mask` is non-zero; NaN without any.
double predicted_psnr_db(const PaintedView& painted, const ImageU8& mask);

struct ViewScore {
  std::string name, source_session;
  std::uint64_t sequence = 0;
  double psnr_db = 0;               ///< object pixels, 8-bit sRGB
  double ssim = 0;                  ///< object pixels
  double psnr_inside_db = 0;        ///< the object's pixels but for those at its edge
  double predicted_inside_db = 0;   ///< the same as the model predicts it; NaN where no pixel is inside
  double psnr_gain_aligned_db = 0;  ///< after the one gain of linear radiance that fits the object's pixels best
  double full_psnr_db = 0;          ///< the whole picture; where there is no surface it is black
  double full_ssim = 0;
  SquaredError error;    ///< of the object's pixels, to be pooled
  double uncovered = 0;  ///< fraction of the object's pixels that no training image showed
};
ViewScore score(const HeldOutView& view, const Appearance& model, const RayPainter& painter);

/// The object's pixels alone: what is judged again and again while a capture runs.
struct ObjectScore {
  double psnr_db = 0, ssim = 0;
};
SquaredError object_error(const HeldOutView& view, const Appearance& model, const RayPainter& painter);
ObjectScore score_object(const HeldOutView& view, const Appearance& model, const RayPainter& painter);

/// Means over views, as published figures are; `psnr_pooled_db` from the pooled squared error.
struct Scores {
  std::vector<ViewScore> views;
  double psnr_db = 0, ssim = 0, psnr_inside_db = 0, psnr_gain_aligned_db = 0, psnr_pooled_db = 0;
  double predicted_inside_db = 0;
  double full_psnr_db = 0, full_ssim = 0, uncovered = 0;
};
Scores score(const std::vector<HeldOutView>& views, const Appearance& model, const RayPainter& painter,
             const StepsDone& progress = {});
/// By what the model predicted of these views and what was measured inside the object's edge.
ErrorCalibration calibrate(const Scores& scores);
CalibrationCheck check_calibration(const Scores& scores);

}  // namespace sheen
