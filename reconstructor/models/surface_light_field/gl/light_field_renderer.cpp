// SPDX-License-Identifier: Apache-2.0
#include "reconstructor/models/surface_light_field/gl/light_field_renderer.h"

#include <epoxy/gl.h>

#include <algorithm>
#include <numeric>

#include "common/base/errors.h"

namespace sheen {
namespace {

enum TextureUnit { kPositions, kCorners, kResolutions, kSlots, kCoefficients, kQuality, kBasis };

GlProgram surface_program(const SurfaceShaderVariant& variant) {
  GlProgram program("surface light field", kSurfaceVertexShader, surface_fragment_shader(variant));
  program.use();
  const auto set = [&](const char* name, int unit) { glUniform1i(program.uniform(name), unit); };
  set("positions", kPositions);
  set("corners", kCorners);
  set("resolutions", kResolutions);
  set("slots", kSlots);
  set("coefficients", kCoefficients);
  set("quality", kQuality);
  for (int b = 0; b < BasisStore::kMaxBuffers; ++b) set(("basis" + std::to_string(b)).c_str(), kBasis + b);
  glUniform1f(program.uniform("inside_grey"), kInsideGrey);
  for (int half = 0; half < 3; ++half)
    glUniform3fv(program.uniform(("need_colors[" + std::to_string(half) + "]").c_str()), 1,
                 need_color(0.5f * static_cast<float>(half)).data());
  for (int reason = 0; reason < kQualityReasons; ++reason)
    glUniform3fv(program.uniform(("reason_colors[" + std::to_string(reason) + "]").c_str()), 1,
                 reason_color(static_cast<QualityReason>(reason)).data());
  for (int state = 0; state < 2; ++state)
    glUniform3fv(program.uniform(("state_colors[" + std::to_string(state) + "]").c_str()), 1,
                 state_color(static_cast<SampleState>(state)).data());
  for (int stop = 0; stop < kDemandColours; ++stop)
    glUniform3fv(program.uniform(("demand_colors[" + std::to_string(stop) + "]").c_str()), 1, demand_stop(stop).data());
  for (int evidence = 0; evidence < 3; ++evidence)
    glUniform3fv(program.uniform(("evidence_colors[" + std::to_string(evidence) + "]").c_str()), 1,
                 evidence_color(static_cast<ShapeEvidence>(evidence)).data());
  check_gl("setting up the light field's shader");
  return program;
}

/// Triangles that face the eye, from the nearest to the farthest, then the others: by layers, exactly enough for a
/// depth test that is to leave out what is hidden.
std::vector<std::uint32_t> drawing_order(const Mesh& mesh, const Eigen::Vector3f& eye) {
  constexpr std::uint32_t kLayers = 128;
  const BoundingSphere sphere = bounding_sphere(mesh);
  const float nearest = (eye - sphere.centre.cast<float>()).norm() - static_cast<float>(sphere.radius);
  const float layers_per_metre = kLayers / std::max(2 * static_cast<float>(sphere.radius), 1e-12f);
  std::vector<std::uint32_t> layer(mesh.triangles.size()), first(2 * kLayers + 1), order(mesh.triangles.size());
  for (std::size_t t = 0; t < layer.size(); ++t) {
    const Eigen::Vector3f to_eye = eye - mesh.corner(t, 0);
    const float depth = std::clamp(layers_per_metre * (to_eye.norm() - nearest), 0.0f, kLayers - 1.0f);
    layer[t] = static_cast<std::uint32_t>(depth) + (mesh.area_normal(t).dot(to_eye) > 0 ? 0 : kLayers);
    ++first[layer[t] + 1];
  }
  std::partial_sum(first.begin(), first.end(), first.begin());
  for (std::uint32_t t = 0; t < layer.size(); ++t) order[first[layer[t]]++] = t;
  return order;
}

}  // namespace

LightFieldRenderer::LightFieldRenderer(const DrawerOptions& options)
    : options_(options),
      program_(surface_program(variant_)),
      vertex_array_(make_gl_vertex_array()),
      store_(options.max_buffer_texels),
      order_(make_gl_buffer()),
      positions_(GL_RGBA32F, 16),
      corners_(GL_RGBA32UI, 16),
      resolutions_(GL_R8UI, 1),
      slots_(GL_RG32UI, 8),
      coefficients_(GL_R32F, 4),
      quality_(GL_RG32F, 8) {}

void LightFieldRenderer::make_program() {
  const SurfaceShaderVariant wanted{std::max(1, store_.buffers())};
  if (wanted == variant_) return;
  program_ = surface_program(wanted);
  variant_ = wanted;
}

bool LightFieldRenderer::update(const std::shared_ptr<const ModelSnapshot>& model) {
  if (!model) return true;
  const auto snapshot = std::dynamic_pointer_cast<const LightFieldSnapshot>(model);
  if (!snapshot) throw Error("what is to be drawn is not a surface light field");
  const bool same_mesh = snapshot->shared_mesh() == mesh_;
  if (!same_mesh || (snapshot->shared_maps() != maps_ && !follow_maps(*snapshot))) upload_mesh(*snapshot);
  const bool complete = upload_patches(*snapshot);
  exposure_ = snapshot->exposure();
  check_gl("uploading surface maps");
  return complete;
}

std::vector<std::string> LightFieldRenderer::notes() const {
  if (shortened_patches_ == 0) return {};
  return {"graphics memory is full: " + std::to_string(shortened_patches_) + " patches are drawn with fewer terms"};
}

void LightFieldRenderer::upload_mesh(const LightFieldSnapshot& snapshot) {
  const Mesh& mesh = snapshot.mesh();
  std::vector<Eigen::Vector4f> positions;
  for (const Eigen::Vector3f& p : mesh.vertices) positions.push_back(p.homogeneous());
  positions_.assign(positions.size(), positions.data());
  for (const BasisSlot& slot : patch_slots_) store_.release(slot);
  uploaded_.assign(snapshot.patch_count(), nullptr);
  patch_slots_.assign(snapshot.patch_count(), {});
  other_maps_.assign(snapshot.patch_count(), 0);
  patch_of_.clear();
  for (std::size_t t = 0; t < mesh.triangles.size(); ++t) patch_of_.push_back(snapshot.place(t).patch);
  shortened_patches_ = 0;
  triangle_count_ = mesh.triangles.size();
  mesh_ = snapshot.shared_mesh();
  shown_.reset();
  order_eye_.reset();
  upload_maps(snapshot);
}

void LightFieldRenderer::upload_maps(const LightFieldSnapshot& snapshot) {
  const Mesh& mesh = snapshot.mesh();
  const MapLayout& maps = snapshot.maps();
  std::vector<std::uint32_t> corners;
  std::vector<std::uint8_t> resolutions;
  for (std::size_t t = 0; t < mesh.triangles.size(); ++t) {
    const TrianglePlace place = snapshot.place(t);
    for (std::size_t c = 0; c < 3; ++c)
      corners.insert(corners.end(), {mesh.triangles[t][c], place.patch, place.first_sample, place.columns[c]});
    resolutions.push_back(static_cast<std::uint8_t>(maps.resolution(t)));
  }
  corners_.assign(corners.size() / 4, corners.data());
  resolutions_.assign(resolutions.size(), resolutions.data());
  maps_ = snapshot.shared_maps();
}

bool LightFieldRenderer::follow_maps(const LightFieldSnapshot& snapshot) {
  if (snapshot.patch_count() != uploaded_.size()) return false;
  for (std::size_t t = 0; t < triangle_count_; ++t)
    if (snapshot.place(t).patch != patch_of_[t]) return false;
  for (std::size_t t = 0; t < triangle_count_; ++t)
    if (snapshot.maps().resolution(t) != maps_->resolution(t)) other_maps_[patch_of_[t]] = 1;
  upload_maps(snapshot);
  return true;
}

bool LightFieldRenderer::upload_patches(const LightFieldSnapshot& snapshot) {
  std::vector<std::shared_ptr<const SurfacePatch>> wanted(snapshot.patch_count());
  std::vector<std::size_t> changed;
  std::size_t growth = 0;
  for (std::size_t i = 0; i < wanted.size(); ++i) {
    wanted[i] = snapshot.patch(i);
    if (wanted[i] == uploaded_[i]) continue;
    changed.push_back(i);
    if (!wanted[i]) continue;
    const std::size_t texels = wanted[i]->shown.size() * static_cast<std::size_t>(wanted[i]->rank());
    growth += texels - std::min<std::size_t>(texels, patch_slots_[i].texels);
  }
  if (changed.empty() && shown_) return true;

  std::stable_partition(changed.begin(), changed.end(), [&](std::size_t v) { return !uploaded_[v]; });
  std::stable_partition(changed.begin(), changed.end(), [&](std::size_t v) { return other_maps_[v] != 0; });
  store_.reserve(growth);
  std::size_t texels = 0, done = 0;
  const auto can_wait = [&](std::size_t v) { return other_maps_[v] == 0 && texels >= options_.texels_per_update; };
  for (; done < changed.size() && (done == 0 || !can_wait(changed[done])); ++done) {
    const std::size_t v = changed[done];
    if (uploaded_[v] && patch_slots_[v].rank < uploaded_[v]->rank()) --shortened_patches_;
    store_.release(patch_slots_[v]);
    patch_slots_[v] = wanted[v] ? store_.store(*wanted[v]) : BasisSlot{};
    if (wanted[v] && patch_slots_[v].rank < wanted[v]->rank()) ++shortened_patches_;
    uploaded_[v] = wanted[v];
    other_maps_[v] = 0;
    texels += patch_slots_[v].texels;
  }

  std::vector<std::uint32_t> slots;
  for (const BasisSlot& slot : patch_slots_) {
    slots.push_back(slot.first);
    slots.push_back(slot.rank | std::uint32_t(slot.buffer) << 16);
  }
  slots_.assign(patch_slots_.size(), slots.data());
  shown_ = snapshot.with_patches(uploaded_);
  coefficients_eye_.reset();
  quality_eye_.reset();
  demand_.reset();
  return done == changed.size();
}

void LightFieldRenderer::upload_coefficients(const Eigen::Vector3d& eye) {
  if (coefficients_eye_ == eye) return;
  const Eigen::MatrixXf coefficients = shown_->coefficients_for(eye);
  stride_ = static_cast<int>(coefficients.rows());
  if (stride_ > 0) coefficients_.assign(static_cast<std::size_t>(coefficients.size()), coefficients.data());
  coefficients_eye_ = eye;
}

void LightFieldRenderer::upload_quality(const Eigen::Vector3d& eye) {
  if (quality_eye_ == eye) return;
  std::vector<Eigen::Vector2f> quality;
  for (const SurfaceQuality& q : shown_->quality_for(eye))
    quality.emplace_back(q.heuristic(), static_cast<float>(q.reason()));
  quality_.assign(quality.size(), quality.data());
  quality_eye_ = eye;
  demand_.reset();
}

void LightFieldRenderer::upload_demand(Demand demand) {
  if (demand_ == demand) return;
  std::vector<Eigen::Vector2f> levels;
  const DemandMap asked(*shown_, demand);
  for (const float level : asked.levels()) levels.emplace_back(level, 0.0f);
  quality_.assign(levels.size(), levels.data());
  demand_ = demand;
  quality_eye_.reset();
}

void LightFieldRenderer::upload_evidence() {
  std::vector<Eigen::Vector2f> levels;
  for (const Triangle& triangle : mesh_->triangles) {
    float sum = 0;
    for (const std::uint32_t v : triangle) sum += static_cast<float>(mesh_->evidence[v]);
    levels.emplace_back(sum / 3, 0.0f);
  }
  quality_.assign(levels.size(), levels.data());
  demand_.reset();
  quality_eye_.reset();
}

void LightFieldRenderer::upload_order(const Eigen::Vector3d& eye) {
  glBindVertexArray(vertex_array_.id());
  if (order_eye_ == eye) return;
  const std::vector<std::uint32_t> triangles = drawing_order(*mesh_, eye.cast<float>());
  std::vector<std::uint32_t> corners;
  corners.reserve(3 * triangles.size());
  for (const std::uint32_t t : triangles) corners.insert(corners.end(), {3 * t, 3 * t + 1, 3 * t + 2});
  glBindBuffer(GL_ELEMENT_ARRAY_BUFFER, order_.id());
  glBufferData(GL_ELEMENT_ARRAY_BUFFER, static_cast<GLsizeiptr>(corners.size() * sizeof corners[0]), corners.data(),
               GL_STREAM_DRAW);
  order_eye_ = eye;
}

void LightFieldRenderer::draw(const Viewpoint& viewpoint, const DrawArea& area, SurfaceShading shading) {
  if (!shown_ || triangle_count_ == 0) return;
  const Eigen::Vector3d eye = viewpoint.eye();
  if (shading == SurfaceShading::kShape && mesh_->evidence.empty()) shading = SurfaceShading::kPlain;
  if (shading == SurfaceShading::kAppearance || shading == SurfaceShading::kStates)
    upload_coefficients(eye);
  else if (const std::optional<Demand> demand = demand_of(shading))
    upload_demand(*demand);
  else if (shading == SurfaceShading::kShape)
    upload_evidence();
  else if (shading != SurfaceShading::kPlain)
    upload_quality(eye);

  make_program();
  program_.use();
  const Eigen::Matrix4f clip = clip_from_object(viewpoint, bounding_sphere(*mesh_));
  const Eigen::Vector3f eye_f = eye.cast<float>();
  glUniformMatrix4fv(program_.uniform("clip_from_object"), 1, GL_FALSE, clip.data());
  glUniform3fv(program_.uniform("eye"), 1, eye_f.data());
  glUniform1f(program_.uniform("exposure"), exposure_.at(eye));
  glUniform1i(program_.uniform("coefficient_stride"), stride_);
  glUniform1i(program_.uniform("shading"), static_cast<int>(shading));
  glUniform1f(program_.uniform("pixel_size"), area.pixel_size);
  positions_.bind(kPositions);
  corners_.bind(kCorners);
  resolutions_.bind(kResolutions);
  slots_.bind(kSlots);
  coefficients_.bind(kCoefficients);
  quality_.bind(kQuality);
  store_.bind(kBasis);

  const Panel& panel = area.panel;
  glViewport(panel.x, area.target_height - panel.y - panel.height, panel.width, panel.height);
  glEnable(GL_DEPTH_TEST);
  glClear(GL_DEPTH_BUFFER_BIT);
  upload_order(eye);
  glDrawElements(GL_TRIANGLES, static_cast<GLsizei>(3 * triangle_count_), GL_UNSIGNED_INT, nullptr);
  glDisable(GL_DEPTH_TEST);
  check_gl("drawing the surface light field");
}

}  // namespace sheen
