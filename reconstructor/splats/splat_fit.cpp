// SPDX-License-Identifier: Apache-2.0
#include "reconstructor/splats/splat_fit.h"

#include <algorithm>
#include <cmath>

#include "common/image/color.h"
#include "reconstructor/render/ray_painter.h"
#include "reconstructor/splats/colour_fit.h"
#include "reconstructor/splats/splat_eyes.h"
#include "reconstructor/splats/splat_painter.h"
#include "reconstructor/splats/splat_placement.h"

namespace sheen {
namespace {

using Eigen::Vector3f;

constexpr std::size_t kPixelsPerSplat = 100;  ///< that are fitted to, over all pictures
constexpr float kRoundWeight = 0.2f;          ///< of an eye all round against one between the images

/// What a model shows from an eye.
struct Picture {
  ImageF encoded;  ///< 0..1
  ImageU8 shown;   ///< 0 where there is no surface
};

Picture picture_of(const SplatSubject& subject, const RayPainter& painter, const PosedCamera& from) {
  PaintedView painted = painter.paint(subject.model, from.camera, from.camera_from_object);
  ImageF& picture = painted.beauty;
  for (std::size_t i = 0; i < picture.size(); ++i)
    picture.data()[i] = srgb_encode(std::clamp(picture.data()[i], 0.0f, 1.0f));
  return {std::move(picture), std::move(painted.coverage)};
}

/// Leaves about so many of the pixels that are not 0, evenly spread.
void thin_out(ImageU8& pixels, std::size_t most) {
  const auto shown = std::count_if(pixels.data(), pixels.data() + pixels.size(), [](auto pixel) { return pixel > 0; });
  const double kept = static_cast<double>(most) / static_cast<double>(std::max<std::ptrdiff_t>(1, shown));
  for (int y = 0; y < pixels.height(); ++y)
    for (int x = 0; x < pixels.width(); ++x)
      if (std::fmod(0.7548776662466927 * x + 0.5698402909980532 * y, 1.0) >= kept) pixels.at(x, y) = 0;
}

double psnr_of(const Splats& splats, const SplatSubject& subject, const RayPainter& painter,
               const std::vector<PosedCamera>& eyes) {
  double squares = 0, values = 0;
  for (const PosedCamera& from : eyes) {
    const Picture truth = picture_of(subject, painter, from);
    const ImageF picture = paint_splats(splats, from);
    for (std::size_t i = 0; i < truth.shown.size(); ++i) {
      if (truth.shown.data()[i] == 0) continue;
      const Eigen::Map<const Vector3f> wanted(truth.encoded.data() + 3 * i), shown(picture.data() + 4 * i);
      squares += (shown.cwiseMin(1.0f) - wanted).squaredNorm();
      values += 3;
    }
  }
  return -10 * std::log10(squares / values);
}

}  // namespace

FittedSplats fit_splats(const SplatSubject& subject, std::size_t count, int degree, const StepsDone& progress) {
  const Mesh& mesh = subject.model.mesh();
  const RayPainter painter(mesh);
  const SplatEyes eyes = splat_eyes(bounding_sphere(mesh), subject.images, mean_width(mesh, count));
  FittedSplats fitted{.splats = place_splats(mesh, subject.mean_look, count, degree), .psnr_db = 0};
  Splats& splats = fitted.splats;

  const std::size_t eye_count = eyes.near.size() + eyes.round.size();
  std::size_t done = 0;
  const auto step = [&] {
    if (progress) progress(++done, eye_count + ColourFit::kRounds);
  };
  std::vector<SplatView> views;
  const auto look_from = [&](const std::vector<PosedCamera>& places, float weight) {
    for (const PosedCamera& from : places) {
      Picture picture = picture_of(subject, painter, from);
      thin_out(picture.shown, kPixelsPerSplat * count / eye_count);
      views.push_back(splat_view(splats.shapes, splats.terms(), from, picture.encoded, picture.shown));
      views.back().weight = weight;
      step();
    }
  };
  look_from(eyes.near, 1);
  look_from(eyes.round, eyes.near.empty() ? 1 : kRoundWeight);
  ColourFit(std::move(views), splats.shapes.size(), splats.terms()).improve(splats.colours, step);
  fitted.psnr_db = psnr_of(splats, subject, painter, eyes.check);
  return fitted;
}

}  // namespace sheen
