// SPDX-License-Identifier: Apache-2.0
#include "tests/support/online_svd_checks.h"

#include <cmath>
#include <limits>
#include <sstream>

#include "tests/support/matchers.h"

namespace sheen {

template <typename Scalar>
std::string broken_invariants(const BasicOnlineSvd<Scalar>& factor, std::int64_t columns) {
  std::ostringstream broken;
  const auto demand = [&](bool holds, const char* what, double value) {
    if (!holds) broken << what << ": " << value << "\n";
  };
  const OnlineSvdOptions& options = factor.options();
  const int rank = factor.rank();
  demand(rank <= options.terms_kept(), "rank above the terms kept", rank);
  demand(rank <= factor.rows(), "rank above the rows", rank);
  demand(rank <= columns, "rank above the columns", rank);
  demand(factor.displayed_rank() <= options.max_rank, "displayed rank", factor.displayed_rank());
  demand(factor.displayed_rank() <= rank, "displayed rank above the rank", factor.displayed_rank());
  demand(factor.views() == factor.folded_views() + factor.pending(), "views", factor.views());
  demand(factor.pending() < std::max(options.block, 1), "pending columns", factor.pending());
  demand(factor.coefficients().rows() == rank && factor.coefficients().cols() == factor.folded_views(),
         "shape of the coefficients", static_cast<double>(factor.coefficients().size()));
  demand(factor.gram().rows() == rank && factor.gram().cols() == rank, "shape of G",
         static_cast<double>(factor.gram().size()));
  demand(factor.spectrum().size() == rank, "length of the spectrum", static_cast<double>(factor.spectrum().size()));
  if (!broken.str().empty()) return broken.str();

  demand(factor.basis().allFinite(), "basis is not finite", rank);
  demand(factor.coefficients().allFinite(), "coefficients are not finite", rank);
  demand(factor.gram().allFinite(), "G is not finite", rank);
  demand(factor.spectrum().allFinite(), "spectrum is not finite", rank);
  demand(std::isfinite(factor.energy()) && std::isfinite(factor.lost_energy()), "energy is not finite",
         factor.energy());
  if (!broken.str().empty()) return broken.str();

  const double energy = factor.energy();
  demand(factor.lost_energy() >= 0, "lost energy", factor.lost_energy());
  demand(factor.lost_energy() <= energy, "lost energy above the energy", factor.lost_energy());
  demand(factor.relative_error() <= factor.displayed_error() + 1e-12, "displayed error below the whole one",
         factor.displayed_error());
  demand(factor.row_noise() >= 0 && std::isfinite(factor.row_noise()), "row noise", factor.row_noise());
  if (rank == 0) return broken.str();

  constexpr double kFixedPoint = 2e-3;  // of 16 bits, the largest of 320 rows and four folds between two polishes
  const double precision = options.sensor_variance > 0 ? kFixedPoint : std::is_same_v<Scalar, float> ? 1e-6 : 1e-12;
  const double loss = orthogonality_loss(factor.orthonormal_basis());
  demand(loss <= precision, "orthogonality lost", loss);
  const double off_trace = std::abs(factor.spectrum().sum() - factor.gram().trace());
  demand(off_trace <= 1e-9 * energy, "spectrum and trace of G differ by", off_trace / energy);
  const double asymmetry = (factor.gram() - factor.gram().transpose()).cwiseAbs().maxCoeff();
  demand(asymmetry <= 1e-12 * energy, "G is not symmetric by", asymmetry / energy);
  demand(factor.spectrum().minCoeff() >= -1e-12 * energy, "negative spectrum", factor.spectrum().minCoeff());
  for (int i = 1; i < rank; ++i)
    demand(factor.spectrum()[i] <= factor.spectrum()[i - 1], "spectrum is not sorted at", i);
  return broken.str();
}

namespace {

/// In double: squares of floats overflow. Weights of columns do not matter here.
double relative(const Eigen::MatrixXd& model, const Eigen::MatrixXf& columns) {
  return (columns.cast<double>() - model).norm() / columns.cast<double>().norm();
}

}  // namespace

template <typename Scalar>
double model_error(const BasicOnlineSvd<Scalar>& settled, const Eigen::MatrixXf& columns) {
  return relative(settled.basis().template cast<double>() * settled.coefficients().template cast<double>(), columns);
}

template <typename Scalar>
double displayed_model_error(const BasicOnlineSvd<Scalar>& settled, const Eigen::MatrixXf& columns) {
  return relative(
      settled.displayed_basis().template cast<double>() * settled.displayed_coefficients().template cast<double>(),
      columns);
}

OnlineSvd settled_factor(const Eigen::MatrixXf& columns, const OnlineSvdOptions& options) {
  OnlineSvd factor(static_cast<int>(columns.rows()), options);
  for (Eigen::Index j = 0; j < columns.cols(); ++j) factor.add(columns.col(j));
  return factor.settled();
}

template std::string broken_invariants(const OnlineSvd&, std::int64_t);
template std::string broken_invariants(const OnlineSvdDouble&, std::int64_t);
template double model_error(const OnlineSvd&, const Eigen::MatrixXf&);
template double model_error(const OnlineSvdDouble&, const Eigen::MatrixXf&);
template double displayed_model_error(const OnlineSvd&, const Eigen::MatrixXf&);
template double displayed_model_error(const OnlineSvdDouble&, const Eigen::MatrixXf&);

}  // namespace sheen
