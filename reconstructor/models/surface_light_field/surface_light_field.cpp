// SPDX-License-Identifier: Apache-2.0
#include "reconstructor/models/surface_light_field/surface_light_field.h"

#include <tbb/blocked_range.h>
#include <tbb/parallel_for.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>
#include <string>
#include <tuple>
#include <utility>

#include "common/base/errors.h"
#include "common/base/stage_clock.h"
#include "reconstructor/models/surface_light_field/effort_levels.h"
#include "reconstructor/models/surface_light_field/interpolation_upkeep.h"
#include "reconstructor/models/surface_light_field/memory_account.h"
#include "reconstructor/models/surface_light_field/ring_column.h"
#include "reconstructor/radiance/capture_rules.h"
#include "reconstructor/radiance/exposure_field.h"
#include "reconstructor/radiance/exposure_gain.h"
#include "reconstructor/radiance/ring_resampler.h"
#include "reconstructor/surface/map_resolution.h"
#include "reconstructor/surface/view_hemisphere.h"

namespace sheen {
namespace {

// An image that may repeat an earlier one is decided on one ring of so many; by so many of those.
constexpr std::size_t kRingsPerTested = 16;
constexpr double kRepeatedShare = 0.95;
constexpr std::size_t kForetoldRings = 16;  // an image: each costs a solve

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

/// What tells images apart.
using ImageName = std::pair<std::string, std::uint64_t>;

ImageName name_of(const Capture& capture) {
  return {capture.source_session, capture.sequence};
}

}  // namespace

struct SurfaceLightField::Pipeline {
  Pipeline(std::shared_ptr<const Mesh> of_mesh, const SurfaceLightFieldOptions& chosen,
           std::shared_ptr<const RayScene> of_scene)
      : mesh(std::move(of_mesh)),
        scene(std::move(of_scene)),
        options(chosen),
        interpolation(*mesh, options.ring.interpolation) {}

  std::shared_ptr<const Mesh> mesh;
  std::shared_ptr<const RayScene> scene;
  SurfaceLightFieldOptions options;
  std::vector<Eigen::Matrix3f> frames;  ///< of the vertices' hemispheres

  // From the first image on:
  std::shared_ptr<const VertexRings> rings;
  std::unique_ptr<RingVisibility> visibility;
  std::unique_ptr<ConstantColour> constant_colour;
  std::vector<std::unique_ptr<RingModel>> ring_models;  ///< null until an image shows enough of the ring
  double share = 1;                                     ///< of the rings that an image shows: those that it updates

  RadianceImage image;
  Eigen::Matrix3Xf samples;  ///< encoded values of the current image
  InterpolationUpkeep interpolation;
  struct Folded {
    ImageName name;
    float gain;      ///< that its values were divided by
    float log_gain;  ///< estimated; 0 where the gain is known
    Eigen::Vector3d eye;
    std::vector<bool> taken;  ///< a ring: whether it took what it was shown; empty when all did
  };
  std::vector<Folded> folded;
  /// The first image that shows something decides about maps and exposure.
  struct Beginning {
    ImageName image;
    Camera camera;
    Rigid3 camera_from_object;
    double exposure;  ///< its product, 0 when unknown
  };
  std::optional<Beginning> beginning;
  std::uint64_t version = 0;

