// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <string>

#include "reconstructor/numerics/online_svd.h"

namespace sheen {

/// What a factor promises whatever was done to it: B^T B = I (as far as it is kept), everything finite, the spectrum
/// sorted and the trace of G, rank and views within their limits, energies in order. Empty when all holds, else what
/// does not. `columns`: a bound of the rank. A column that is taken out of a merged view leaves its part of how they
/// scattered, and with it, as promised, its direction (`take_from`): the bound is then all columns that were ever
/// added.
template <typename Scalar>
std::string broken_invariants(const BasicOnlineSvd<Scalar>& factor, std::int64_t columns);
/// The same for a factor that no merged view was taken apart of.
template <typename Scalar>
std::string broken_invariants(const BasicOnlineSvd<Scalar>& factor) {
  return broken_invariants(factor, factor.columns_added());
}

/// Relative error ||C - B Y|| / ||C|| of all terms of a settled factor; the columns in the order of its views.
template <typename Scalar>
double model_error(const BasicOnlineSvd<Scalar>& settled, const Eigen::MatrixXf& columns);
/// The same of the displayed terms.
template <typename Scalar>
double displayed_model_error(const BasicOnlineSvd<Scalar>& settled, const Eigen::MatrixXf& columns);

/// The factor of all columns with nothing pending.
OnlineSvd settled_factor(const Eigen::MatrixXf& columns, const OnlineSvdOptions& options);

}  // namespace sheen
