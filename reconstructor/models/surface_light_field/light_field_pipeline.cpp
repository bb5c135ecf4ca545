// SPDX-License-Identifier: Apache-2.0
#include "reconstructor/models/surface_light_field/light_field_pipeline.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <tuple>
#include <utility>

#include "common/base/stage_clock.h"
#include "reconstructor/radiance/capture_rules.h"
#include "reconstructor/radiance/exposure_gain.h"
#include "reconstructor/surface/map_resolution.h"

namespace sheen {
namespace {

// An image that may repeat an earlier one is decided on one patch of so many; by so many of those.
constexpr std::size_t kPatchesPerTested = 13;  // no multiple of how many a regular mesh has side by side
constexpr double kRepeatedFraction = 0.95;
constexpr std::size_t kPredictedPatches = 16;  // per image: each costs a solve

bool has_pose(const PoseEstimate& pose) {
  return pose.usable() && pose.camera_from_object.rotation.coeffs().allFinite() &&
         pose.camera_from_object.translation.allFinite();
}

/// Whether image, camera and mask can be read side by side.
bool sizes_agree(const Capture& capture) {
  const auto& [image, camera, mask] = std::tie(capture.image, capture.camera, capture.mask);
  return validation_error(image).empty() && image.width == camera.width && image.height == camera.height &&
         (mask.empty() || (mask.width() == image.width && mask.height() == image.height && mask.channels() == 1));
}

}  // namespace

void LightFieldPipeline::start(const Beginning& first) {
  shape = std::make_shared<MapLayout>(map_sides(first.camera, first.camera_from_object));
  visibility = std::make_unique<SampleVisibility>(*mesh, *shape, options.visibility, scene);
  constant_colour = std::make_shared<ConstantColour>(mesh, shape);
  PatchModelOptions patch = options.patch;
  patch.coarse_chroma = options.coarse_chroma();
  patches.emplace(mesh, shape, frames, patch, pixels_per_metre(*mesh, first.camera, first.camera_from_object));
}

/// Of the surface maps, for an image of such a camera.
MapSides LightFieldPipeline::map_sides(const Camera& camera, const Rigid3& camera_from_object) const {
  return map_resolution(*mesh, camera, camera_from_object,
                        {options.surface_map, options.min_surface_map, options.max_surface_map, options.map_scale});
}

/// From now on the maps have these sides; none: they stay. What was looked at before is seen on the old ones.
bool LightFieldPipeline::use(std::shared_ptr<const MapLayout> maps) {
  if (!maps) return false;
  visibility->use(*maps);
  constant_colour->use(maps);
  shape = std::move(maps);
  return true;
}

/// Surfaces that the image shows finer than any before it get finer maps. Whether any did: then one must look again.
bool LightFieldPipeline::refine_maps(const SurfaceView& view, const Beginning& here) {
  if (options.map_detail == 0 || options.surface_map > 0) return false;
  const double finer = pixels_per_metre(*mesh, here.camera, here.camera_from_object);
  return patches->may_refine(finer) &&
         use(patches->refine_maps(view, finer, map_sides(here.camera, here.camera_from_object)));
}

void LightFieldPipeline::coarsen_maps(const std::vector<std::uint32_t>& asked) {
  if (options.map_detail == 0 || squared_error == 0) return;
  use(patches->coarsen_maps(asked, options.map_detail, std::sqrt(squared_error)));
}

void LightFieldPipeline::follow_error(double predicted_psnr_db) {
  constexpr double kMemory = 0.8;
  if (!std::isfinite(predicted_psnr_db)) return;
  const double error = std::pow(10, -predicted_psnr_db / 10);
  squared_error = squared_error > 0 ? std::lerp(error, squared_error, kMemory) : error;
}

const SurfaceView& LightFieldPipeline::look(const Capture& capture) {
  return visibility->look(capture.camera, capture.pose.camera_from_object, usable_pixels(capture));
}

IngestReport LightFieldPipeline::ingest(const Capture& capture) {
  IngestReport report;
  const auto refuse = [&](const char* reason) {
    report.reason = reason;
    return report;
  };
  const auto done = [&](IngestStatus status) {
    report.status = status;
    return report;
  };
  if (!has_pose(capture.pose)) return refuse("no_pose");
  if (!sizes_agree(capture)) return refuse("image_size");
  const Beginning here{name_of(capture), capture.camera, capture.pose.camera_from_object, exposure_product(capture)};
  if (!beginning) start(here);  // a first image that shows nothing decides nothing

  StageClock clock(report.stage_ms);
  const SurfaceView& view = look(capture);
  if (view.visible_samples > 0 && !is_held_out(capture, options.hold_out_every) && refine_maps(view, here))
    look(capture);
  clock.done("visibility");
  if (view.visible_samples == 0) return refuse("object_not_in_view");

  if (!beginning) beginning = here;
  report.exposure_gain = known_gain(capture);
  if (is_held_out(capture, options.hold_out_every)) return done(IngestStatus::kHeldOut);

  image.load(capture, view);
  clock.done("decode");
  report.repeated = repeats_earlier_image(view, report);
  clock.done("repetition");
  if (report.repeated) return done(IngestStatus::kAccepted);

  const float gain = estimated_gain(capture, view);
  if (gain != 1) report.exposure_gain = gain;
  clock.done("exposure");
  std::vector<bool> taken = factorize(view, report);
  folded.add({name_of(capture),
              report.exposure_gain,
              std::log(gain),
              view.eye,
              {capture.camera, capture.pose.camera_from_object},
              std::move(taken)});
  follow_error(report.predicted_psnr_db);
  coarsen_maps(patches->shown_by(view));
  clock.done("factorize");
  return done(IngestStatus::kAccepted);
}

bool LightFieldPipeline::withdraw(const Capture& capture) {
  const ImageName name = name_of(capture);
  const FoldedImage* found = folded.find(name);
  if (!found || beginning->image == name) return false;
  const SurfaceView& view = look(capture);
  image.load(capture, view);
  patches->withdraw(divided_by(found->gain, view), found->taken, folded.count() - 1, *constant_colour);
  folded.erase(name);
  return true;
}

/// By what the camera reports, how much brighter the image is than the first one; 1 when that is unknown.
float LightFieldPipeline::known_gain(const Capture& capture) const {
  if (options.exposure == ExposureCompensation::kOff || beginning->exposure == 0) return 1;
  const double product = exposure_product(capture);
  return product > 0 ? static_cast<float>(product / beginning->exposure) : 1;
}

/// How much brighter an image of unknown exposure is than the model, from what all surfaces say.
float LightFieldPipeline::estimated_gain(const Capture& capture, const SurfaceView& view) const {
  const bool known = capture.exposure.locked || exposure_product(capture) > 0;
  if (options.exposure != ExposureCompensation::kEstimate || known) return 1;
  std::vector<float> ratios = constant_colour->log_ratios(divided_by(1, view));
  return robust_gain(ratios);
}

/// Whether an image from where an earlier one was taken shows nothing new. Decided on some of its patches, before the
/// others cost anything; with an exposure that only the whole image can tell it is not asked.
bool LightFieldPipeline::repeats_earlier_image(const SurfaceView& view, IngestReport& report) {
  const BoundingSphere bounds = bounding_sphere(*mesh);
  const double nearest_surface = std::max((view.eye - bounds.centre).norm() - bounds.radius, 0.0);
  if (options.exposure == ExposureCompensation::kEstimate ||
      !folded.any_nearer(view.eye, options.patch.repeat_angle * nearest_surface))
    return false;
  const std::vector<std::uint32_t> shown = patches->shown_by(view);
  std::vector<std::uint32_t> tested;
  for (std::size_t i = 0; i < shown.size(); i += kPatchesPerTested) tested.push_back(shown[i]);
  const std::size_t repeated = patches->count_repeated(tested, divided_by(report.exposure_gain, view));
  if (static_cast<double>(repeated) < kRepeatedFraction * static_cast<double>(tested.size())) return false;
  report.patches_skipped = shown.size();
  return true;
}

/// Of the patches that the image shows, the fraction for which its direction is newest.
std::vector<std::uint32_t> LightFieldPipeline::patches_to_update(const SurfaceView& view, IngestReport& report) const {
  std::vector<std::uint32_t> shown = patches->shown_by(view);
  const auto wanted = static_cast<std::size_t>(std::ceil(update_fraction * static_cast<double>(shown.size())));
  if (wanted >= shown.size()) return shown;
  report.patches_left_out = shown.size() - wanted;
  return patches->newest(shown, view, wanted);
}

/// Which patches took what they were shown; empty when all did.
std::vector<bool> LightFieldPipeline::factorize(const SurfaceView& view, IngestReport& report) {
  const std::vector<std::uint32_t> chosen = patches_to_update(view, report);
  const SurfaceImage shown = divided_by(report.exposure_gain, view);
  report.predicted_psnr_db = predicted_psnr_db(shown, chosen);
  const PatchSet::Update update = patches->absorb(chosen, shown, folded.count() + 1, *constant_colour);
  report.patches_updated = update.updated;
  report.patches_skipped = static_cast<std::size_t>(std::count(update.repeated.begin(), update.repeated.end(), 1));
  report.relative_residual = update.energy > 0 ? std::sqrt(update.residual_energy / update.energy) : 0;
  if (report.patches_skipped + report.patches_left_out == 0) return {};
  std::vector<bool> taken(patches->size(), false);
  for (std::size_t i = 0; i < chosen.size(); ++i) taken[chosen[i]] = !update.repeated[i];
  return taken;
}

/// PSNR of a few patches of the image, encoded, as predicted from the images before it; NaN where none came before.
double LightFieldPipeline::predicted_psnr_db(const SurfaceImage& shown,
                                             const std::vector<std::uint32_t>& chosen) const {
  const std::size_t stride = std::max<std::size_t>(1, chosen.size() / kPredictedPatches);
  std::vector<std::uint32_t> asked;  // others with every image
  for (std::size_t i = folded.count() % stride; i < chosen.size(); i += stride)
    if (patches->reached(chosen[i])) asked.push_back(chosen[i]);
  const PatchModel::Prediction predicted = patches->predict(asked, shown);
  if (predicted.values == 0) return std::numeric_limits<double>::quiet_NaN();
  return -10 * std::log10(predicted.squared_error / static_cast<double>(predicted.values));
}

}  // namespace sheen
