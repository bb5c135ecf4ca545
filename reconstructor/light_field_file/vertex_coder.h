// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <stdexcept>

#include "reconstructor/coding/context_coder.h"
#include "reconstructor/coding/powers.h"
#include "reconstructor/light_field_file/grid_geometry.h"
#include "reconstructor/light_field_file/vertex_coding.h"
#include "reconstructor/surface/view_hemisphere.h"

/// How vertices are coded: one description that writing and reading share.
namespace sheen::vertex_coder {

constexpr int kReliabilityTwelfths = 8, kSillTwelfths = 1;  // of an octave: a step
constexpr float kLeastSill = 1e-12f;
constexpr std::int32_t kMostReliability = 60, kMostSill = 800, kMostResidual = 255;
constexpr float kDirectionSteps = 1000, kMostOffset = 700;
constexpr int kFacingBuckets = 8;

/// `cosine`: in parts of GridFacing::kOne.
inline int facing_bucket(std::int64_t cosine) {
  constexpr std::int64_t kBucket = kFacingBuckets - 1;
  if (cosine < 0) return 0;
  return static_cast<int>(std::min(cosine * kBucket / GridFacing::kOne + 1, kBucket));
}

/// The reliability that a view of this cosine is expected to have, in steps: 3/2 log2 of the cosine, at least of 0.05.
inline std::int32_t reliability_by_facing(std::int64_t cosine) {
  constexpr std::int64_t kLeastOfStep[] = {3251, 2048, 1290, 813, 512, 323};  // 2^12 2^((1/2 - step) 2/3)
  std::int32_t steps = 0;
  for (const std::int64_t least : kLeastOfStep) steps -= cosine < least;
  return steps;
}

inline std::int32_t steps_of(float value, int twelfths) {
  return static_cast<std::int32_t>(std::lround(12 * std::log2(value) / static_cast<float>(twelfths)));
}

inline std::int32_t reliability_steps(float reliability) {
  return steps_of(std::clamp(reliability, 1e-6f, 1e6f), kReliabilityTwelfths);
}
inline float reliability_of(std::int32_t steps) {
  return static_cast<float>(
      power_of_two(kReliabilityTwelfths * std::clamp(steps, -kMostReliability, kMostReliability)));
}

inline std::int32_t sill_steps(float sill) {
  return steps_of(std::max(sill, kLeastSill) / kLeastSill, kSillTwelfths);
}
inline float sill_of(std::int32_t steps) {
  return static_cast<float>(double{kLeastSill} * power_of_two(kSillTwelfths * steps));
}

inline std::int32_t residual_steps(float residual) {
  return static_cast<std::int32_t>(std::lround(static_cast<float>(kMostResidual) * std::clamp(residual, 0.0f, 1.0f)));
}
inline float residual_of(std::int32_t steps) {
  return static_cast<float>(steps) / static_cast<float>(kMostResidual);
}

// Contexts of the vertices, one range after the other.
constexpr int kNeighbours = 3;         ///< of a vertex, among those before it
constexpr int kOff = 9, kNone = kOff;  ///< surplus of reliability: -4 or less to 4 or more; none is known
enum VertexContext : int {
  kSeen = 0,
  kSameKernel = kSeen + 2,
  kKernel = kSameKernel + 1,
  kDrift = kKernel + kNumberContexts,
  kSill = kDrift + 2,
  kResidual = kSill + kSignedContexts,
  kFolded = kResidual + kSignedContexts,
  kHas = kFolded + kSignedContexts,
  kHasNear = kHas + 2 * kFacingBuckets * 2,
  kReliability = kHasNear + kFacingBuckets * (kNeighbours + 1) * (kNeighbours + 1),
  kReliabilityNear = kReliability + kFacingBuckets * (kOff + 1) * kSignedContexts,
  kReliabilityBeside = kReliabilityNear + (kOff + 1) * (kOff + 1) * kSignedContexts,
  kMoved = kReliabilityBeside + (kOff + 1) * (kOff + 1) * kSignedContexts,
  kOffset = kMoved + 1,
  kVertexContexts = kOffset + kSignedContexts,
};
enum VertexMixer : int {
  kHasMixer = 0,
  kReliabilityMixer = kHasMixer + kFacingBuckets,
  kVertexMixers = kReliabilityMixer + kSignedContexts,
};

inline int off_bucket(std::int32_t surplus) {
  return std::clamp(surplus, -kOff / 2, kOff / 2) + kOff / 2;
}

/// For each vertex some that it has an edge with, of those before it.
inline std::vector<std::array<std::uint32_t, kNeighbours>> neighbours_before(const Mesh& mesh) {
  std::vector<std::array<std::uint32_t, kNeighbours>> before(mesh.vertices.size(), {kNoVertex, kNoVertex, kNoVertex});
  for (const Triangle& triangle : mesh.triangles)
    for (const std::uint32_t v : triangle)
      for (const std::uint32_t other : triangle)
        if (other < v)
          for (std::uint32_t& neighbour : before[v]) {
            if (neighbour == other) break;
            if (neighbour != kNoVertex) continue;
            neighbour = other;
            break;
          }
  return before;
}

/// By how much a value differs from the last one, which it takes the place of. A damaged file adds up to anything.
template <typename Coder>
void code_after(Coder& coder, int context, std::int32_t value, std::int32_t& last) {
  constexpr std::int32_t kMost = 1 << 24;
  last = std::clamp(last + code_signed(coder, context, value - last), -kMost, kMost);
}

/// Writes what is known of the vertices, and leaves in the model what a reader will find; where `coder` reads, it is
/// filled. A vertex is coded after the one before it, which is mostly near, and after its neighbours.
template <typename Coder>
class VertexCoder {
 public:
  VertexCoder(Coder& coder, CompactModel& model)
      : coder_(coder),
        model_(model),
        facing_(*model.grid),
        neighbours_(neighbours_before(*model.mesh)),
        sill_(model.vertices.size()),
        residual_(model.vertices.size()),
        surplus_(model.vertices.size()),
        has_(model.cameras.size(), false),
        near_(model.cameras.size()) {}

