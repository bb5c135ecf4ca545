// SPDX-License-Identifier: Apache-2.0
#include "reconstructor/models/surface_light_field/patch_set.h"

#include <tbb/blocked_range.h>
#include <tbb/parallel_for.h>

#include <algorithm>
#include <iterator>
#include <utility>

#include "reconstructor/numerics/shipped_factor.h"

namespace sheen {
namespace {

// Images from a little nearer show hardly more: maps are made for one that is nearer by this factor.
constexpr double kFiner = 1.5;
// Of thousands: bases are unpacked to be looked at, which a person who watches does not wait for.
constexpr std::size_t kPatchesLookedAt = 32;

std::vector<SurfaceSite> centres_of(const Mesh& mesh, const PatchShapes& shapes) {
  std::vector<SurfaceSite> centres;
  centres.reserve(shapes.patches.size());
  for (const PatchShape& patch : shapes.patches) centres.push_back(centre_of(mesh, patch));
  return centres;
}

}  // namespace

SurfaceSite centre_of(const Mesh& mesh, const PatchShape& patch) {
  SurfaceSite centre{Eigen::Vector3f::Zero(), Eigen::Vector3f::Zero()};
  float area = 0;
  for (const std::uint32_t t : patch.triangles) {
    const Eigen::Vector3f normal = mesh.area_normal(t);
    centre.place += normal.norm() * (mesh.corner(t, 0) + mesh.corner(t, 1) + mesh.corner(t, 2)) / 3;
    centre.normal += normal;
    area += normal.norm();
  }
  if (area > 0)
    centre.place /= area;
  else
    centre.place = mesh.corner(patch.triangles.front(), 0);
  centre.normal.normalize();
  return centre;
}

PatchSet::PatchSet(std::shared_ptr<const Mesh> mesh, std::shared_ptr<const MapLayout> maps,
                   std::span<const Eigen::Matrix3f> frames, const PatchModelOptions& options, double pixels_per_metre)
    : mesh_(std::move(mesh)),
      maps_(std::move(maps)),
      shapes_(std::make_shared<const PatchShapes>(cut_into_patches(*mesh_, *maps_, options.size))),
      frames_(frames),
      options_(options),
      centres_(centres_of(*mesh_, *shapes_)),
      models_(shapes_->patches.size()),
      interpolation_(shapes_, options.interpolation),
      pixels_per_metre_(shapes_->patches.size(), static_cast<float>(pixels_per_metre)) {}

std::vector<std::uint32_t> PatchSet::shown_by(const SurfaceView& view) const {
  std::vector<std::uint32_t> shown;
  for (std::uint32_t p = 0; p < shapes_->patches.size(); ++p)
    if (shows(view, shapes_->patches[p])) shown.push_back(p);
  return shown;
}

std::vector<std::uint32_t> PatchSet::newest(Indices shown, const SurfaceView& view, std::size_t wanted) const {
  std::vector<std::pair<float, std::uint32_t>> by_novelty(shown.size());
  tbb::parallel_for(std::size_t{0}, shown.size(), [&](std::size_t i) {
    const std::uint32_t p = shown[i];
    by_novelty[i] = {models_[p] ? models_[p]->nearest_cosine(view.eye.cast<float>()) : -2.0f, p};
  });
  std::nth_element(by_novelty.begin(), by_novelty.begin() + static_cast<std::ptrdiff_t>(wanted), by_novelty.end());
  std::vector<std::uint32_t> newest(wanted);
  for (std::size_t i = 0; i < wanted; ++i) newest[i] = by_novelty[i].second;
  std::sort(newest.begin(), newest.end());
  return newest;
}

std::size_t PatchSet::count_repeated(Indices tested, const SurfaceImage& image) const {
  PatchColumn column;
  const auto repeated = std::count_if(tested.begin(), tested.end(), [&](std::uint32_t p) {
    return models_[p] && gather(shapes_->patches[p], image, column) &&
           models_[p]->repeats(column.values, column.visible, image.view.eye.cast<float>());
  });
  return static_cast<std::size_t>(repeated);
}

PatchModel::Prediction PatchSet::predict(Indices asked, const SurfaceImage& image) const {
  std::vector<PatchModel::Prediction> predicted(asked.size());
  tbb::parallel_for(std::size_t{0}, asked.size(), [&](std::size_t i) {
    const std::uint32_t p = asked[i];
    PatchColumn column;
    if (gather(shapes_->patches[p], image, column))
      predicted[i] = models_[p]->predict(column.values, column.visible, image.view.eye.cast<float>(),
                                         interpolation_.of(shapes_->patches[p].vertices.front()));
  });
  PatchModel::Prediction all;
  for (const PatchModel::Prediction& patch : predicted) {
    all.squared_error += patch.squared_error;
    all.values += patch.values;
  }
  return all;
}

PatchSet::Update PatchSet::absorb(Indices chosen, const SurfaceImage& image, std::size_t images,
                                  ConstantColour& constant) {
  Update update;
  update.repeated.assign(chosen.size(), 0);
  std::vector<PatchModel::Absorbed> absorbed(chosen.size());
  const Eigen::Vector3f eye = image.view.eye.cast<float>();
  const std::vector<float> reliability = reliability_at_vertices(*mesh_, *maps_, image.view);
  tbb::parallel_for(tbb::blocked_range<std::size_t>(0, chosen.size(), 4), [&](const auto& range) {
    PatchColumn column;
    std::vector<float> at_vertices;
    for (std::size_t i = range.begin(); i < range.end(); ++i) {
      const std::uint32_t p = chosen[i];
      std::unique_ptr<PatchModel>& patch = models_[p];
      if (!patch)
        patch =
            std::make_unique<PatchModel>(sides_of(p), shapes_->patches[p].vertices.size(), centres_[p], options_, p);
      gather(shapes_->patches[p], image, column);
      constant.add(shapes_->patches[p], column);
      update.repeated[i] = patch->repeats(column.values, column.visible, eye);
      if (update.repeated[i]) continue;
      at_vertices.clear();
      for (const std::uint32_t v : shapes_->patches[p].vertices) at_vertices.push_back(reliability[v]);
      absorbed[i] = patch->absorb(column.values, column.visible, eye, at_vertices);
    }
  });
  add_left_out(chosen, image, constant);
  const auto repeated = static_cast<std::size_t>(std::count(update.repeated.begin(), update.repeated.end(), 1));
  if (2 * repeated > chosen.size())
    tbb::parallel_for(tbb::blocked_range<std::size_t>(0, chosen.size(), 4), [&](const auto& range) {
      for (std::size_t i = range.begin(); i < range.end(); ++i)
        if (absorbed[i].used) models_[chosen[i]]->fold_pending();
    });
  std::vector<std::uint32_t> undecided;
  for (std::size_t i = 0; i < absorbed.size(); ++i) {
    if (!absorbed[i].used) continue;
    ++update.updated;
    update.energy += absorbed[i].energy;
    update.residual_energy += absorbed[i].residual_energy;
    if (absorbed[i].wants_interpolation) undecided.push_back(chosen[i]);
  }
  interpolation_.after_image(images, undecided, models_);
  return update;
}

/// The constant colour takes all that an image shows, whatever the patches take of it.
void PatchSet::add_left_out(Indices chosen, const SurfaceImage& image, ConstantColour& constant) const {
  std::vector<std::uint32_t> shown = shown_by(image.view), left_out;
  if (shown.size() == chosen.size()) return;
  std::set_difference(shown.begin(), shown.end(), chosen.begin(), chosen.end(), std::back_inserter(left_out));
  tbb::parallel_for(tbb::blocked_range<std::size_t>(0, left_out.size(), 8), [&](const auto& range) {
    PatchColumn column;
    for (std::size_t i = range.begin(); i < range.end(); ++i) {
      const PatchShape& patch = shapes_->patches[left_out[i]];
      if (gather(patch, image, column)) constant.add(patch, column);
    }
  });
}

void PatchSet::withdraw(const SurfaceImage& image, const std::vector<bool>& taken, std::size_t images,
                        ConstantColour& constant) {
  const Eigen::Vector3f eye = image.view.eye.cast<float>();
  tbb::parallel_for(tbb::blocked_range<std::size_t>(0, models_.size(), 8), [&](const auto& range) {
    PatchColumn column;
    for (std::size_t p = range.begin(); p < range.end(); ++p)
      if (gather(shapes_->patches[p], image, column)) {
        if (taken.empty() ? models_[p] != nullptr : taken[p]) models_[p]->withdraw(column.values, column.visible, eye);
        constant.remove(shapes_->patches[p], column);
      }
  });
  interpolation_.rebuild(images, models_);
}

MapSides PatchSet::sides_of(std::uint32_t patch) const {
  MapSides sides;
  for (const std::uint32_t t : shapes_->patches[patch].triangles)
    sides.push_back(static_cast<std::uint8_t>(maps_->resolution(t)));
  return sides;
}

std::shared_ptr<const MapLayout> PatchSet::coarsen_maps(Indices asked, double detail, double error) {
  std::vector<NewSides> sufficient(asked.size());
  tbb::parallel_for(std::size_t{0}, asked.size(), [&](std::size_t i) {
    const std::uint32_t p = asked[i];
    if (models_[p] && models_[p]->maps_due())
      sufficient[i] = {
          p, models_[p]->sufficient_sides(detail, error, interpolation_.of(shapes_->patches[p].vertices.front()))};
  });
  std::erase_if(sufficient, [&](const NewSides& s) { return s.sides.empty() || s.sides == sides_of(s.patch); });
  return sufficient.empty() ? nullptr : lay_out(sufficient, filter_sides());
}

void PatchSet::settle_maps() {
  tbb::parallel_for(tbb::blocked_range<std::size_t>(0, models_.size(), 8), [&](const auto& range) {
    for (std::size_t p = range.begin(); p < range.end(); ++p)
      if (models_[p]) models_[p]->settle_maps();
  });
}

bool PatchSet::may_refine(double pixels_per_metre) const {
  return std::any_of(pixels_per_metre_.begin(), pixels_per_metre_.end(),
                     [&](float before) { return pixels_per_metre > kFiner * before; });
}

std::shared_ptr<const MapLayout> PatchSet::refine_maps(const SurfaceView& view, double pixels_per_metre,
                                                       const MapSides& sides) {
  std::vector<NewSides> refined;
  MapSides filter = filter_sides();
  for (const std::uint32_t p : shown_by(view)) {
    if (pixels_per_metre <= kFiner * pixels_per_metre_[p]) continue;
    pixels_per_metre_[p] = static_cast<float>(pixels_per_metre);
    const MapSides before = sides_of(p);
    MapSides after;
    for (std::size_t i = 0; i < before.size(); ++i) {
      const std::uint32_t t = shapes_->patches[p].triangles[i];
      after.push_back(std::max(before[i], sides[t]));
      filter[t] = std::max(filter[t], sides[t]);
    }
    if (after != before) refined.push_back({p, std::move(after)});
  }
  return lay_out(refined, std::move(filter));
}

MapSides PatchSet::filter_sides() const {
  MapSides sides;
  sides.reserve(maps_->triangles());
  for (std::size_t t = 0; t < maps_->triangles(); ++t)
    sides.push_back(static_cast<std::uint8_t>(maps_->filter_resolution(t)));
  return sides;
}

std::shared_ptr<const MapLayout> PatchSet::lay_out(const std::vector<NewSides>& changed, MapSides filter) {
  if (changed.empty()) return nullptr;
  tbb::parallel_for(std::size_t{0}, changed.size(), [&](std::size_t i) {
    const auto& [p, sides] = changed[i];
    if (models_[p]) models_[p]->resample(sides);
  });
  MapSides all;
  all.reserve(maps_->triangles());
  for (std::size_t t = 0; t < maps_->triangles(); ++t) all.push_back(static_cast<std::uint8_t>(maps_->resolution(t)));
  for (const auto& [p, sides] : changed)
    for (std::size_t i = 0; i < sides.size(); ++i) all[shapes_->patches[p].triangles[i]] = sides[i];
  maps_ = std::make_shared<const MapLayout>(std::move(all), std::move(filter));
  shapes_ = std::make_shared<const PatchShapes>(with_maps(*shapes_, *maps_));
  interpolation_.use(shapes_);
  return maps_;
}

void PatchSet::limit(const PatchLimit& limit) {
  options_ = options_.limited_to(limit);
  tbb::parallel_for(tbb::blocked_range<std::size_t>(0, models_.size(), 8), [&](const auto& range) {
    for (std::size_t p = range.begin(); p < range.end(); ++p)
      if (models_[p]) models_[p]->limit(limit);
  });
}

/// Whether the patch's snapshot interpolates as its vertices now do.
bool PatchSet::is_latest(std::uint32_t patch) const {
  const PatchSnapshot* const snapshot = models_[patch]->snapshot().get();
  if (!snapshot) return false;
  const auto vertices = shapes_->patches[patch].vertices;
  for (std::size_t i = 0; i < vertices.size(); ++i) {
    const VertexInterpolant& shown = snapshot->vertices[i];
    const auto [chosen, reflection] = interpolation_.of(vertices[i]);
    if (shown.views->kernel != chosen.kernel || shown.views->reflection != (chosen.drift ? reflection : nullptr))
      return false;
  }
  return true;
}

std::vector<std::shared_ptr<const PatchSnapshot>> PatchSet::snapshots() {
  const auto settle = [&](std::uint32_t p) {
    return models_[p] && !is_latest(p) ? models_[p]->factorized() : std::nullopt;
  };
  std::vector<std::shared_ptr<const PatchSnapshot>> snapshots = interpolated(
      *shapes_, *maps_, settle, [&](std::uint32_t v) { return at_vertex(v); }, options_.interpolation.method);
  for (std::size_t p = 0; p < snapshots.size(); ++p) {
    if (snapshots[p]) models_[p]->keep(snapshots[p]);
    if (models_[p]) snapshots[p] = models_[p]->snapshot();
  }
  return snapshots;
}

std::vector<std::shared_ptr<const PatchSnapshot>> PatchSet::finish() {
  const auto settle = [&](std::uint32_t p) {
    const std::unique_ptr<PatchModel> last = std::move(models_[p]);
    return last ? last->factorized() : std::nullopt;
  };
  return interpolated(
      *shapes_, *maps_, settle, [&](std::uint32_t v) { return at_vertex(v); }, options_.interpolation.method);
}

std::size_t PatchSet::bytes() const {
  std::size_t bytes = 0;
  for (const auto& patch : models_)
    if (patch) bytes += patch->bytes();
  return bytes;
}

std::size_t PatchSet::snapshot_bytes() const {
  std::size_t bytes = 0;
  for (std::size_t p = 0; p < models_.size(); ++p)
    if (models_[p]) bytes += models_[p]->snapshot_bytes(shapes_->patches[p].vertices.size());
  return bytes;
}

std::vector<std::size_t> PatchSet::rank_histogram() const {
  std::vector<std::size_t> histogram;
  for (const auto& patch : models_) {
    if (!patch || patch->views() == 0) continue;
    const auto rank = static_cast<std::size_t>(patch->rank());
    if (histogram.size() <= rank) histogram.resize(rank + 1, 0);
    ++histogram[rank];
  }
  return histogram;
}

NumericalHealth PatchSet::health() const {
  std::vector<const OnlineSvd*> factors;
  double energy = 0, lost = 0;
  for (const auto& patch : models_) {
    if (!patch || patch->factor().rank() == 0) continue;
    factors.push_back(&patch->factor());
    energy += patch->factor().energy();
    lost += patch->factor().lost_energy();
  }
  if (!(energy > 0)) return {};
  NumericalHealth health{.orthogonality_lost = 0, .energy_lost = lost / energy};
  const std::size_t step = (factors.size() + kPatchesLookedAt - 1) / kPatchesLookedAt;
  for (std::size_t i = 0; i < factors.size(); i += step)
    health.orthogonality_lost = std::max(health.orthogonality_lost, orthogonality_lost(*factors[i]));
  return health;
}

}  // namespace sheen