  void start(const Beginning& first);
  IngestReport ingest(const Capture& capture);
  bool withdraw(const Capture& capture);
  float known_gain(const Capture& capture) const;
  float estimated_gain(const Capture& capture, const SurfaceView& view) const;
  ExposureField exposure_field() const;
  std::vector<std::uint32_t> shown_rings(const SurfaceView& view) const;
  bool repeats_earlier_image(const SurfaceView& view, IngestReport& report);
  std::vector<std::uint32_t> rings_to_update(const SurfaceView& view, IngestReport& report) const;
  std::vector<bool> absorb(const SurfaceView& view, IngestReport& report);
  double foretold_psnr_db(const SurfaceView& view, const std::vector<std::uint32_t>& shown) const;
};

void SurfaceLightField::Pipeline::start(const Beginning& first) {
  rings = std::make_shared<VertexRings>(*mesh, map_resolution(*mesh, first.camera, first.camera_from_object,
                                                              {options.surface_map, options.min_surface_map,
                                                               options.max_surface_map, options.map_scale}));
  visibility = std::make_unique<RingVisibility>(*mesh, *rings, options.visibility, scene);
  constant_colour = std::make_unique<ConstantColour>(mesh, rings);
  ring_models.resize(mesh->vertices.size());
}

IngestReport SurfaceLightField::Pipeline::ingest(const Capture& capture) {
  IngestReport report;
  const auto refuse = [&](const char* reason) {
    report.reason = reason;
    return report;
  };
  if (!has_pose(capture.pose)) return refuse("no_pose");
  if (!sizes_agree(capture)) return refuse("image_size");
  const Beginning here{name_of(capture), capture.camera, capture.pose.camera_from_object, exposure_product(capture)};
  if (!beginning) start(here);  // a first image that shows nothing decides nothing

  StageClock clock(report.stage_ms);
  const SurfaceView& view = visibility->look(capture.camera, capture.pose.camera_from_object, usable_pixels(capture));
  clock.done("visibility");
  if (view.visible_samples == 0) return refuse("object_not_in_view");

  if (!beginning) beginning = here;
  report.exposure_gain = known_gain(capture);
  if (is_held_out(capture, options.hold_out_every)) {
    report.status = IngestStatus::kHeldOut;
    return report;
  }

  image.load(capture, view);
  clock.done("decode");
  if (repeats_earlier_image(view, report)) {
    clock.done("resample");
    report.status = IngestStatus::kAccepted;
    report.repeated = true;
    return report;
  }
  resample(image, view, *rings, report.exposure_gain, samples, options.sampling);
  clock.done("resample");
  const float gain = estimated_gain(capture, view);
  if (gain != 1) {
    report.exposure_gain = gain;
    resample(image, view, *rings, gain, samples, options.sampling);
  }
  clock.done("exposure");
  constant_colour->add(view, samples);
  std::vector<bool> taken = absorb(view, report);
  clock.done("factorize");
  folded.push_back({name_of(capture), report.exposure_gain, std::log(gain), view.eye, std::move(taken)});
  report.status = IngestStatus::kAccepted;
  return report;
}

bool SurfaceLightField::Pipeline::withdraw(const Capture& capture) {
  const ImageName name = name_of(capture);
  const auto found = std::find_if(folded.begin(), folded.end(), [&](const Folded& f) { return f.name == name; });
  if (found == folded.end() || beginning->image == name) return false;
  const SurfaceView& view = visibility->look(capture.camera, capture.pose.camera_from_object, usable_pixels(capture));
  image.load(capture, view);
  resample(image, view, *rings, found->gain, samples, options.sampling);
  constant_colour->remove(view, samples);
  tbb::parallel_for(tbb::blocked_range<std::size_t>(0, ring_models.size(), 32), [&](const auto& range) {
    RingColumn column;
    for (std::size_t v = range.begin(); v < range.end(); ++v)
      if ((found->taken.empty() ? ring_models[v] != nullptr : found->taken[v]) &&
          gather(*rings, v, mesh->vertices[v], view, samples, column))
        ring_models[v]->withdraw(column.values, column.visible, column.direction);
  });
  folded.erase(found);
  interpolation.anew(folded.size(), frames, ring_models);
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
  std::vector<float> ratios = constant_colour->log_ratios(view, samples);
  return robust_gain(ratios);
}

ExposureField SurfaceLightField::Pipeline::exposure_field() const {
  std::vector<Eigen::Vector3d> eyes;
  std::vector<float> log_gains;
  for (const Folded& image : folded) {
    eyes.push_back(image.eye);
    log_gains.push_back(image.log_gain);
  }
  return interpolated_exposure(bounding_sphere(*mesh).centre.cast<float>(), eyes, log_gains);
}

std::vector<std::uint32_t> SurfaceLightField::Pipeline::shown_rings(const SurfaceView& view) const {
  std::vector<std::uint32_t> shown;
  for (std::size_t v = 0; v < rings->size(); ++v) {
    const auto ring = rings->ring(v);
    if (std::any_of(ring.begin(), ring.end(),
                    [&](const RingTriangle& member) { return view.visible_in_triangle[member.triangle] > 0; }))
      shown.push_back(static_cast<std::uint32_t>(v));
  }
  return shown;
}

/// Whether an image from where an earlier one was taken shows nothing new. Decided on some of its rings, before the
/// others cost anything; with an exposure that only the whole image can tell it is not asked.
bool SurfaceLightField::Pipeline::repeats_earlier_image(const SurfaceView& view, IngestReport& report) {
  const BoundingSphere bounds = bounding_sphere(*mesh);
  const double nearest_surface = std::max((view.eye - bounds.centre).norm() - bounds.radius, 0.0);
  const double near = options.ring.repeat_angle * nearest_surface;
  if (options.exposure == ExposureCompensation::kEstimate ||
      std::none_of(folded.begin(), folded.end(), [&](const Folded& f) { return (f.eye - view.eye).norm() < near; }))
    return false;
  const std::vector<std::uint32_t> shown = shown_rings(view);
  std::vector<std::uint32_t> tested, triangles;
  for (std::size_t i = 0; i < shown.size(); i += kRingsPerTested) {
    tested.push_back(shown[i]);
    for (const RingTriangle& member : rings->ring(shown[i])) triangles.push_back(member.triangle);
  }
  std::sort(triangles.begin(), triangles.end());
  triangles.erase(std::unique(triangles.begin(), triangles.end()), triangles.end());
  resample(image, view, *rings, triangles, report.exposure_gain, samples, options.sampling);
  RingColumn column;
  const auto repeated = std::count_if(tested.begin(), tested.end(), [&](std::uint32_t v) {
    return ring_models[v] && gather(*rings, v, mesh->vertices[v], view, samples, column) &&
           ring_models[v]->repeats(column.values, column.visible, column.direction);
  });
  if (static_cast<double>(repeated) < kRepeatedShare * static_cast<double>(tested.size())) return false;
  report.patches_skipped = shown.size();
  return true;
}

/// Of the rings that the image shows, the share for which its direction is newest.
std::vector<std::uint32_t> SurfaceLightField::Pipeline::rings_to_update(const SurfaceView& view,
                                                                        IngestReport& report) const {
  std::vector<std::uint32_t> shown = shown_rings(view);
  const auto wanted = static_cast<std::size_t>(std::ceil(share * static_cast<double>(shown.size())));
  if (wanted >= shown.size()) return shown;
  std::vector<std::pair<float, std::uint32_t>> by_novelty(shown.size());
  tbb::parallel_for(std::size_t{0}, shown.size(), [&](std::size_t i) {
    const std::uint32_t v = shown[i];
    const Eigen::Vector3f direction = (view.eye.cast<float>() - mesh->vertices[v]).normalized();
    by_novelty[i] = {ring_models[v] ? ring_models[v]->nearest_cosine(direction) : -2.0f, v};
  });
  std::nth_element(by_novelty.begin(), by_novelty.begin() + static_cast<std::ptrdiff_t>(wanted), by_novelty.end());
  report.patches_left_out = shown.size() - wanted;
  shown.resize(wanted);
  for (std::size_t i = 0; i < wanted; ++i) shown[i] = by_novelty[i].second;
  std::sort(shown.begin(), shown.end());
  return shown;
}

/// Which rings took what they were shown; empty when all did.
std::vector<bool> SurfaceLightField::Pipeline::absorb(const SurfaceView& view, IngestReport& report) {
  const std::vector<std::uint32_t> chosen = rings_to_update(view, report);
  report.foretold_psnr_db = foretold_psnr_db(view, chosen);
  std::vector<RingModel::Absorbed> absorbed(chosen.size());
  std::vector<std::uint8_t> repeated(chosen.size(), 0);
  tbb::parallel_for(tbb::blocked_range<std::size_t>(0, chosen.size(), 16), [&](const auto& range) {
    RingColumn column;
    for (std::size_t i = range.begin(); i < range.end(); ++i) {
      const std::uint32_t v = chosen[i];
      gather(*rings, v, mesh->vertices[v], view, samples, column);
      std::unique_ptr<RingModel>& ring = ring_models[v];
      if (!ring) ring = std::make_unique<RingModel>(rings->ring_samples(v), options.ring, v);
      repeated[i] = ring->repeats(column.values, column.visible, column.direction);
      if (!repeated[i])
        absorbed[i] = ring->absorb(column.values, column.visible, column.direction, column.cosine, column.cosine);
    }
  });
  report.patches_skipped = static_cast<std::size_t>(std::count(repeated.begin(), repeated.end(), 1));
  double energy = 0, residual = 0;
  std::vector<std::uint32_t> undecided;
  for (std::size_t i = 0; i < absorbed.size(); ++i) {
    if (!absorbed[i].used) continue;
    ++report.patches_updated;
    energy += absorbed[i].energy;
    residual += absorbed[i].residual_energy;
    if (absorbed[i].wants_interpolation) undecided.push_back(chosen[i]);
  }
  report.relative_residual = energy > 0 ? std::sqrt(residual / energy) : 0;
  interpolation.after_image(folded.size() + 1, undecided, frames, ring_models);
  if (report.patches_skipped + report.patches_left_out == 0) return {};
  std::vector<bool> taken(ring_models.size(), false);
  for (std::size_t i = 0; i < chosen.size(); ++i) taken[chosen[i]] = !repeated[i];
  return taken;
}

/// PSNR of a few rings of the image, encoded, as foretold from the images before it; NaN where none came before.
double SurfaceLightField::Pipeline::foretold_psnr_db(const SurfaceView& view,
                                                     const std::vector<std::uint32_t>& shown) const {
  const std::size_t stride = std::max<std::size_t>(1, shown.size() / kForetoldRings);
  std::vector<std::uint32_t> asked;  // others with every image
  for (std::size_t i = folded.size() % stride; i < shown.size(); i += stride)
    if (ring_models[shown[i]]) asked.push_back(shown[i]);
  std::vector<RingModel::Foretold> foretold(asked.size());
  tbb::parallel_for(std::size_t{0}, asked.size(), [&](std::size_t i) {
    const std::uint32_t v = asked[i];
    RingColumn column;
    if (gather(*rings, v, mesh->vertices[v], view, samples, column))
      foretold[i] = ring_models[v]->foretell(column.values, column.visible, column.direction, frames[v].row(2));
  });
  RingModel::Foretold all;
  for (const RingModel::Foretold& ring : foretold) {
    all.squared_error += ring.squared_error;
    all.values += ring.values;
  }
  if (all.values == 0) return std::numeric_limits<double>::quiet_NaN();
  return -10 * std::log10(all.squared_error / static_cast<double>(all.values));
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
  return pipeline_->ingest(capture);
}

bool SurfaceLightField::withdraw(const Capture& capture) {
  return pipeline_->withdraw(capture);
}

bool SurfaceLightField::began_with(const Capture& capture) const {
  return pipeline_->beginning && pipeline_->beginning->image == name_of(capture);
}

void SurfaceLightField::begin(const SurfaceLightFieldOptions& options) {
  auto fresh = std::make_unique<Pipeline>(pipeline_->mesh, options, pipeline_->scene);
  fresh->frames = std::move(pipeline_->frames);
  fresh->version = pipeline_->version;
  fresh->share = pipeline_->share;
  pipeline_ = std::move(fresh);
  memory_step_ = 0;
}

void SurfaceLightField::restart(int effort_level) {
  begin(at_rung(asked_, effort_level));
}

void SurfaceLightField::rebuild(int effort_level) {
  std::optional<Pipeline::Beginning> beginning = std::move(pipeline_->beginning);
  restart(effort_level);
  pipeline_->beginning = std::move(beginning);
  if (pipeline_->beginning) pipeline_->start(*pipeline_->beginning);
}

int SurfaceLightField::effort_level_within(const Capture& first, int from, double bytes) const {
  return finest_rung(*pipeline_->mesh, first, asked_, from, bytes);
}

bool SurfaceLightField::reduce_memory() {
  if (memory_step_ == memory_steps().size()) return false;
  const TermLimit& limit = memory_steps()[memory_step_++];
  limit_terms(limit.max_rank, limit.internal_rank, limit.block);
  return true;
}

const SurfaceLightFieldOptions& SurfaceLightField::settings() const {
  return pipeline_->options;
}

void SurfaceLightField::set_update_fraction(double fraction) {
  pipeline_->share = std::clamp(fraction, 0.01, 1.0);
}

void SurfaceLightField::limit_terms(int max_rank, int internal_rank, int block) {
  RingFactorOptions& factor = pipeline_->options.ring.factor;
  factor = factor.limited_to(max_rank, internal_rank, block);
  std::vector<std::unique_ptr<RingModel>>& rings = pipeline_->ring_models;
  tbb::parallel_for(tbb::blocked_range<std::size_t>(0, rings.size(), 32), [&](const auto& range) {
    for (std::size_t v = range.begin(); v < range.end(); ++v)
      if (rings[v]) rings[v]->limit_terms(max_rank, internal_rank, block);
  });
}

std::shared_ptr<const SurfaceLightFieldSnapshot> SurfaceLightField::light_field_snapshot() {
  Pipeline& p = *pipeline_;
  if (!p.rings) {  // nothing seen yet: an empty light field on the coarsest maps
    const std::vector<std::uint8_t> coarse(p.mesh->triangles.size(), 2);
    return std::make_shared<SurfaceLightFieldSnapshot>(
        p.mesh, std::make_shared<VertexRings>(*p.mesh, coarse),
        std::vector<std::shared_ptr<const RingSnapshot>>(p.mesh->vertices.size()), p.version++);
  }
  std::vector<std::shared_ptr<const RingSnapshot>> data(p.ring_models.size());
  tbb::parallel_for(tbb::blocked_range<std::size_t>(0, data.size(), 32), [&](const auto& range) {
    std::vector<int> resolution;
    for (std::size_t v = range.begin(); v < range.end(); ++v) {
      if (!p.ring_models[v]) continue;
      resolution.clear();
      for (const RingTriangle& member : p.rings->ring(v)) resolution.push_back(p.rings->resolution(member.triangle));
      data[v] = p.ring_models[v]->snapshot(p.frames[v], resolution);
    }
  });
  return std::make_shared<SurfaceLightFieldSnapshot>(p.mesh, p.rings, std::move(data), p.version++, p.exposure_field());
}

std::shared_ptr<const Appearance> SurfaceLightField::constant_colour() const {
  if (pipeline_->constant_colour) return pipeline_->constant_colour->snapshot(pipeline_->exposure_field());
  const std::vector<std::uint8_t> coarse(pipeline_->mesh->triangles.size(), 2);
  return ConstantColour(pipeline_->mesh, std::make_shared<VertexRings>(*pipeline_->mesh, coarse)).snapshot();
}

ModelFigures SurfaceLightField::figures() const {
  ModelFigures figures{.images = pipeline_->folded.size(), .bytes = bytes()};
  std::size_t reached = 0;
  for (const auto& ring : pipeline_->ring_models) {
    if (!ring || ring->views() == 0) continue;
    ++reached;
    const auto rank = static_cast<std::size_t>(ring->rank());
    if (figures.rank_histogram.size() <= rank) figures.rank_histogram.resize(rank + 1, 0);
    ++figures.rank_histogram[rank];
  }
  if (reached > 0) figures.bytes_per_patch = static_cast<double>(figures.bytes) / static_cast<double>(reached);
  return figures;
}

MemoryAccount SurfaceLightField::memory(const CaptureSize& image) const {
  constexpr double kSnapshots = 2;  // the one that is shown, and the one that follows
  MemoryAccount account;
  if (rings()) account = fixed_account(*pipeline_->mesh, *rings(), image);
  account.model = static_cast<double>(bytes());
  account.snapshots = kSnapshots * static_cast<double>(snapshot_bytes());
  return account;
}

std::size_t SurfaceLightField::bytes() const {
  std::size_t bytes = 0;
  for (const auto& ring : pipeline_->ring_models)
    if (ring) bytes += ring->bytes();
  return bytes;
}

std::size_t SurfaceLightField::snapshot_bytes() const {
  std::size_t bytes = 0;
  for (const auto& ring : pipeline_->ring_models)
    if (ring) bytes += ring->snapshot_bytes();
  return bytes;
}

const VertexRings* SurfaceLightField::rings() const {
  return pipeline_->rings.get();
}

}  // namespace sheen
