// SPDX-License-Identifier: Apache-2.0
#include "reconstructor/models/surface_light_field/surface_light_field.h"

#include <malloc.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>
#include <optional>
#include <stdexcept>
#include <tuple>
#include <utility>

#include "common/base/errors.h"
#include "common/base/stage_clock.h"
#include "reconstructor/models/surface_light_field/effort_levels.h"
#include "reconstructor/models/surface_light_field/folded_images.h"
#include "reconstructor/models/surface_light_field/memory_account.h"
#include "reconstructor/models/surface_light_field/patch_set.h"
#include "reconstructor/radiance/capture_rules.h"
#include "reconstructor/radiance/exposure_gain.h"
#include "reconstructor/radiance/resampling.h"
#include "reconstructor/surface/map_resolution.h"
#include "reconstructor/surface/view_hemisphere.h"

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

/// How an image goes through: what it shows is found, brought to one exposure, and folded into the patches that it
/// tells something new.
struct SurfaceLightField::Pipeline {
  Pipeline(std::shared_ptr<const Mesh> of_mesh, const SurfaceLightFieldOptions& chosen,
           std::shared_ptr<const RayScene> of_scene)
      : mesh(std::move(of_mesh)), scene(std::move(of_scene)), options(chosen) {}

  std::shared_ptr<const Mesh> mesh;
  std::shared_ptr<const RayScene> scene;
  SurfaceLightFieldOptions options;
  std::vector<Eigen::Matrix3f> frames;  ///< of the vertices' hemispheres

  /// The first image that shows something decides about maps and exposure.
  struct Beginning {
    ImageName image;
    Camera camera;
    Rigid3 camera_from_object;
    double exposure;  ///< its product, 0 when unknown
  };
  std::optional<Beginning> beginning;
  // From the first image on:
  std::shared_ptr<const MapLayout> shape;
  std::unique_ptr<SampleVisibility> visibility;
  std::shared_ptr<ConstantColour> constant_colour;
  std::optional<PatchSet> patches;
  double update_fraction = 1;  ///< of the patches that an image shows: those that it updates

  RadianceImage image;
  FoldedImages folded;
  double squared_error = 0;  ///< with which images are predicted, encoded: a running mean; 0: none was
  std::uint64_t version = 0;

  /// What the patches leave behind.
  struct Finished {
    ModelFigures figures;
    std::size_t snapshot_bytes;
    std::shared_ptr<const SurfaceLightFieldSnapshot> snapshot;
  };
  std::optional<Finished> finished;

  void start(const Beginning& first);
  IngestReport ingest(const Capture& capture);
  bool withdraw(const Capture& capture);

  MapSides map_sides(const Camera& camera, const Rigid3& camera_from_object) const;
  bool use(std::shared_ptr<const MapLayout> maps);
  bool refine_maps(const SurfaceView& view, const Beginning& here);
  void coarsen_maps(const std::vector<std::uint32_t>& asked);
  void follow_error(double predicted_psnr_db);
  const SurfaceView& look(const Capture& capture);
  SurfaceImage divided_by(float gain, const SurfaceView& view) const {
    return {image, view, *shape, gain, options.sampling};
  }
  float known_gain(const Capture& capture) const;
  float estimated_gain(const Capture& capture, const SurfaceView& view) const;
  bool repeats_earlier_image(const SurfaceView& view, IngestReport& report);
  std::vector<std::uint32_t> patches_to_update(const SurfaceView& view, IngestReport& report) const;
  std::vector<bool> factorize(const SurfaceView& view, IngestReport& report);
  double predicted_psnr_db(const SurfaceImage& shown, const std::vector<std::uint32_t>& chosen) const;

  ExposureField exposure_field() const { return folded.exposure_field(bounding_sphere(*mesh).centre.cast<float>()); }
};

void SurfaceLightField::Pipeline::start(const Beginning& first) {
  shape = std::make_shared<MapLayout>(map_sides(first.camera, first.camera_from_object));
  visibility = std::make_unique<SampleVisibility>(*mesh, *shape, options.visibility, scene);
  constant_colour = std::make_shared<ConstantColour>(mesh, shape);
  PatchModelOptions patch = options.patch;
  patch.coarse_chroma = options.map_detail > 0;
  patches.emplace(mesh, shape, frames, patch, pixels_per_metre(*mesh, first.camera, first.camera_from_object));
}

