// SPDX-License-Identifier: Apache-2.0
#include "tests/reconstructor/render/gl/synthetic_light_field.h"

#include <algorithm>
#include <cmath>

#include "reconstructor/models/surface_light_field/map_detail.h"
#include "reconstructor/surface/lattice_resampling.h"
#include "reconstructor/surface/view_hemisphere.h"

namespace sheen {
namespace {

constexpr float kRadius = 0.06f, kThickness = 0.026f;  // metres

Mesh bumpy_ring(int around, int across) {
  Mesh mesh;
  for (int i = 0; i < around; ++i)
    for (int j = 0; j < across; ++j) {
      const double a = 2 * M_PI * i / around, b = 2 * M_PI * j / across;
      const double tube = kThickness * (1 + 0.12 * std::sin(5 * a) * std::cos(2 * b));
      const double r = kRadius + tube * std::cos(b);
      mesh.vertices.emplace_back(Eigen::Vector3d(r * std::cos(a), r * std::sin(a), tube * std::sin(b)).cast<float>());
    }
  const auto index = [&](int i, int j) { return std::uint32_t(i % around * across + j % across); };
  for (int i = 0; i < around; ++i)
    for (int j = 0; j < across; ++j) {
      mesh.triangles.push_back({index(i, j), index(i + 1, j), index(i + 1, j + 1)});
      mesh.triangles.push_back({index(i, j), index(i + 1, j + 1), index(i, j + 1)});
    }
  return mesh;
}

/// Pattern of term r at a surface point: continuous over the whole object, so that triangles agree on their edges.
Eigen::Vector3f pattern(const Eigen::Vector3f& p, int r) {
  const float f = 60.0f + 25.0f * static_cast<float>(r);
  Eigen::Vector3f rgb;
  for (int c = 0; c < 3; ++c) {
    const float phase = 0.9f * static_cast<float>(c) + 1.7f * static_cast<float>(r);
    rgb[c] = std::sin(f * p.x() + phase) * std::cos(0.8f * f * p.y() - phase) + 0.4f * std::sin(1.3f * f * p.z());
  }
  return r == 0 ? Eigen::Vector3f(Eigen::Vector3f(0.55f, 0.45f, 0.35f) + 0.16f * rgb) : 0.25f / (1.0f + r) * rgb;
}

/// What all patches show together, however many terms each of them has: the last one is what the others leave of it.
Eigen::Vector3f surface(const Eigen::Vector3f& p) {
  return pattern(p, 0) + pattern(p, 1) + pattern(p, 2);
}

float sign_of(int r) {
  return r % 2 ? -1.0f : 1.0f;
}

/// Coefficient of term r of every patch, as a multiple of how bright the surface is from a direction.
float fraction(int r) {
  return sign_of(r) * (1 + 0.5f * static_cast<float>(r));
}

}  // namespace

SyntheticLightField::SyntheticLightField(const SyntheticOptions& options) : options_(options) {
  auto mesh = std::make_shared<Mesh>(bumpy_ring(options.around, options.across));
  if (!options.evidence.empty()) mesh->evidence.assign(mesh->vertices.size(), options.evidence.front());
  std::vector<std::uint8_t> resolution(mesh->triangles.size());
  for (std::size_t t = 0; t < resolution.size(); ++t) resolution[t] = t % 7 == 0 ? 2 : (t % 3 == 0 ? 8 : 16);
  normals_ = vertex_normals(*mesh);
  mesh_ = mesh;
  maps_ = std::make_shared<MapLayout>(std::move(resolution));
  constexpr std::size_t kTriangles = 2;
  shapes_ = std::make_shared<const PatchShapes>(cut_into_patches(*mesh_, *maps_, {.triangles = kTriangles}));
  SurfaceLightFieldSnapshot::Patches data(shapes_->patches.size());
  for (std::size_t p = 0; p < data.size(); ++p) {
    const bool unseen = static_cast<double>(p) < options.unseen * static_cast<double>(data.size()) || p % 97 == 96;
    if (!unseen) data[p] = make_patch(p, 1 + static_cast<int>(p * 7 % static_cast<std::size_t>(options.max_rank)));
  }
  snapshot_ = std::make_shared<SurfaceLightFieldSnapshot>(mesh_, maps_, shapes_, std::move(data), options.version);
}

std::shared_ptr<const PatchSnapshot> SyntheticLightField::make_patch(std::size_t index, int rank,
                                                                     float brightness) const {
  const PatchShape& shape = shapes_->patches[index];
  auto patch = std::make_shared<PatchSnapshot>();
  Eigen::MatrixXf basis(3 * Eigen::Index{shape.samples}, rank);
  patch->shown.resize(shape.samples);
  for (const std::uint32_t t : shape.triangles) {
    const int n = maps_->resolution(t);
    for (int i = 0; i < n; ++i)
      for (int j = 0; i + j < n; ++j) {
        const float u = static_cast<float>(i) / (n - 1), v = static_cast<float>(j) / (n - 1);
        const Eigen::Vector3f p = (1 - u - v) * mesh_->corner(t, 0) + u * mesh_->corner(t, 1) + v * mesh_->corner(t, 2);
        const int row = 3 * (static_cast<int>(shapes_->first_sample[t]) + lattice_index(n, i, j));
        Eigen::Vector3f left = brightness * surface(p);
        for (int r = 0; r + 1 < rank; ++r) {
          basis.block<3, 1>(row, r) = pattern(p, r) / fraction(r);
          left -= pattern(p, r);
        }
        basis.block<3, 1>(row, rank - 1) = left / fraction(rank - 1);
        const bool side = options_.unseen > 0 && std::abs(p.y()) < 0.02f;
        patch->shown[row / 3] = !side ? 255 : p.x() < 0 ? 0 : 60;
      }
  }
  patch->basis = basis;
  if (index % 2 == 1) in_planes(*patch, shape);
  for (const std::uint32_t v : shape.vertices) patch->vertices.push_back(make_vertex(v, rank));
  return patch;
}

/// As patches that are captured have it: chroma half as fine as luma.
void SyntheticLightField::in_planes(SurfacePatch& patch, const PatchShape& shape) const {
  MapSides sides;
  for (const std::uint32_t t : shape.triangles) sides.push_back(static_cast<std::uint8_t>(maps_->resolution(t)));
  patch.planes = std::make_shared<const ColourPlanes>(sides, half_sides(sides));
  const std::vector<std::uint8_t> all(shape.samples, 1);
  Eigen::MatrixXf rows(patch.planes->rows(), patch.rank());
  for (int r = 0; r < patch.rank(); ++r) rows.col(r) = patch.planes->rows_of(patch.basis.column(r), all);
  patch.basis = rows;
}

VertexInterpolant SyntheticLightField::make_vertex(std::uint32_t vertex, int rank) const {
  constexpr int kViews = 10;
  auto views = std::make_shared<VertexViews>();
  views->frame = hemisphere_frame(normals_[vertex]);
  views->directions.resize(3, kViews);
  for (int j = 0; j < kViews; ++j) {
    const float turn = 2.4f * static_cast<float>(j), lean = 0.13f * static_cast<float>(j);
    const Eigen::Vector3f local(std::sin(lean) * std::cos(turn), std::sin(lean) * std::sin(turn), std::cos(lean));
    views->directions.col(j) = views->frame.transpose() * local;
  }
  views->reliability = Eigen::VectorXf::Ones(kViews);
  views->kernel = {0.6f, 0.05f};
  views->best_cosine = mesh_->vertices[vertex].y() > 0.05f ? 0.2f : 0.9f;
  VertexInterpolant at;
  at.views = std::move(views);
  at.mean.resize(rank);
  Eigen::MatrixXf weights(kViews, rank);
  for (int r = 0; r < rank; ++r) {
    at.mean[r] = fraction(r);
    for (int j = 0; j < kViews; ++j) weights(j, r) = 0.2f * fraction(r) * std::cos(1.1f * static_cast<float>(j + 1));
  }
  at.weights = weights;
  at.sill = 0.006f + 0.006f * std::sin(40 * mesh_->vertices[vertex].x());
  at.views_folded = kViews;
  return at;
}

std::shared_ptr<const SurfaceLightFieldSnapshot> SyntheticLightField::with_changed_patches(int stride,
                                                                                           int max_rank) const {
  constexpr float kBrighter = 1.3f;
  auto data = snapshot_->patches();
  for (std::size_t p = 0; p < data.size(); p += static_cast<std::size_t>(stride))
    data[p] = make_patch(p, 1 + static_cast<int>(p * 5 % static_cast<std::size_t>(max_rank)), kBrighter);
  return std::make_shared<SurfaceLightFieldSnapshot>(mesh_, maps_, shapes_, std::move(data), snapshot_->version() + 1);
}

std::shared_ptr<const SurfaceLightFieldSnapshot> SyntheticLightField::with_other_bases() const {
  auto data = snapshot_->patches();
  for (auto& patch : data) {
    if (!patch) continue;
    auto other = std::make_shared<PatchSnapshot>(*patch);
    const Eigen::MatrixXf before = patch->basis.unpacked();
    Eigen::MatrixXf basis = before;
    for (VertexInterpolant& at : other->vertices) {
      const Eigen::MatrixXf weights = at.weights.unpacked(), mean = at.mean;
      for (int r = 0; r < patch->rank(); ++r) {
        const int from = patch->rank() - 1 - r;
        at.mean[r] = sign_of(r) * mean(from);
        at.weights.exact().col(r) = sign_of(r) * weights.col(from);
      }
    }
    for (int r = 0; r < patch->rank(); ++r) {
      const int from = patch->rank() - 1 - r;
      basis.col(r) = sign_of(r) * before.col(from);
    }
    other->basis = basis;
    patch = other;
  }
  return std::make_shared<SurfaceLightFieldSnapshot>(mesh_, maps_, shapes_, std::move(data), snapshot_->version() + 1);
}

std::shared_ptr<const SurfaceLightFieldSnapshot> SyntheticLightField::with_finer_maps(std::uint32_t stride) const {
  auto data = with_other_bases()->patches();
  const auto chosen = [&](std::uint32_t p) {
    if (p % stride != 0 || !data[p]) return false;
    const auto& shown = data[p]->shown;
    return std::all_of(shown.begin(), shown.end(), [&](std::uint8_t share) { return share == shown[0]; });
  };
  MapSides sides;
  for (std::size_t t = 0; t < mesh_->triangles.size(); ++t) {
    const int side = maps_->resolution(t);
    sides.push_back(static_cast<std::uint8_t>(chosen(shapes_->patch_of[t]) ? 2 * side - 1 : side));
  }
  auto maps = std::make_shared<MapLayout>(sides);
  for (std::uint32_t p = 0; p < data.size(); ++p) {
    if (!chosen(p)) continue;
    const Eigen::MatrixXf before = data[p]->colours();
    Eigen::MatrixXf after(0, before.cols());
    Eigen::Index first = 0;
    for (const std::uint32_t t : shapes_->patches[p].triangles) {
      const int from = maps_->resolution(t), samples = lattice_samples(from), finer = lattice_samples(sides[t]);
      after.conservativeResize(after.rows() + 3 * finer, Eigen::NoChange);
      for (Eigen::Index k = 0; k < before.cols(); ++k)
        after.col(k).tail(3 * finer) = LatticeResampling(from, sides[t])
                                           .of(before.col(k).segment(first, 3 * samples).reshaped(3, samples))
                                           .reshaped();
      first += 3 * samples;
    }
    auto other = std::make_shared<PatchSnapshot>(*data[p]);
    other->shown.assign(static_cast<std::size_t>(after.rows() / 3), data[p]->shown[0]);
    other->basis = after;
    other->planes = nullptr;
    data[p] = other;
  }
  auto shapes = std::make_shared<PatchShapes>(with_maps(*shapes_, *maps));
  return std::make_shared<SurfaceLightFieldSnapshot>(mesh_, std::move(maps), std::move(shapes), std::move(data),
                                                     snapshot_->version() + 2);
}

std::shared_ptr<const SurfaceLightFieldSnapshot> SyntheticLightField::with_exposure(float factor) const {
  ExposureField exposure;
  exposure.directions = Eigen::Vector3f(0, 0, 1);
  exposure.log_gain = {.mean = Eigen::VectorXf::Constant(1, std::log(factor)), .weights = Eigen::MatrixXf::Zero(1, 1)};
  return std::make_shared<SurfaceLightFieldSnapshot>(mesh_, maps_, shapes_, snapshot_->patches(),
                                                     snapshot_->version() + 1, exposure);
}

std::shared_ptr<const Capture> synthetic_capture(const Eigen::Vector3d& eye) {
  auto capture = std::make_shared<Capture>();
  capture->camera = {.width = 640, .height = 480, .fx = 800, .fy = 800, .cx = 319.5, .cy = 239.5};
  capture->camera.distortion = {-0.25, 0.05, 0.001, -0.001, 0};
  capture->image = {
      .format = PixelFormat::kRGB8, .transfer = Transfer::kSrgb, .width = 640, .height = 480, .stride = 640 * 3};
  for (int y = 0; y < 480; ++y)
    for (int x = 0; x < 640; ++x)
      for (int c = 0; c < 3; ++c)
        capture->image.bytes.push_back(static_cast<std::uint8_t>((x / 32 + y / 32) % 2 ? 150 : 110 + 10 * c));
  capture->pose.status = PoseStatus::kTracked;
  capture->pose.camera_from_object = look_at(eye, {0, 0, 0}, {0, 0, 1});
  capture->pose.tags_used = 1;
  capture->pose.reprojection_rms_px = 0.31;
  capture->tags.push_back({.id = 3, .corners = {{{60, 60}, {120, 64}, {118, 124}, {58, 120}}}, .used = true});
  capture->tags.push_back({.id = 17, .corners = {{{520, 380}, {580, 384}, {578, 444}, {518, 440}}}, .used = false});
  return capture;
}

}  // namespace sheen
