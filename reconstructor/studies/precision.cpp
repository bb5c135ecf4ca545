// SPDX-License-Identifier: Apache-2.0
#include "reconstructor/studies/precision.h"

#include <algorithm>
#include <cmath>
#include <ctime>
#include <memory>
#include <span>
#include <utility>

#include "reconstructor/models/surface_light_field/fill_unseen.h"
#include "reconstructor/numerics/online_svd.h"
#include "reconstructor/studies/batch_light_field.h"

namespace sheen {
namespace {

double thread_cpu_s() {
  timespec now{};
  clock_gettime(CLOCK_THREAD_CPUTIME_ID, &now);
  return static_cast<double>(now.tv_sec) + 1e-9 * static_cast<double>(now.tv_nsec);
}

/// A patch's columns factorized in a number format.
struct Factorized {
  Eigen::MatrixXd basis, coefficients;  ///< of the displayed terms
  double cpu_s = 0;
  std::size_t bytes = 0;

  Eigen::MatrixXd product() const { return basis * coefficients; }
};

template <typename Scalar>
Factorized factorize(const PatchMatrix& patch, const OnlineSvdOptions& options, unsigned phase) {
  using Factor = BasicOnlineSvd<Scalar>;
  const typename Factor::Matrix columns = patch.columns.cast<Scalar>();
  Factor factor(static_cast<int>(columns.rows()), options, phase);
  const double start = thread_cpu_s();
  for (Eigen::Index j = 0; j < columns.cols(); ++j) {
    const auto known = patch.known.col(j);
    const bool whole = (known != 0).all();
    factor.add(columns.col(j),
               whole ? std::span<const std::uint8_t>()
                     : std::span<const std::uint8_t>(known.data(), static_cast<std::size_t>(known.size())));
  }
  const Factor all = factor.settled();
  return {.basis = all.displayed_basis().template cast<double>(),
          .coefficients = all.displayed_coefficients().template cast<double>(),
          .cpu_s = thread_cpu_s() - start,
          .bytes = factor.bytes()};
}

Eigen::MatrixXd rounded_to_half(const Eigen::MatrixXd& m) {
  return m.cast<Eigen::half>().cast<double>();
}

/// Sums over patches; a row is made of them.
struct Sums {
  double cpu_s = 0, bytes = 0, error2 = 0, difference2 = 0;

  void add(const PatchMatrix& patch, const Eigen::MatrixXd& product, const Eigen::MatrixXd& exact) {
    const auto known = patch.known.cast<double>();
    error2 += ((product - patch.columns.cast<double>()).array() * known).square().sum();
    difference2 += ((product - exact).array() * known).square().sum();
  }
  void into(PrecisionRow& row, double columns, double patches, double energy) const {
    row.column_us = 1e6 * cpu_s / columns;
    row.patch_bytes = bytes / patches;
    row.relative_error = std::sqrt(error2 / energy);
    row.difference = std::sqrt(difference2 / energy);
  }
};

std::shared_ptr<const SurfaceLightFieldSnapshot> terms_in_half(const SurfaceLightFieldSnapshot& whole) {
  const auto in_half = [](Eigen::MatrixXf& m) { m = m.cast<Eigen::half>().cast<float>().eval(); };
  SurfaceLightFieldSnapshot::Patches patches;
  for (const auto& patch : whole.patches()) {
    if (!patch) {
      patches.push_back(nullptr);
      continue;
    }
    auto rounded = std::make_shared<PatchSnapshot>(*patch);
    Eigen::MatrixXf basis = rounded->basis.unpacked();
    in_half(basis);
    rounded->basis = basis;
    for (VertexInterpolant& vertex : rounded->vertices) in_half(vertex.weights.exact());
    patches.push_back(std::move(rounded));
  }
  return std::make_shared<SurfaceLightFieldSnapshot>(whole.shared_mesh(), whole.shared_maps(), whole.shared_shapes(),
                                                     std::move(patches), whole.version(), whole.exposure());
}

}  // namespace

PrecisionStudy study_precision(const Experiment& experiment, const SurfaceLightFieldOptions& options,
                               const SurfaceLightFieldSnapshot& whole, std::size_t patches) {
  const std::size_t all = whole.shared_shapes()->patches.size();
  BatchLightField columns(experiment.mesh, options, std::max<std::size_t>(1, all / std::max<std::size_t>(patches, 1)));
  for (const Capture& capture : experiment.training) columns.add(capture);
  OnlineSvdOptions factor = options.patch.factor;
  factor.channels = 3;

  PrecisionStudy study;
  Sums single, twice, stored, stored_half;
  double energy = 0;
  for (std::size_t p = 0; p < columns.patches(); ++p) {
    const PatchMatrix patch = columns.patch(p);
    if (patch.views() == 0) continue;
    ++study.patches;
    study.columns += static_cast<std::size_t>(patch.views());
    energy += patch.columns.cast<double>().squaredNorm();
    const auto phase = static_cast<unsigned>(p);
    const Factorized f = factorize<float>(patch, factor, phase), d = factorize<double>(patch, factor, phase);
    const Eigen::MatrixXd exact = d.product();
    for (auto [sums, of] : {std::pair{&single, &f}, {&twice, &d}}) {
      sums->cpu_s += of->cpu_s;
      sums->bytes += static_cast<double>(of->bytes);
      sums->add(patch, of->product(), exact);
    }
    const auto terms = static_cast<double>(f.basis.size() + f.coefficients.size());
    stored.bytes += sizeof(float) * terms;
    stored.add(patch, f.product(), exact);
    stored_half.bytes += sizeof(Eigen::half) * terms;
    stored_half.add(patch, rounded_to_half(f.basis) * rounded_to_half(f.coefficients), exact);
  }
  const auto n = static_cast<double>(std::max<std::size_t>(study.columns, 1));
  const auto r = static_cast<double>(std::max<std::size_t>(study.patches, 1));
  for (auto [sums, row] : {std::pair{&single, &study.single},
                           {&twice, &study.twice},
                           {&stored, &study.stored},
                           {&stored_half, &study.stored_half}})
    sums->into(*row, n, r, std::max(energy, 1e-300));
  study.psnr_db = score(experiment.held_out, *fill_unseen(whole), *experiment.painter).psnr_db;
  study.psnr_half_db = score(experiment.held_out, *fill_unseen(*terms_in_half(whole)), *experiment.painter).psnr_db;
  return study;
}

}  // namespace sheen