  void code() {
    for (std::size_t v = 0; v < model_.vertices.size(); ++v) code_vertex(v);
  }

 private:
  /// What the neighbours of a vertex say of a camera.
  struct Near {
    std::int32_t views = 0, surplus = 0;  ///< and its sum

    std::int32_t mean() const { return views > 0 ? (2 * surplus + views * 129) / (2 * views) - 64 : 0; }
  };

  void code_vertex(std::size_t v) {
    CompactVertex& vertex = model_.vertices[v];
    vertex.seen = coder_.bit(kSeen + seen_, vertex.seen);
    seen_ = vertex.seen;
    if (!vertex.seen) return;
    if (!coder_.bit(kSameKernel, vertex.kernel == kernel_))
      kernel_ = static_cast<int>(code_number(coder_, kKernel, vertex.kernel));
    if (kernel_ >= static_cast<int>(model_.kernels.size())) throw std::runtime_error("a vertex has no kernel");
    vertex.kernel = static_cast<std::uint8_t>(kernel_);
    drift_ = vertex.drift = coder_.bit(kDrift + drift_, vertex.drift);
    vertex.sill = sill_of(code_near(v, kSill, sill_steps(vertex.sill), kMostSill, sill_));
    vertex.residual = residual_of(code_near(v, kResidual, residual_steps(vertex.residual), kMostResidual, residual_));
    code_views(v, vertex);
    code_after(coder_, kFolded, vertex.views_folded - static_cast<int>(vertex.views.size()), folded_surplus_);
    vertex.views_folded = static_cast<int>(vertex.views.size()) + folded_surplus_;
    if (vertex.views.empty()) throw std::runtime_error("a vertex that was seen has no view");
  }

  /// A number of steps, 0 to `most`, beyond the mean of those that the neighbours have. Noted in `known`.
  std::int32_t code_near(std::size_t v, int context, std::int32_t wanted, std::int32_t most,
                         std::vector<std::int32_t>& known) {
    std::int32_t sum = 0, count = 0;
    for (const std::uint32_t neighbour : neighbours_[v])
      if (neighbour != kNoVertex && model_.vertices[neighbour].seen) {
        sum += known[neighbour];
        ++count;
      }
    const std::int32_t expected = count > 0 ? (2 * sum + count) / (2 * count) : 0;
    const std::int32_t beyond = code_signed(coder_, context, std::min(wanted, most) - expected);
    return known[v] = std::clamp(expected + beyond, 0, most);
  }

