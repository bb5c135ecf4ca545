// SPDX-License-Identifier: Apache-2.0
#include "reconstructor/models/surface_light_field/compact/vertex_coding.h"

#include <algorithm>
#include <cmath>
#include <stdexcept>

#include "reconstructor/coding/context_coder.h"
#include "reconstructor/surface/view_hemisphere.h"

namespace sheen {
namespace {

constexpr float kReliabilitySteps = 1.5f;  // per octave
constexpr float kSillSteps = 12, kLeastSill = 1e-12f;
constexpr float kResidualSteps = 255;
constexpr float kDirectionSteps = 1000;
constexpr int kFacingBuckets = 8;

int facing_bucket(float cosine) {
  return std::clamp(static_cast<int>(std::floor(cosine * (kFacingBuckets - 1))) + 1, 0, kFacingBuckets - 1);
}

std::int32_t reliability_steps(float reliability) {
  return static_cast<std::int32_t>(std::lround(kReliabilitySteps * std::log2(std::clamp(reliability, 1e-6f, 1e6f))));
}
float reliability_of(std::int32_t steps) {
  return std::exp2(static_cast<float>(std::clamp(steps, -60, 60)) / kReliabilitySteps);
}

std::int32_t sill_steps(float sill) {
  return static_cast<std::int32_t>(std::lround(kSillSteps * std::log2(std::max(sill, kLeastSill) / kLeastSill)));
}
float sill_of(std::int32_t steps) {
  return kLeastSill * std::exp2(static_cast<float>(std::clamp(steps, 0, 800)) / kSillSteps);
}

/// What the vertices before say of the next.
struct VertexHistory {
  bool seen = true, drift = false;
  int kernel = 0;
  std::int32_t sill = 0, residual = 0, folded_surplus = 0;
  std::vector<std::uint8_t> has;          ///< per camera, in the vertex before
  std::vector<std::int32_t> reliability;  ///< per camera, beyond what its angle says
};

// Contexts of the vertices, one range after the other.
enum VertexContext : int {
  kSeen = 0,
  kSameKernel = kSeen + 2,
  kKernel = kSameKernel + 1,
  kDrift = kKernel + kNumberContexts,
  kSill = kDrift + 2,
  kResidual = kSill + kSignedContexts,
  kFolded = kResidual + kSignedContexts,
  kHas = kFolded + kSignedContexts,
  kReliability = kHas + 2 * kFacingBuckets * 2,
  kMoved = kReliability + 3 * kSignedContexts,
  kOffset = kMoved + 1,
  kVertexContexts = kOffset + kSignedContexts,
};

/// By how much a value differs from the last one, which it takes the place of. A damaged file adds up to anything.
template <typename Coder>
void code_after(Coder& coder, int context, std::int32_t value, std::int32_t& last) {
  constexpr std::int32_t kMost = 1 << 24;
  last = std::clamp(last + code_signed(coder, context, value - last), -kMost, kMost);
}

/// A vertex is coded after the one before it, which is mostly a neighbour. It is filled where `coder` reads.
template <typename Coder>
void code_vertex(Coder& coder, const CompactModel& model, std::size_t v, const Eigen::Vector3f& normal,
                 VertexHistory& before, CompactVertex& vertex) {
  vertex.seen = coder.bit(kSeen + before.seen, vertex.seen);
  before.seen = vertex.seen;
  if (!vertex.seen) return;
  if (!coder.bit(kSameKernel, vertex.kernel == before.kernel))
    before.kernel = static_cast<int>(code_number(coder, kKernel, vertex.kernel));
  if (before.kernel >= static_cast<int>(model.kernels.size())) throw std::runtime_error("a vertex has no kernel");
  vertex.kernel = static_cast<std::uint8_t>(before.kernel);
  before.drift = vertex.drift = coder.bit(kDrift + before.drift, vertex.drift);
  code_after(coder, kSill, sill_steps(vertex.sill), before.sill);
  code_after(coder, kResidual,
             static_cast<std::int32_t>(std::lround(kResidualSteps * std::clamp(vertex.residual, 0.0f, 1.0f))),
             before.residual);

  std::vector<CompactView> views;
  auto next = vertex.views.begin();
  for (std::size_t camera = 0; camera < model.cameras.size(); ++camera) {
    const Eigen::Vector3f exact = camera_direction(model, v, camera);
    const float facing = normal.dot(exact);
    const bool wanted = !Coder::kReads && next != vertex.views.end() && next->image == camera;
    const int last = camera > 0 ? before.has[camera - 1] : 0;
    const bool has = coder.bit(kHas + (facing_bucket(facing) * 2 + before.has[camera]) * 2 + last, wanted);
    before.has[camera] = has;
    if (!has) continue;
    CompactView view;
    if (wanted) view = *next++;
    view.image = static_cast<std::uint16_t>(camera);
    const std::int32_t expected = reliability_steps(std::max(facing, 0.05f));
    std::int32_t& surplus = before.reliability[camera];
    const int context = kReliability + std::min(std::abs(surplus), 2) * kSignedContexts;
    surplus = code_signed(coder, context, wanted ? reliability_steps(view.reliability) - expected : 0);
    view.reliability = reliability_of(expected + surplus);
    view.moved = coder.bit(kMoved, view.moved);
    if (view.moved) {  // beside the camera, in the plane across its direction
      const Eigen::Matrix3f frame = hemisphere_frame(exact);
      Eigen::Vector2f offset = Eigen::Vector2f::Zero();
      if (wanted) offset = (frame * view.direction).head<2>();
      for (int axis = 0; axis < 2; ++axis)
        offset[axis] = static_cast<float>(code_signed(
                           coder, kOffset, static_cast<std::int32_t>(std::lround(kDirectionSteps * offset[axis])))) /
                       kDirectionSteps;
      offset = offset.cwiseMax(-0.7f).cwiseMin(0.7f);
      view.direction = frame.transpose() *
                       Eigen::Vector3f(offset.x(), offset.y(), std::sqrt(std::max(0.0f, 1 - offset.squaredNorm())));
    } else {
      view.direction = exact;
    }
    views.push_back(view);
  }
  code_after(coder, kFolded, vertex.views_folded - static_cast<int>(views.size()), before.folded_surplus);
  vertex.views_folded = static_cast<int>(views.size()) + before.folded_surplus;
  vertex.views = std::move(views);
  vertex.sill = sill_of(before.sill);
  vertex.residual = static_cast<float>(std::clamp(before.residual, 0, 255)) / kResidualSteps;
  if (vertex.views.empty()) throw std::runtime_error("a vertex that was seen has no view");
}

/// Writes what is known of the vertices, and leaves in `model` what a reader will find.
template <typename Coder>
void code_vertices(Coder& coder, CompactModel& model) {
  VertexHistory before;
  before.has.assign(model.cameras.size(), 0);
  before.reliability.assign(model.cameras.size(), 0);
  const std::vector<Eigen::Vector3f> normals = vertex_normals(*model.mesh);
  for (std::size_t v = 0; v < model.vertices.size(); ++v)
    code_vertex(coder, model, v, normals[v], before, model.vertices[v]);
}

constexpr int kStateContexts = 3 + 3 * 2 + 9 * 2;

/// Most triangles are of one state.
template <typename Coder>
void code_states(Coder& coder, const CompactModel& model, std::vector<std::vector<SampleState>>& states) {
  const auto code = [&coder](int context, SampleState state) {  // two bits
    const bool measured = coder.bit(context, state == SampleState::kMeasured);
    if (measured) return SampleState::kMeasured;
    return coder.bit(context + 1, state == SampleState::kImputed) ? SampleState::kImputed : SampleState::kUnseen;
  };
  int last = static_cast<int>(SampleState::kMeasured);
  for (std::size_t t = 0; t < states.size(); ++t) {
    std::vector<SampleState>& state = states[t];
    const int n = model.maps->resolution(t);
    if (Coder::kReads) state.assign(static_cast<std::size_t>(lattice_samples(n)), SampleState::kUnseen);
    const bool same =
        coder.bit(last, std::all_of(state.begin(), state.end(), [&](SampleState s) { return s == state[0]; }));
    if (same) {
      const SampleState all = code(3 + 2 * last, state[0]);
      std::fill(state.begin(), state.end(), all);
      last = static_cast<int>(all);
      continue;
    }
    for (int i = 0; i < n; ++i)
      for (int j = 0; i + j < n; ++j) {
        const auto at = [&](int a, int b) {
          return static_cast<int>(state[static_cast<std::size_t>(lattice_index(n, a, b))]);
        };
        const int left = j > 0 ? at(i, j - 1) : 2, above = i > 0 ? at(i - 1, j) : 2;
        SampleState& here = state[static_cast<std::size_t>(lattice_index(n, i, j))];
        here = code(3 + 6 + 2 * (3 * left + above), here);
      }
    last = static_cast<int>(state.back());
  }
}

template <typename Coder>
void code_resolutions(Coder& coder, std::vector<std::uint8_t>& resolutions) {
  std::int32_t last = 0;
  for (std::uint8_t& resolution : resolutions) {
    last += code_signed(coder, 0, resolution - last);
    if (last < 2 || last > 255) throw std::runtime_error("a triangle's resolution cannot be");
    resolution = static_cast<std::uint8_t>(last);
  }
}

}  // namespace

std::string encode_resolutions(const std::vector<std::uint8_t>& resolutions) {
  ContextEncoder coder(kSignedContexts);
  std::vector<std::uint8_t> copy = resolutions;
  code_resolutions(coder, copy);
  return coder.finish();
}

std::vector<std::uint8_t> decode_resolutions(std::string_view bytes, std::size_t triangles) {
  ContextDecoder coder(kSignedContexts, bytes);
  std::vector<std::uint8_t> resolutions(triangles);
  code_resolutions(coder, resolutions);
  return resolutions;
}

std::string encode_vertices(CompactModel& model) {
  ContextEncoder coder(kVertexContexts);
  code_vertices(coder, model);
  return coder.finish();
}

void decode_vertices(std::string_view bytes, CompactModel& model) {
  ContextDecoder coder(kVertexContexts, bytes);
  model.vertices.assign(model.mesh->vertices.size(), {});
  code_vertices(coder, model);
}

std::string encode_states(const CompactModel& model) {
  ContextEncoder coder(kStateContexts);
  std::vector<std::vector<SampleState>> states;
  for (std::size_t t = 0; t < model.mesh->triangles.size(); ++t) {
    const auto first = model.patches[model.shapes.patch_of[t]].state.begin() + model.shapes.first_sample[t];
    states.emplace_back(first, first + lattice_samples(model.maps->resolution(t)));
  }
  code_states(coder, model, states);
  return coder.finish();
}

void decode_states(std::string_view bytes, CompactModel& model) {
  ContextDecoder coder(kStateContexts, bytes);
  std::vector<std::vector<SampleState>> states(model.mesh->triangles.size());
  code_states(coder, model, states);
  for (std::size_t t = 0; t < states.size(); ++t)
    std::copy(states[t].begin(), states[t].end(),
              model.patches[model.shapes.patch_of[t]].state.begin() + model.shapes.first_sample[t]);
}

}  // namespace sheen
