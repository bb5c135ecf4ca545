// SPDX-License-Identifier: Apache-2.0
#include "reconstructor/studies/patches.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <memory>

#include "common/image/color.h"
#include "reconstructor/models/surface_light_field/fill_unseen.h"

namespace sheen {
namespace {

/// By place, not by index: meshes may have several vertices at one place.
bool touch(const Mesh& mesh, std::uint32_t a, std::uint32_t b) {
  for (int i = 0; i < 3; ++i)
    for (int j = 0; j < 3; ++j)
      if (mesh.corner(a, i) == mesh.corner(b, j)) return true;
  return false;
}

PatchRow measure(int triangles, const Experiment& experiment, const OnlineRun& run) {
  const auto model = fill_unseen(*run.model);
  const RayPainter painter(model->mesh());
  const Scores scores = score(experiment.held_out, *model, painter);
  SeamError seams;
  for (const HeldOutView& view : experiment.held_out) {
    const JudgedPixels pixels = view.pixels();
    seams += seam_error(model->mesh(), painter.cast(view.camera, view.camera_from_object),
                        to_srgb8(painter.paint(*model, view.camera, view.camera_from_object).beauty), pixels.truth,
                        pixels.object);
  }
  const auto& patches = run.model->patches();
  const auto reached = std::count_if(patches.begin(), patches.end(), [](const auto& patch) { return patch; });
  return {.triangles = triangles,
          .patches = static_cast<std::size_t>(reached),
          .factorize_ms = run.factorize_ms,
          .bytes = static_cast<double>(run.bytes),
          .psnr_db = scores.psnr_db,
          .ssim = scores.ssim,
          .seam = seams.ratio()};
}

}  // namespace

SeamError& SeamError::operator+=(const SeamError& other) {
  across2 += other.across2;
  within2 += other.within2;
  across += other.across;
  within += other.within;
  return *this;
}

double SeamError::ratio() const {
  if (across == 0 || within == 0) return std::numeric_limits<double>::quiet_NaN();
  if (across2 == 0 && within2 == 0) return 1;
  if (within2 == 0) return std::numeric_limits<double>::infinity();
  return std::sqrt((across2 / static_cast<double>(across)) / (within2 / static_cast<double>(within)));
}

SeamError seam_error(const Mesh& mesh, std::span<const Hit> hits, const ImageU8& picture, const ImageU8& truth,
                     const ImageU8& object) {
  SeamError seams;
  const int w = picture.width(), h = picture.height();
  const auto count = [&](int x0, int y0, int x1, int y1) {
    if (object.at(x0, y0) == 0 || object.at(x1, y1) == 0) return;
    const Hit &a = hits[std::size_t(y0) * w + x0], &b = hits[std::size_t(y1) * w + x1];
    if (!a || !b) return;
    const bool same = a.triangle == b.triangle;
    if (!same && !touch(mesh, a.triangle, b.triangle)) return;
    for (int c = 0; c < 3; ++c) {
      const double change =
          (picture.at(x1, y1, c) - truth.at(x1, y1, c)) - (picture.at(x0, y0, c) - truth.at(x0, y0, c));
      (same ? seams.within2 : seams.across2) += change * change;
    }
    (same ? seams.within : seams.across) += 3;
  };
  for (int y = 0; y < h; ++y)
    for (int x = 0; x < w; ++x) {
      if (x + 1 < w) count(x, y, x + 1, y);
      if (y + 1 < h) count(x, y, x, y + 1);
    }
  return seams;
}

std::vector<PatchRow> study_patches(const Experiment& experiment, const SurfaceLightFieldOptions& options,
                                    std::span<const int> sizes) {
  std::vector<PatchRow> rows;
  for (const int triangles : sizes) {
    SurfaceLightFieldOptions sized = options;
    sized.patch.size = {.triangles = static_cast<std::size_t>(triangles)};
    rows.push_back(measure(triangles, experiment, build_online(experiment.mesh, experiment.in_order(), sized)));
  }
  return rows;
}

}  // namespace sheen