/// Of the surface maps, for an image of such a camera.
MapSides SurfaceLightField::Pipeline::map_sides(const Camera& camera, const Rigid3& camera_from_object) const {
  return map_resolution(*mesh, camera, camera_from_object,
                        {options.surface_map, options.min_surface_map, options.max_surface_map, options.map_scale});
}

/// From now on the maps have these sides; none: they stay. What was looked at before is seen on the old ones.
bool SurfaceLightField::Pipeline::use(std::shared_ptr<const MapLayout> maps) {
  if (!maps) return false;
  visibility->use(*maps);
  constant_colour->use(maps);
  shape = std::move(maps);
  return true;
}

/// Surfaces that the image shows finer than any before it get finer maps. Whether any did: then one must look again.
bool SurfaceLightField::Pipeline::refine_maps(const SurfaceView& view, const Beginning& here) {
  if (options.map_detail == 0 || options.surface_map > 0) return false;
  const double finer = pixels_per_metre(*mesh, here.camera, here.camera_from_object);
  return patches->may_refine(finer) &&
         use(patches->refine_maps(view, finer, map_sides(here.camera, here.camera_from_object)));
}

/// Patches of which nothing fine is displayed get coarser maps.
void SurfaceLightField::Pipeline::coarsen_maps(const std::vector<std::uint32_t>& asked) {
  if (options.map_detail == 0 || squared_error == 0) return;
  use(patches->coarsen_maps(asked, options.map_detail, std::sqrt(squared_error)));
}

void SurfaceLightField::Pipeline::follow_error(double predicted_psnr_db) {
  constexpr double kMemory = 0.8;
  if (!std::isfinite(predicted_psnr_db)) return;
  const double error = std::pow(10, -predicted_psnr_db / 10);
  squared_error = squared_error > 0 ? std::lerp(error, squared_error, kMemory) : error;
}

const SurfaceView& SurfaceLightField::Pipeline::look(const Capture& capture) {
  return visibility->look(capture.camera, capture.pose.camera_from_object, usable_pixels(capture));
}

