// SPDX-License-Identifier: Apache-2.0
#include "reconstructor/models/surface_light_field/surface_light_field.h"

#include <malloc.h>

#include <algorithm>
#include <numeric>
#include <optional>
#include <stdexcept>
#include <utility>

#include "reconstructor/models/surface_light_field/effort_levels.h"
#include "reconstructor/models/surface_light_field/light_field_pipeline.h"
#include "reconstructor/models/surface_light_field/memory_account.h"
#include "reconstructor/surface/view_hemisphere.h"

namespace sheen {

SurfaceLightField::SurfaceLightField(std::shared_ptr<const Mesh> mesh, const SurfaceLightFieldOptions& options,
                                     std::shared_ptr<const RayScene> scene)
    : asked_(options) {
  options.require_valid();
  if (!scene) scene = std::make_shared<const RayScene>(*mesh);
  pipeline_ = std::make_unique<LightFieldPipeline>(std::move(mesh), options, std::move(scene));
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
  auto fresh = std::make_unique<LightFieldPipeline>(pipeline_->mesh, options, pipeline_->scene);
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
  std::optional<LightFieldPipeline::Beginning> beginning = std::move(pipeline_->beginning);
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
  limit_patches(memory_steps()[step - details]);
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
  LightFieldPipeline& p = *pipeline_;
  if (p.options.map_detail == 0 || p.options.map_detail >= map_detail) return;
  p.options.map_detail = map_detail;
  if (!p.patches) return;
  p.patches->settle_maps();
  std::vector<std::uint32_t> all(p.patches->size());
  std::iota(all.begin(), all.end(), 0u);
  p.coarsen_maps(all);
}

void SurfaceLightField::limit_patches(const PatchLimit& limit) {
  pipeline_->options.patch = pipeline_->options.patch.limited_to(limit);
  if (pipeline_->patches) pipeline_->patches->limit(limit);
}

std::shared_ptr<const SurfaceLightFieldSnapshot> SurfaceLightField::light_field_snapshot() {
  LightFieldPipeline& p = *pipeline_;
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
                                                       p.version++, ExposureField{}, std::vector<PosedCamera>{},
                                                       p.options.guidance);
  }
  return std::make_shared<SurfaceLightFieldSnapshot>(p.mesh, p.shape, p.patches->shapes(), p.patches->snapshots(),
                                                     p.version++, p.exposure_field(), p.folded.cameras(),
                                                     p.options.guidance);
}

void SurfaceLightField::finish() {
  LightFieldPipeline& p = *pipeline_;
  if (!p.patches) return;
  p.finished = {figures(), health(), snapshot_bytes(), nullptr};
  p.visibility.reset();
  p.image = {};
  p.finished->snapshot = std::make_shared<SurfaceLightFieldSnapshot>(
      p.mesh, p.shape, p.patches->shapes(), p.patches->finish(), p.version++, p.exposure_field(), p.folded.cameras(),
      p.options.guidance);
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
  const LightFieldPipeline& p = *pipeline_;
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

NumericalHealth SurfaceLightField::health() const {
  if (pipeline_->finished) return pipeline_->finished->health;
  return pipeline_->patches ? pipeline_->patches->health() : NumericalHealth{};
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
