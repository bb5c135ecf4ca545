// SPDX-License-Identifier: Apache-2.0
#include "reconstructor/models/surface_light_field/surface_light_field.h"

#include <tbb/blocked_range.h>
#include <tbb/parallel_for.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <limits>
#include <optional>
#include <string>
#include <tuple>
#include <utility>

#include "common/errors.h"
#include "reconstructor/models/surface_light_field/capture_rules.h"
#include "reconstructor/models/surface_light_field/exposure_gain.h"
#include "reconstructor/models/surface_light_field/ring_column.h"
#include "reconstructor/models/surface_light_field/ring_resampler.h"
#include "reconstructor/surface/map_resolution.h"

namespace sheen {
namespace {

// An image that may repeat an earlier one is decided on one ring of so many; by so many of those.
constexpr std::size_t kRingsPerTested = 16;
constexpr double kRepeatedShare = 0.95;

/// Writes the time since the last call under a stage's name.
class StageClock {
 public:
  explicit StageClock(IngestReport& report) : report_(report) {}
  void done(const char* stage) {
    const auto now = std::chrono::steady_clock::now();
    report_.stage_ms[stage] += std::chrono::duration<double, std::milli>(now - last_).count();
    last_ = now;
  }

 private:
  IngestReport& report_;
  std::chrono::steady_clock::time_point last_ = std::chrono::steady_clock::now();
};

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

void require_valid(const SurfaceLightFieldOptions& options) {
  const auto require = [](bool holds, const char* rule) {
    if (!holds) throw ConfigError(std::string("surface light field: ") + rule);
  };
  require(options.surface_map == 0 || (options.surface_map >= 2 && options.surface_map <= 64),
          "surface_map must be 0 (chosen from the footprint) or 2..64");
  require(options.map_scale > 0 && options.map_scale <= 4, "map_scale must be in (0, 4]");
  require(options.ring.repeat_angle >= 0 && options.ring.repeat_angle < 0.5, "repeat_angle must be in [0, 0.5) rad");
  require(options.hold_out_every >= 0 && options.hold_out_every != 1,
          "hold_out_every must be 0 (none) or at least 2: with 1 nothing would be left to learn from");
  require(options.ring.factor.max_rank >= 1 && options.ring.factor.max_rank <= 64, "max_rank must be 1..64");
  require(
      options.ring.factor.internal_rank == 0 || (options.ring.factor.internal_rank >= options.ring.factor.max_rank &&
                                                 options.ring.factor.internal_rank <= 64),
      "internal_rank must be 0 (chosen from max_rank) or max_rank..64");
  require(options.ring.factor.block >= 1 && options.ring.factor.block <= 32, "block must be 1..32");
  require(options.ring.factor.tolerance >= 0 && options.ring.factor.tolerance < 1, "tolerance must be in [0, 1)");
  require(options.ring.min_visible >= 0 && options.ring.min_visible <= 1, "min_visible must be in [0, 1]");
  require(options.ring.max_views >= 8 && options.ring.max_views <= 1000, "max_views must be 8..1000");
  require(options.visibility.erosion_px >= 0 && options.visibility.erosion_px <= 32, "erosion_px must be 0..32");
}

}  // namespace

struct SurfaceLightField::Pipeline {
  std::shared_ptr<const Mesh> mesh;
  SurfaceLightFieldOptions options;
  std::vector<Eigen::Matrix3f> frames;  ///< of the vertices' hemispheres

  // From the first image on:
  std::shared_ptr<const VertexRings> rings;
  std::unique_ptr<RingVisibility> visibility;
  std::unique_ptr<ConstantColour> constant_colour;
  std::vector<std::unique_ptr<RingModel>> ring_models;  ///< null until an image shows enough of the ring
  double reference_exposure = 0;
  double share = 1;  ///< of the rings that an image shows: those that it updates

