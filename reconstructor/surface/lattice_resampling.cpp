// SPDX-License-Identifier: Apache-2.0
#include "reconstructor/surface/lattice_resampling.h"

#include <algorithm>

namespace sheen {
namespace {

/// Of a lattice, at the places of another's samples.
std::vector<LatticeStencil> stencils(int of, int at) {
  std::vector<LatticeStencil> stencils;
  stencils.reserve(static_cast<std::size_t>(lattice_samples(at)));
  for (int i = 0; i < at; ++i)
    for (int j = 0; i + j < at; ++j) stencils.push_back(lattice_stencil(of, at, {i, j}));
  return stencils;
}

template <int kValues>
using Values = Eigen::Matrix<float, kValues, Eigen::Dynamic>;

/// Of so many values for each sample.
template <int kValues>
Values<kValues> interpolated(const Eigen::Ref<const Values<kValues>>& values, const std::vector<LatticeStencil>& at) {
  Values<kValues> out(kValues, static_cast<Eigen::Index>(at.size()));
  for (Eigen::Index s = 0; s < out.cols(); ++s) {
    const LatticeStencil& stencil = at[static_cast<std::size_t>(s)];
    out.col(s) = stencil.weight[0] * values.col(stencil.index[0]) + stencil.weight[1] * values.col(stencil.index[1]) +
                 stencil.weight[2] * values.col(stencil.index[2]);
  }
  return out;
}

}  // namespace

LatticeResampling::LatticeResampling(int from, int to) : at_new_(stencils(from, to)), at_old_(stencils(to, from)) {}

Eigen::Matrix3Xf LatticeResampling::of(const Eigen::Ref<const Eigen::Matrix3Xf>& values) const {
  return interpolated<3>(values, at_new_);
}

Eigen::Matrix3Xf LatticeResampling::missed(const Eigen::Ref<const Eigen::Matrix3Xf>& values) const {
  return values - interpolated<3>(of(values), at_old_);
}

Eigen::VectorXf LatticeResampling::of_plane(const Eigen::Ref<const Eigen::VectorXf>& values) const {
  return interpolated<1>(values.transpose(), at_new_).transpose();
}

Eigen::VectorXf LatticeResampling::missed_of_plane(const Eigen::Ref<const Eigen::VectorXf>& values) const {
  return values - interpolated<1>(of_plane(values).transpose(), at_old_).transpose();
}

int LatticeResampling::nearest(int sample) const {
  const LatticeStencil& stencil = round(sample);
  return stencil.index[std::max_element(stencil.weight, stencil.weight + 3) - stencil.weight];
}

}  // namespace sheen
