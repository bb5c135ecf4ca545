// SPDX-License-Identifier: Apache-2.0
#include "reconstructor/models/surface_light_field/compact/compact_light_field.h"

#include <algorithm>

#include "common/base/errors.h"
#include "common/base/files.h"
#include "common/base/order_statistics.h"
#include "common/parallel/for_each.h"
#include "reconstructor/light_field_file/file_layout.h"

namespace sheen {
namespace {

constexpr std::uint64_t kOnlySnapshot = 1;  ///< number of a model that does not change
constexpr float kGreyLevels = 255;

FileFacts facts_of(const CompactModel& model) {
  return {static_cast<float>(model.missing_square / (kGreyLevels * kGreyLevels)), brightest_drawn(model)};
}

SnapshotFigures figures_of(const std::vector<std::shared_ptr<const SurfacePatch>>& patches) {
  SnapshotFigures figures;
  std::vector<int> ranks;
  std::size_t samples = 0, seen = 0, measured = 0;
  for (const auto& patch : patches) {
    if (!patch) continue;
    samples += patch->shown.size();
    std::size_t here = 0;
    for (std::size_t s = 0; s < patch->shown.size(); ++s) {
      here += patch->state(static_cast<int>(s)) != SampleState::kUnseen;
      measured += patch->state(static_cast<int>(s)) == SampleState::kMeasured;
    }
    seen += here;
    if (here > 0) ranks.push_back(patch->rank());
  }
  if (samples == 0 || ranks.empty()) return figures;
  figures.seen = static_cast<double>(seen) / static_cast<double>(samples);
  figures.measured = static_cast<double>(measured) / static_cast<double>(samples);
  figures.most_rank = *std::max_element(ranks.begin(), ranks.end());
  figures.median_rank = median_of_both_middles<double>(ranks);
  return figures;
}

}  // namespace

CompactLightField::CompactLightField(CompactModel model, std::shared_ptr<const std::string> encoded)
    : LightFieldSnapshot(model.mesh, model.maps, kOnlySnapshot, model.exposure, model.cameras,
                         GuidanceMethod::kExpectedError, facts_of(model)),
      light_field_(model, in_parallel),
      seen_(model.vertices.size()),
      figures_(figures_of(light_field_.patches())),
      encoded_(std::move(encoded)) {
  double sum = 0, views = 0;
  for (std::size_t v = 0; v < seen_.size(); ++v) {
    const CompactVertex& vertex = model.vertices[v];
    if (!vertex.seen) continue;
    seen_[v] = {light_field_.views(v), vertex.sill, vertex.residual, vertex.views_folded};
    sum += vertex.sill * static_cast<double>(vertex.views.size());
    views += static_cast<double>(vertex.views.size());
  }
  common_sill_ = views > 0 ? static_cast<float>(sum / views) : 0;
}

bool CompactLightField::seen(std::size_t triangle) const {
  return light_field_.patches()[light_field_.shapes().patch_of[triangle]] != nullptr;
}

TrianglePlace CompactLightField::place(std::size_t triangle) const {
  return light_field_.shapes().place(triangle);
}

Eigen::MatrixXf CompactLightField::coefficients_for(const Eigen::Vector3d& eye) const {
  return light_field_.coefficients_for(eye, in_parallel);
}

/// The first term alone: the mean map, whose coefficient is 1.
Eigen::MatrixXf CompactLightField::average_coefficients() const {
  Eigen::MatrixXf first = Eigen::MatrixXf::Zero(max_rank(), static_cast<Eigen::Index>(light_field_.shapes().columns()));
  first.row(0).setOnes();
  return first;
}

std::shared_ptr<const LightFieldSnapshot> CompactLightField::with_patches(
    const std::vector<std::shared_ptr<const SurfacePatch>>&) const {
  return shared_from_this();  // it never changes: what is not there yet is merely not drawn
}

std::shared_ptr<const ModelSnapshot> CompactLightField::filled() const {
  return shared_from_this();
}

const SeenVertex* CompactLightField::seen_vertex(std::size_t vertex) const {
  return seen_[vertex].views ? &seen_[vertex] : nullptr;
}

std::size_t CompactLightField::memory_bytes() const {
  return light_field_.bytes();
}

std::unique_ptr<Compression> CompactLightField::compression(CompressionTarget) const {
  throw ConfigError("the model is compressed already; compress the one that it was made from");
}

void CompactLightField::save(const std::filesystem::path& path, const ModelMetadata& metadata, const StepsDone&) const {
  write_file(path, with_notes(kLightFieldFile, *encoded_, metadata, path.string()));
}

}  // namespace sheen