  RadianceImage image;
  Eigen::Matrix3Xf samples;  ///< encoded values of the current image
  InterpolationChoice choice;
  std::shared_ptr<const ReflectionDrift> reflection;
  std::size_t reflection_estimated_at = 0;  ///< images folded in
  struct Folded {
    ImageName name;
    float log_gain;  ///< estimated; 0 where the gain is known
    Eigen::Vector3d eye;
    bool whole = true;  ///< false: some rings that it shows skipped it or were left out
  };
  std::vector<Folded> folded;
  std::optional<ImageName> first;  ///< image that showed something: it has decided about maps and exposure
  std::uint64_t version = 0;

  void start(const Capture& first);
  IngestReport ingest(const Capture& capture);
  bool withdraw(const Capture& capture);
  float known_gain(const Capture& capture) const;
  float estimated_gain(const Capture& capture, const SurfaceView& view) const;
  ExposureField exposure_field() const;
  std::vector<std::uint32_t> shown_rings(const SurfaceView& view) const;
  bool repeats_earlier_image(const SurfaceView& view, IngestReport& report);
  std::vector<std::uint32_t> rings_to_update(const SurfaceView& view, IngestReport& report) const;
  void absorb(const SurfaceView& view, IngestReport& report);
  void choose_interpolation(const std::vector<std::uint32_t>& undecided);
  bool reflection_is_due(std::size_t images) const;
  void estimate_reflection(std::size_t images);
};

void SurfaceLightField::Pipeline::start(const Capture& first) {
  rings = std::make_shared<VertexRings>(*mesh, map_resolution(*mesh, first.camera, first.pose.camera_from_object,
                                                              {options.surface_map, options.min_surface_map,
                                                               options.max_surface_map, options.map_scale}));
  visibility = std::make_unique<RingVisibility>(*mesh, *rings, options.visibility);
  constant_colour = std::make_unique<ConstantColour>(mesh, rings);
  ring_models.resize(mesh->vertices.size());
  reference_exposure = exposure_product(first);
}

IngestReport SurfaceLightField::Pipeline::ingest(const Capture& capture) {
  IngestReport report;
  const auto refuse = [&](const char* reason) {
    report.reason = reason;
    return report;
  };
  if (!has_pose(capture.pose)) return refuse("no_pose");
  if (!sizes_agree(capture)) return refuse("image_size");
  if (!first) start(capture);  // a first image that shows nothing decides nothing

  StageClock clock(report);
  const SurfaceView& view = visibility->look(capture.camera, capture.pose.camera_from_object, usable_pixels(capture));
  clock.done("visibility");
  if (view.visible_samples == 0) return refuse("object_not_in_view");

  if (!first) first = name_of(capture);
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
    return report;
  }
  resample(image, view, *rings, report.exposure_gain, samples, options.sampling);
  clock.done("resample");
  const float gain = estimated_gain(capture, view);
  if (gain != 1) resample(image, view, *rings, gain, samples, options.sampling);
  clock.done("exposure");
  constant_colour->add(view, samples);
  absorb(view, report);
  clock.done("factorize");
  folded.push_back({name_of(capture), std::log(gain), view.eye, report.rings_skipped + report.rings_left_out == 0});
  report.status = IngestStatus::kAccepted;
  return report;
}

bool SurfaceLightField::Pipeline::withdraw(const Capture& capture) {
  const ImageName name = name_of(capture);
  const auto found = std::find_if(folded.begin(), folded.end(), [&](const Folded& f) { return f.name == name; });
  if (first == name || found == folded.end() || !found->whole) return false;
  const SurfaceView& view = visibility->look(capture.camera, capture.pose.camera_from_object, usable_pixels(capture));
  image.load(capture, view);
  resample(image, view, *rings, found->log_gain != 0 ? std::exp(found->log_gain) : known_gain(capture), samples,
           options.sampling);
  constant_colour->remove(view, samples);
  tbb::parallel_for(tbb::blocked_range<std::size_t>(0, ring_models.size(), 32), [&](const auto& range) {
    RingColumn column;
    for (std::size_t v = range.begin(); v < range.end(); ++v)
      if (ring_models[v] && gather(*rings, v, mesh->vertices[v], view, samples, column))
        ring_models[v]->withdraw(column.values, column.visible, column.direction);
  });
  folded.erase(found);
  if (reflection) estimate_reflection(folded.size());
  choice = {};  // a bad image makes smooth kernels look good, everywhere
  std::vector<std::uint32_t> rings_to_choose;
  for (std::size_t v = 0; v < ring_models.size(); ++v)
    if (ring_models[v] && ring_models[v]->can_choose_interpolation())
      rings_to_choose.push_back(static_cast<std::uint32_t>(v));
  choose_interpolation(rings_to_choose);
  return true;
}

