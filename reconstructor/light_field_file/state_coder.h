// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <algorithm>
#include <array>
#include <span>
#include <vector>

#include "reconstructor/coding/context_coder.h"
#include "reconstructor/light_field_file/open_edges.h"
#include "reconstructor/light_field_file/state_coding.h"

/// How states of samples are coded: one description that writing and reading share.
namespace sheen::state_coder {

// Contexts, one range after the other; a state takes two bits.
constexpr int kStates = 3, kNone = kStates, kKnown = kStates + 1;  ///< a state, or none
constexpr int kAcross = kKnown + 1, kMixed = kKnown;               ///< states along all edges that are known
constexpr int kNear = 3;                                           ///< how far an edge is: 0, 1, or more samples
enum StateContext : int {
  kSame = 0,
  kAll = kSame + kAcross * kKnown,
  kBeside = kAll + 2 * kAcross * kKnown,
  kByEdge = kBeside + 2 * kKnown * kKnown * kKnown,
  kStateContexts = kByEdge + 2 * kKnown * kKnown * kKnown * kNear,
};
constexpr int kStateMixers = 2 * kKnown;

/// All samples of a triangle.
using States = std::span<SampleState>;

template <typename Coder>
class StateCoder {
 public:
  StateCoder(Coder& coder, const CompactModel& model, std::vector<SampleState>& states)
      : coder_(coder), model_(model), states_(states) {
    for (std::size_t v = 0; v < model.mesh->vertices.size(); ++v) edges_.add_vertex();
  }

  void code() {
    for (std::size_t t = 0; t < model_.mesh->triangles.size(); ++t) {
      find_across(t);
      code_triangle(t);
      for (std::size_t k = 0; k < 3; ++k) edges_.add(corner(t, k), corner(t, (k + 1) % 3));
    }
  }

 private:
  std::uint32_t corner(std::size_t t, std::size_t k) const { return model_.mesh->triangles[t][k]; }
  States states_of(std::size_t t) const {
    return States(states_).subspan(model_.maps->first_sample(t),
                                   static_cast<std::size_t>(lattice_samples(model_.maps->resolution(t))));
  }

  /// The edges of triangles before that have the triangle on their other side.
  void find_across(std::size_t t) {
    for (std::size_t k = 0; k < 3; ++k) across_[k] = edges_.between(corner(t, (k + 1) % 3), corner(t, k));
  }

  /// The state that the triangle across edge k has at `along` of `last` from the edge's beginning.
  int state_across(std::size_t k, int along, int last) const {
    const std::size_t t = across_[k] / 3;
    const int n = model_.maps->resolution(t);
    const int s = ((last - along) * (n - 1) + last / 2) / last;  // it runs the other way
    const int edge = static_cast<int>(across_[k] % 3);
    const int i = edge == 0 ? s : edge == 1 ? n - 1 - s : 0, j = edge == 0 ? 0 : edge == 1 ? s : n - 1 - s;
    return static_cast<int>(states_of(t)[static_cast<std::size_t>(lattice_index(n, i, j))]);
  }

  /// The one state that all samples across have.
  int state_all_across(int n) const {
    int all = kNone;
    for (std::size_t k = 0; k < 3; ++k)
      for (int along = 0; across_[k] != OpenEdges::kNone && along < n; ++along) {
        const int state = state_across(k, along, n - 1);
        if (all != kNone && all != state) return kMixed;
        all = state;
      }
    return all;
  }

  void code_triangle(std::size_t t) {
    const States states = states_of(t);
    const int n = model_.maps->resolution(t), context = state_all_across(n) * kKnown + last_;
    if (coder_.bit(kSame + context, std::all_of(states.begin(), states.end(),
                                                [&](SampleState state) { return state == states.front(); }))) {
      const SampleState all = code_state(std::array{kAll + 2 * context}, 0, states.front());
      std::fill(states.begin(), states.end(), all);
      last_ = static_cast<int>(all);
      return;
    }
    last_ = kNone;
    for (int i = 0; i < n; ++i)
      for (int j = 0; i + j < n; ++j) code_sample(states, n, i, j);
  }

  void code_sample(States states, int n, int i, int j) {
    const auto at = [&](int a, int b) {
      return static_cast<int>(states[static_cast<std::size_t>(lattice_index(n, a, b))]);
    };
    const int before = j > 0 ? at(i, j - 1) : kNone, above = i > 0 ? at(i - 1, j) : kNone,
              behind = i > 0 ? at(i - 1, j + 1) : kNone;
    const std::array<int, 3> weight = {n - 1 - i - j, i, j};  // of the corners
    int by_edge = kNone, distance = n;
    for (std::size_t k = 0; k < 3; ++k) {
      const int to_edge = weight[(k + 2) % 3];
      if (across_[k] == OpenEdges::kNone || to_edge >= distance) continue;
      distance = to_edge;
      by_edge = state_across(k, weight[(k + 1) % 3] + to_edge / 2, n - 1);
    }
    const std::array contexts = {
        kBeside + 2 * ((before * kKnown + above) * kKnown + behind),
        kByEdge + 2 * (((before * kKnown + above) * kKnown + by_edge) * kNear + std::min(distance, kNear - 1)),
    };
    SampleState& state = states[static_cast<std::size_t>(lattice_index(n, i, j))];
    state = code_state(contexts, 2 * before, state);
  }

  template <std::size_t kCount>
  SampleState code_state(std::array<int, kCount> contexts, int mixer, SampleState state) {
    if (coder_.bit(contexts, mixer, state == SampleState::kMeasured)) return SampleState::kMeasured;
    for (int& context : contexts) ++context;
    return coder_.bit(contexts, mixer + 1, state == SampleState::kImputed) ? SampleState::kImputed
                                                                           : SampleState::kUnseen;
  }

  Coder& coder_;
  const CompactModel& model_;
  std::vector<SampleState>& states_;
  OpenEdges edges_;
  std::array<std::uint32_t, 3> across_{};  ///< per edge of the triangle at hand
  int last_ = static_cast<int>(SampleState::kMeasured);
};

}  // namespace sheen::state_coder