  void code_views(std::size_t v, CompactVertex& vertex) {
    std::fill(near_.begin(), near_.end(), Near{});
    int known = 0;  // neighbours
    for (const std::uint32_t neighbour : neighbours_[v]) {
      if (neighbour == kNoVertex || !model_.vertices[neighbour].seen) continue;
      ++known;
      const std::vector<CompactView>& views = model_.vertices[neighbour].views;
      for (std::size_t i = 0; i < views.size(); ++i) {
        Near& near = near_[views[i].image];
        ++near.views;
        near.surplus += surplus_[neighbour][i];
      }
    }
    std::vector<CompactView> views;
    std::int32_t beside = 0;  // surplus of the view before
    auto next = vertex.views.begin();
    for (std::size_t camera = 0; camera < model_.cameras.size(); ++camera) {
      const std::int64_t facing = facing_.cosine(v, model_.eyes[camera]);
      const int facing_at = facing_bucket(facing);
      const bool wanted = !Coder::kReads && next != vertex.views.end() && next->image == camera;
      const int last = camera > 0 ? has_[camera - 1] : 0;
      const Near& near = near_[camera];
      const std::array has_contexts = {
          kHas + (facing_at * 2 + has_[camera]) * 2 + last,
          kHasNear + (facing_at * (kNeighbours + 1) + known) * (kNeighbours + 1) + near.views,
      };
      has_[camera] = coder_.bit(has_contexts, kHasMixer + facing_at, wanted);
      if (!has_[camera]) continue;
      CompactView view;
      if (wanted) view = *next++;
      view.image = static_cast<std::uint16_t>(camera);
      const std::int32_t by_facing = reliability_by_facing(facing), by_near = near.mean();
      const int near_at = near.views > 0 ? off_bucket(by_near) : kNone,
                beside_at = views.empty() ? kNone : off_bucket(beside);
      const std::array contexts = {
          kReliability + (facing_at * (kOff + 1) + near_at) * kSignedContexts,
          kReliabilityNear +
              (near_at * (kOff + 1) + (near.views > 0 ? off_bucket(near.surplus - by_near * near.views) : kNone)) *
                  kSignedContexts,
          kReliabilityBeside + (near_at * (kOff + 1) + beside_at) * kSignedContexts,
      };
      const std::int32_t off = code_signed(coder_, contexts, kReliabilityMixer,
                                           wanted ? reliability_steps(view.reliability) - by_facing - by_near : 0);
      beside = off;
      view.reliability = reliability_of(by_facing + by_near + off);
      surplus_[v].push_back(static_cast<std::int8_t>(std::clamp(by_near + off, -kMostReliability, kMostReliability)));
      code_direction(camera_direction(model_, v, camera), wanted, view);
      views.push_back(view);
    }
    vertex.views = std::move(views);
  }

  /// That of the camera, or one beside it, in the plane across its direction.
  void code_direction(const Eigen::Vector3f& exact, bool wanted, CompactView& view) {
    view.moved = coder_.bit(kMoved, view.moved);
    if (!view.moved) {
      view.direction = exact;
      return;
    }
    const Eigen::Matrix3f frame = hemisphere_frame(exact);
    Eigen::Vector2f offset = Eigen::Vector2f::Zero();
    if (wanted) offset = kDirectionSteps * (frame * view.direction).head<2>();
    for (int axis = 0; axis < 2; ++axis) {
      const std::int32_t steps = code_signed(coder_, kOffset, static_cast<std::int32_t>(std::lround(offset[axis])));
      offset[axis] = std::clamp(static_cast<float>(steps), -kMostOffset, kMostOffset) / kDirectionSteps;
    }
    view.direction = frame.transpose() *
                     Eigen::Vector3f(offset.x(), offset.y(), std::sqrt(std::max(0.0f, 1 - offset.squaredNorm())));
  }

  Coder& coder_;
  CompactModel& model_;
  const GridFacing facing_;
  const std::vector<std::array<std::uint32_t, kNeighbours>> neighbours_;
  std::vector<std::int32_t> sill_, residual_;      ///< per vertex: in steps
  std::vector<std::vector<std::int8_t>> surplus_;  ///< per vertex and view: of reliability, beyond what its angle says
  // Of the vertex before:
  bool seen_ = true, drift_ = false;
  int kernel_ = 0;
  std::int32_t folded_surplus_ = 0;
  std::vector<bool> has_;   ///< per camera
  std::vector<Near> near_;  ///< per camera: of the vertex at hand
};

}  // namespace sheen::vertex_coder