/// By what the camera reports, how much brighter the image is than the first one; 1 when that is unknown.
float SurfaceLightField::Pipeline::known_gain(const Capture& capture) const {
  if (options.exposure == ExposureCompensation::kOff || reference_exposure == 0) return 1;
  const double product = exposure_product(capture);
  return product > 0 ? static_cast<float>(product / reference_exposure) : 1;
}

/// How much brighter an image of unknown exposure is than the model, from what all surfaces say.
float SurfaceLightField::Pipeline::estimated_gain(const Capture& capture, const SurfaceView& view) const {
  const bool known = capture.exposure.locked || exposure_product(capture) > 0;
  if (options.exposure != ExposureCompensation::kEstimate || known) return 1;
  std::vector<float> ratios = constant_colour->log_ratios(view, samples);
  return robust_gain(ratios);
}

ExposureField SurfaceLightField::Pipeline::exposure_field() const {
  ExposureField field;
  if (std::all_of(folded.begin(), folded.end(), [](const Folded& f) { return f.log_gain == 0; })) return field;
  const auto n = static_cast<Eigen::Index>(folded.size());
  field.centre = bounding_sphere(*mesh).centre.cast<float>();
  field.directions.resize(3, n);
  Eigen::RowVectorXf gains(n);
  for (Eigen::Index j = 0; j < n; ++j) {
    field.directions.col(j) = (folded[j].eye.cast<float>() - field.centre).normalized();
    gains[j] = folded[j].log_gain;
  }
  double lowest = std::numeric_limits<double>::infinity();
  for (const ViewKernel& kernel : kViewKernels) {
    ViewInterpolant candidate = krige(field.directions, gains, Eigen::VectorXf::Ones(n), kernel);
    if (candidate.leave_one_out >= lowest) continue;
    lowest = candidate.leave_one_out;
    field.log_gain = std::move(candidate);
    field.kernel = kernel;
  }
  return field;
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
  report.rings_skipped = shown.size();
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
  report.rings_left_out = shown.size() - wanted;
  shown.resize(wanted);
  for (std::size_t i = 0; i < wanted; ++i) shown[i] = by_novelty[i].second;
  std::sort(shown.begin(), shown.end());
  return shown;
}

void SurfaceLightField::Pipeline::absorb(const SurfaceView& view, IngestReport& report) {
  const std::vector<std::uint32_t> chosen = rings_to_update(view, report);
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
  report.rings_skipped = static_cast<std::size_t>(std::count(repeated.begin(), repeated.end(), 1));
  double energy = 0, residual = 0;
  std::vector<std::uint32_t> undecided;
  for (std::size_t i = 0; i < absorbed.size(); ++i) {
    if (!absorbed[i].used) continue;
    ++report.rings_updated;
    energy += absorbed[i].energy;
    residual += absorbed[i].residual_energy;
    if (absorbed[i].wants_interpolation) undecided.push_back(chosen[i]);
  }
  report.relative_residual = energy > 0 ? std::sqrt(residual / energy) : 0;
  if (reflection_is_due(folded.size() + 1)) estimate_reflection(folded.size() + 1);
  choose_interpolation(undecided);
}

/// Seldom, as the number of images grows: what one image more can change gets less and less.
bool SurfaceLightField::Pipeline::reflection_is_due(std::size_t images) const {
  constexpr std::size_t kFirst = 6;
  constexpr double kGrowth = 1.4;
  return images >= kFirst && static_cast<double>(images) >= kGrowth * static_cast<double>(reflection_estimated_at);
}

