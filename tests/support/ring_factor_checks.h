// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>

#include "reconstructor/numerics/ring_factor.h"

namespace sheen {

/// What a factor promises whatever was done to it: B^T B = I, everything finite, the spectrum sorted and the trace of
/// G, rank and views within their limits, energies in order. Empty when all holds, else what does not.
template <typename Scalar>
std::string broken_invariants(const BasicRingFactor<Scalar>& factor);

/// Relative error ||C - B Y|| / ||C|| of all terms of a settled factor; the columns in the order of its views.
template <typename Scalar>
double model_error(const BasicRingFactor<Scalar>& settled, const Eigen::MatrixXf& columns);
/// The same of the displayed terms.
template <typename Scalar>
double displayed_model_error(const BasicRingFactor<Scalar>& settled, const Eigen::MatrixXf& columns);

/// The factor of all columns with nothing pending.
RingFactor settled_factor(const Eigen::MatrixXf& columns, const RingFactorOptions& options);

}  // namespace sheen