IngestReport SurfaceLightField::Pipeline::ingest(const Capture& capture) {
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

bool SurfaceLightField::Pipeline::withdraw(const Capture& capture) {
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
float SurfaceLightField::Pipeline::known_gain(const Capture& capture) const {
  if (options.exposure == ExposureCompensation::kOff || beginning->exposure == 0) return 1;
  const double product = exposure_product(capture);
  return product > 0 ? static_cast<float>(product / beginning->exposure) : 1;
}

/// How much brighter an image of unknown exposure is than the model, from what all surfaces say.
float SurfaceLightField::Pipeline::estimated_gain(const Capture& capture, const SurfaceView& view) const {
  const bool known = capture.exposure.locked || exposure_product(capture) > 0;
  if (options.exposure != ExposureCompensation::kEstimate || known) return 1;
  std::vector<float> ratios = constant_colour->log_ratios(divided_by(1, view));
  return robust_gain(ratios);
}

/// Whether an image from where an earlier one was taken shows nothing new. Decided on some of its patches, before the
/// others cost anything; with an exposure that only the whole image can tell it is not asked.
bool SurfaceLightField::Pipeline::repeats_earlier_image(const SurfaceView& view, IngestReport& report) {
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
std::vector<std::uint32_t> SurfaceLightField::Pipeline::patches_to_update(const SurfaceView& view,
                                                                          IngestReport& report) const {
  std::vector<std::uint32_t> shown = patches->shown_by(view);
  const auto wanted = static_cast<std::size_t>(std::ceil(update_fraction * static_cast<double>(shown.size())));
  if (wanted >= shown.size()) return shown;
  report.patches_left_out = shown.size() - wanted;
  return patches->newest(shown, view, wanted);
}

/// Which patches took what they were shown; empty when all did.
std::vector<bool> SurfaceLightField::Pipeline::factorize(const SurfaceView& view, IngestReport& report) {
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
double SurfaceLightField::Pipeline::predicted_psnr_db(const SurfaceImage& shown,
                                                      const std::vector<std::uint32_t>& chosen) const {
  const std::size_t stride = std::max<std::size_t>(1, chosen.size() / kPredictedPatches);
  std::vector<std::uint32_t> asked;  // others with every image
  for (std::size_t i = folded.count() % stride; i < chosen.size(); i += stride)
    if (patches->reached(chosen[i])) asked.push_back(chosen[i]);
  const PatchModel::Prediction predicted = patches->predict(asked, shown);
  if (predicted.values == 0) return std::numeric_limits<double>::quiet_NaN();
  return -10 * std::log10(predicted.squared_error / static_cast<double>(predicted.values));
}

SurfaceLightField::SurfaceLightField(std::shared_ptr<const Mesh> mesh, const SurfaceLightFieldOptions& options,
                                     std::shared_ptr<const RayScene> scene)
    : asked_(options) {
  options.require_valid();
  if (!scene) scene = std::make_shared<const RayScene>(*mesh);
  pipeline_ = std::make_unique<Pipeline>(std::move(mesh), options, std::move(scene));
  const std::vector<Eigen::Vector3f> normals = vertex_normals(*pipeline_->mesh);
  pipeline_->frames.reserve(normals.size());
  for (const Eigen::Vector3f& normal : normals) pipeline_->frames.push_back(hemisphere_frame(normal));
}

SurfaceLightField::~SurfaceLightField() = default;

IngestReport SurfaceLightField::ingest(const Capture& capture) {
  if (pipeline_->finished) throw std::logic_error("surface light field: it is finished and takes no image");
  return pipeline_->ingest(capture);
}

bool SurfaceLightField::withdraw(const Capture& capture) {
  return !pipeline_->finished && pipeline_->withdraw(capture);
}

bool SurfaceLightField::began_with(const Capture& capture) const {
  return pipeline_->beginning && pipeline_->beginning->image == name_of(capture);
}

void SurfaceLightField::begin(const SurfaceLightFieldOptions& options) {
  auto fresh = std::make_unique<Pipeline>(pipeline_->mesh, options, pipeline_->scene);
  fresh->frames = std::move(pipeline_->frames);
  fresh->version = pipeline_->version;
  fresh->update_fraction = pipeline_->update_fraction;
  pipeline_ = std::move(fresh);
  memory_step_ = 0;
}

void SurfaceLightField::restart(int effort_level) {
  begin(at_effort_level(asked_, effort_level));
}

void SurfaceLightField::rebuild(int effort_level) {
  std::optional<Pipeline::Beginning> beginning = std::move(pipeline_->beginning);
  restart(effort_level);
  pipeline_->beginning = std::move(beginning);
  if (pipeline_->beginning) pipeline_->start(*pipeline_->beginning);
}

int SurfaceLightField::effort_level_within(const Capture& first, int from, const MemoryLimit& limit) const {
  SurfaceLightFieldOptions seen = asked_;
  seen.patch.max_views =
      static_cast<int>(std::min<std::size_t>(static_cast<std::size_t>(seen.patch.max_views), limit.images));
  return finest_level(*pipeline_->mesh, first, seen, from, limit);
}

bool SurfaceLightField::reduce_memory() {
  const std::size_t details = memory_details().size();
  if (memory_step_ == details + memory_steps().size()) return false;
  const std::size_t step = memory_step_++;
  if (step < details) {
    limit_detail(memory_details()[step]);
    return true;
  }
  const TermLimit& limit = memory_steps()[step - details];
  limit_terms(limit.max_rank, limit.internal_rank, limit.block);
  return true;
}

const SurfaceLightFieldOptions& SurfaceLightField::settings() const {
  return pipeline_->options;
}

void SurfaceLightField::set_update_fraction(double fraction) {
  pipeline_->update_fraction = std::clamp(fraction, 0.01, 1.0);
}

/// Maps that shall stay as they are do.
void SurfaceLightField::limit_detail(double map_detail) {
  Pipeline& p = *pipeline_;
  if (p.options.map_detail == 0 || p.options.map_detail >= map_detail) return;
  p.options.map_detail = map_detail;
  if (!p.patches) return;
  p.patches->settle_maps();
  std::vector<std::uint32_t> all(p.patches->size());
  std::iota(all.begin(), all.end(), 0u);
  p.coarsen_maps(all);
}

void SurfaceLightField::limit_terms(int max_rank, int internal_rank, int block) {
  OnlineSvdOptions& factor = pipeline_->options.patch.factor;
  factor = factor.limited_to(max_rank, internal_rank, block);
  if (pipeline_->patches) pipeline_->patches->limit_terms(max_rank, internal_rank, block);
}

std::shared_ptr<const SurfaceLightFieldSnapshot> SurfaceLightField::light_field_snapshot() {
  Pipeline& p = *pipeline_;
  if (p.finished) {
    if (!p.finished->snapshot) throw std::logic_error("surface light field: its snapshot was given away");
    return p.finished->snapshot;
  }
  if (!p.patches) {  // nothing seen yet: an empty light field on the coarsest maps
    const std::vector<std::uint8_t> coarse(p.mesh->triangles.size(), 2);
    auto maps = std::make_shared<MapLayout>(coarse);
    auto shapes = std::make_shared<const PatchShapes>(cut_into_patches(*p.mesh, *maps, p.options.patch.size));
    SurfaceLightFieldSnapshot::Patches none(shapes->patches.size());
    return std::make_shared<SurfaceLightFieldSnapshot>(p.mesh, std::move(maps), std::move(shapes), std::move(none),
                                                       p.version++);
  }
  return std::make_shared<SurfaceLightFieldSnapshot>(p.mesh, p.shape, p.patches->shapes(), p.patches->snapshots(),
                                                     p.version++, p.exposure_field(), p.folded.cameras());
}

void SurfaceLightField::finish() {
  Pipeline& p = *pipeline_;
  if (!p.patches) return;
  p.finished = {figures(), snapshot_bytes(), nullptr};
  p.visibility.reset();
  p.image = {};
  p.finished->snapshot = std::make_shared<SurfaceLightFieldSnapshot>(
      p.mesh, p.shape, p.patches->shapes(), p.patches->finish(), p.version++, p.exposure_field(), p.folded.cameras());
  p.patches.reset();
  // What images took lies scattered between what is kept, where little of what follows has room.
  malloc_trim(0);
}

std::shared_ptr<const ModelSnapshot> SurfaceLightField::give_snapshot() {
  std::shared_ptr<const ModelSnapshot> given = light_field_snapshot();
  if (pipeline_->finished) pipeline_->finished->snapshot.reset();
  return given;
}

std::shared_ptr<const Appearance> SurfaceLightField::constant_colour() const {
  const Pipeline& p = *pipeline_;
  if (p.finished) return appearance_of(p.constant_colour, p.exposure_field());  // which no image changes any more
  if (p.constant_colour)
    return appearance_of(std::make_shared<const ConstantColour>(*p.constant_colour), p.exposure_field());
  const std::vector<std::uint8_t> coarse(p.mesh->triangles.size(), 2);
  return appearance_of(std::make_shared<const ConstantColour>(p.mesh, std::make_shared<MapLayout>(coarse)));
}

ModelFigures SurfaceLightField::figures() const {
  if (pipeline_->finished) return pipeline_->finished->figures;
  ModelFigures figures{.images = pipeline_->folded.count(), .bytes = bytes()};
  if (pipeline_->patches) figures.rank_histogram = pipeline_->patches->rank_histogram();
  const auto reached = std::reduce(figures.rank_histogram.begin(), figures.rank_histogram.end());
  if (reached > 0) figures.bytes_per_patch = static_cast<double>(figures.bytes) / static_cast<double>(reached);
  return figures;
}

MemoryAccount SurfaceLightField::memory(const CaptureSize& image) const {
  constexpr double kSnapshots = 2;  // the one that is shown, and the one that follows
  MemoryAccount account;
  if (maps()) account = fixed_account(*pipeline_->mesh, *maps(), image);
  account.model = static_cast<double>(bytes());
  account.snapshots = kSnapshots * static_cast<double>(snapshot_bytes());
  return account;
}

std::size_t SurfaceLightField::bytes() const {
  if (pipeline_->finished) return pipeline_->finished->figures.bytes;
  return pipeline_->patches ? pipeline_->patches->bytes() : 0;
}

std::size_t SurfaceLightField::snapshot_bytes() const {
  if (pipeline_->finished) return pipeline_->finished->snapshot_bytes;
  return pipeline_->patches ? pipeline_->patches->snapshot_bytes() : 0;
}

const MapLayout* SurfaceLightField::maps() const {
  return pipeline_->shape.get();
}

}  // namespace sheen