/// What the rings share of how they vary with the view; a sample of them says it well enough.
void SurfaceLightField::Pipeline::estimate_reflection(std::size_t images) {
  constexpr std::size_t kRings = 1000;
  reflection_estimated_at = images;
  const std::size_t stride = std::max<std::size_t>(1, ring_models.size() / kRings);
  std::vector<RingLevels> levels((ring_models.size() + stride - 1) / stride);
  tbb::parallel_for(std::size_t{0}, levels.size(), [&](std::size_t i) {
    const std::size_t v = i * stride;
    if (ring_models[v]) levels[i] = ring_models[v]->levels(frames[v].row(2));
  });
  reflection = estimate_reflection_drift(levels);
  for (const auto& ring : ring_models)
    if (ring) ring->set_reflection(reflection);
}

void SurfaceLightField::Pipeline::choose_interpolation(const std::vector<std::uint32_t>& undecided) {
  std::vector<InterpolationErrors> errors(undecided.size());
  tbb::parallel_for(std::size_t{0}, undecided.size(), [&](std::size_t i) {
    const std::uint32_t v = undecided[i];
    errors[i] = ring_models[v]->interpolation_errors(frames[v].row(2));
  });
  for (const InterpolationErrors& e : errors) choice.count(e);
  for (std::size_t i = 0; i < undecided.size(); ++i)
    ring_models[undecided[i]]->set_interpolation(choice.choose(errors[i]));
}

SurfaceLightField::SurfaceLightField(std::shared_ptr<const Mesh> mesh, const SurfaceLightFieldOptions& options)
    : pipeline_(std::make_unique<Pipeline>()) {
  require_valid(options);
  pipeline_->mesh = std::move(mesh);
  pipeline_->options = options;
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
  return pipeline_->first == name_of(capture);
}

void SurfaceLightField::restart() {
  restart(pipeline_->options);
}

void SurfaceLightField::restart(const SurfaceLightFieldOptions& options) {
  require_valid(options);
  auto fresh = std::make_unique<Pipeline>();
  fresh->mesh = pipeline_->mesh;
  fresh->options = options;
  fresh->frames = std::move(pipeline_->frames);
  fresh->version = pipeline_->version;
  fresh->share = pipeline_->share;
  pipeline_ = std::move(fresh);
}

const SurfaceLightFieldOptions& SurfaceLightField::options() const {
  return pipeline_->options;
}

void SurfaceLightField::set_share(double share) {
  pipeline_->share = std::clamp(share, 0.01, 1.0);
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

std::shared_ptr<const ModelSnapshot> SurfaceLightField::constant_colour() const {
  if (pipeline_->constant_colour) return pipeline_->constant_colour->snapshot(pipeline_->exposure_field());
  const std::vector<std::uint8_t> coarse(pipeline_->mesh->triangles.size(), 2);
  return ConstantColour(pipeline_->mesh, std::make_shared<VertexRings>(*pipeline_->mesh, coarse)).snapshot();
}

std::size_t SurfaceLightField::images() const {
  return pipeline_->folded.size();
}

std::vector<std::size_t> SurfaceLightField::rank_histogram() const {
  std::vector<std::size_t> histogram;
  for (const auto& ring : pipeline_->ring_models) {
    if (!ring || ring->views() == 0) continue;
    const auto rank = static_cast<std::size_t>(ring->rank());
    if (histogram.size() <= rank) histogram.resize(rank + 1, 0);
    ++histogram[rank];
  }
  return histogram;
}

std::size_t SurfaceLightField::bytes() const {
  std::size_t bytes = 0;
  for (const auto& ring : pipeline_->ring_models)
    if (ring) bytes += ring->bytes();
  return bytes;
}

double SurfaceLightField::bytes_per_ring() const {
  const auto reached = std::count_if(pipeline_->ring_models.begin(), pipeline_->ring_models.end(),
                                     [](const auto& ring) { return ring && ring->views() > 0; });
  return reached > 0 ? static_cast<double>(bytes()) / static_cast<double>(reached) : 0;
}

}  // namespace sheen
