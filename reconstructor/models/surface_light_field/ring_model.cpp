// SPDX-License-Identifier: Apache-2.0
#include "reconstructor/models/surface_light_field/ring_model.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "reconstructor/models/surface_light_field/fill_unseen.h"

namespace sheen {
namespace {

constexpr int kFirstKernelChoice = 5;  // views; fewer say nothing about how fast a ring varies
constexpr float kKernelChoiceGrowth = 1.4f;
constexpr float kSensorVariance = 2e-5f;  // about one grey level of 255, encoded
constexpr float kNoiseMemory = 0.8f;

Eigen::Matrix3Xf as_matrix(const std::vector<Eigen::Vector3f>& vectors) {
  Eigen::Matrix3Xf m(3, static_cast<Eigen::Index>(vectors.size()));
  for (std::size_t i = 0; i < vectors.size(); ++i) m.col(static_cast<Eigen::Index>(i)) = vectors[i];
  return m;
}

}  // namespace

RingModel::Absorbed RingModel::absorb(Eigen::VectorXf& column, std::span<const std::uint8_t> visible,
                                      const Eigen::Vector3f& direction, float cosine, float reliability) {
  Absorbed result;
  const auto shown = static_cast<std::size_t>(std::count(visible.begin(), visible.end(), 1));
  if (shown == 0 || shown < options_.min_visible * visible.size()) return result;
  result.used = true;
  if (shown < visible.size() || !all_seen_) fill_hidden(column, visible);
  for (std::size_t s = 0; s < visible.size(); ++s)
    if (visible[s] && shown_[s] < std::numeric_limits<std::uint16_t>::max()) ++shown_[s];
  all_seen_ = all_seen_ || std::find(shown_.begin(), shown_.end(), std::uint16_t{0}) == shown_.end();

  const float share = static_cast<float>(shown) / static_cast<float>(visible.size());
  const ColumnReport report = factor_.add(column, share);
  result.energy = report.norm * report.norm * share;
  result.residual_energy = report.residual_norm * report.residual_norm;  // imputed rows lie in the basis

  const auto known_rows = static_cast<float>(3 * shown);
  if (images_folded_ > 0) {
    const float variance = static_cast<float>(result.residual_energy) / known_rows;
    noise_ = kNoiseMemory * noise_ + (1 - kNoiseMemory) * variance;
    const auto memory = static_cast<float>(options_.residual_memory);
    const auto relative = static_cast<float>(report.residual_norm / std::max(report.norm, 1e-12));
    residual_ = memory * residual_ + (1 - memory) * relative;
  }
  best_cosine_ = std::max(best_cosine_, cosine);
  keep_view(direction, reliability * share);
  ++images_folded_;
  snapshot_.reset();
  result.wants_kernel = views() >= kFirstKernelChoice && images_folded_ > kKernelChoiceGrowth * kernel_chosen_at_;
  return result;
}

void RingModel::fill_hidden(Eigen::VectorXf& column, std::span<const std::uint8_t> visible) {
  const int samples = static_cast<int>(visible.size());
  std::vector<std::uint8_t> known(3 * visible.size(), 0);
  std::vector<int> new_samples;
  for (int s = 0; s < samples; ++s) {
    if (visible[s] && shown_[s]) std::fill_n(known.begin() + 3 * s, 3, std::uint8_t{1});
    if (visible[s] && !shown_[s]) new_samples.push_back(s);
  }
  const int rank = factor_.rank();
  if (rank == 0) {
    for (int s = 0; s < samples; ++s)
      if (!visible[s]) column.segment<3>(3 * s).setZero();
    return;
  }

  const Eigen::VectorXf y = factor_.estimate(column, known, std::max(noise_, kSensorVariance));
  if (!new_samples.empty()) {
    // A point seen for the first time: the ring's earlier views never showed it, so it is taken to vary with the view
    // as the ring does on average, in proportion to its own colour now.
    Eigen::MatrixXf level = Eigen::MatrixXf::Zero(3, rank);  // mean basis row a channel
    int seen_samples = 0;
    for (int s = 0; s < samples; ++s)
      if (shown_[s]) {
        level += factor_.basis().middleRows<3>(3 * s);
        ++seen_samples;
      }
    level /= static_cast<float>(std::max(seen_samples, 1));
    const Eigen::Vector3f expected = level * y;
    const Eigen::RowVectorXf own = y.transpose() / std::max(y.squaredNorm(), 1e-12f);
    std::vector<int> rows;
    Eigen::MatrixXf basis_rows(3 * new_samples.size(), rank);
    for (const int s : new_samples)
      for (int c = 0; c < 3; ++c) {
        const int row = 3 * s + c;
        basis_rows.row(static_cast<Eigen::Index>(rows.size())) =
            expected[c] > 0.02f ? Eigen::RowVectorXf(column[row] / expected[c] * level.row(c)) : column[row] * own;
        rows.push_back(row);
      }
    factor_.reveal(rows, basis_rows);
    for (const int s : new_samples) std::fill_n(known.begin() + 3 * s, 3, std::uint8_t{1});
  }
  const Eigen::VectorXf full_y =
      new_samples.empty() ? y : factor_.estimate(column, known, std::max(noise_, kSensorVariance));
  for (int s = 0; s < samples; ++s) {
    if (visible[s]) continue;
    if (shown_[s])
      column.segment<3>(3 * s).noalias() = factor_.basis().middleRows<3>(3 * s) * full_y;
    else
      column.segment<3>(3 * s).setZero();
  }
}

void RingModel::keep_view(const Eigen::Vector3f& direction, float reliability) {
  directions_.push_back(direction);
  reliability_.push_back(reliability);
  images_.push_back(1);
  if (views() > options_.max_views) merge_nearest_views();
}

void RingModel::merge_nearest_views() {
  std::size_t a = 0, b = 1;
  float nearest = -2;
  for (std::size_t i = 0; i < directions_.size(); ++i)
    for (std::size_t j = i + 1; j < directions_.size(); ++j)
      if (const float cosine = directions_[i].dot(directions_[j]); cosine > nearest) {
        nearest = cosine;
        a = i;
        b = j;
      }
  const double share = double(images_[a]) / (images_[a] + images_[b]);
  factor_.merge_views(static_cast<int>(a), static_cast<int>(b), share);
  directions_[a] =
      (static_cast<float>(share) * directions_[a] + static_cast<float>(1 - share) * directions_[b]).normalized();
  reliability_[a] = std::max(reliability_[a], reliability_[b]);
  images_[a] += images_[b];
  directions_[b] = directions_.back();
  reliability_[b] = reliability_.back();
  images_[b] = images_.back();
  directions_.pop_back();
  reliability_.pop_back();
  images_.pop_back();
}

KernelErrors RingModel::kernel_errors() const {
  KernelErrors errors{};
  const Eigen::Matrix3Xf directions = as_matrix(directions_);
  const Eigen::Map<const Eigen::VectorXf> reliability(reliability_.data(), views());
  for (std::size_t k = 0; k < kViewKernels.size(); ++k)
    errors[k] = krige(directions, factor_.coefficients(), reliability, kViewKernels[k]).leave_one_out;
  return errors;
}

void RingModel::set_kernel(const ViewKernel& kernel) {
  kernel_chosen_at_ = images_folded_;
  if (kernel_ == kernel) return;
  kernel_ = kernel;
  snapshot_.reset();
}

std::size_t RingModel::bytes() const {
  return sizeof(*this) + factor_.bytes() + shown_.size() * sizeof(shown_[0]) +
         directions_.size() * (sizeof(Eigen::Vector3f) + sizeof(float) + sizeof(int));
}

std::shared_ptr<const RingSnapshot> RingModel::snapshot(const Eigen::Matrix3f& frame, std::span<const int> resolution) {
  if (snapshot_ || images_folded_ == 0) return snapshot_;
  auto snapshot = std::make_shared<RingSnapshot>();
  snapshot->basis = factor_.basis();
  snapshot->directions = as_matrix(directions_);
  const Eigen::Map<const Eigen::VectorXf> reliability(reliability_.data(), views());
  ViewInterpolant interpolant = krige(snapshot->directions, factor_.coefficients(), reliability, kernel_);
  snapshot->weights = std::move(interpolant.weights);
  snapshot->mean = std::move(interpolant.mean);
  snapshot->kernel = kernel_;
  snapshot->frame = frame;
  snapshot->views = triangulate_views(frame, snapshot->directions);
  snapshot->shown.resize(shown_.size());
  for (std::size_t s = 0; s < shown_.size(); ++s) snapshot->shown[s] = shown_share(shown_[s], images_folded_);
  snapshot->residual = residual_;
  snapshot->best_cosine = best_cosine_;
  snapshot->views_folded = images_folded_;
  fill_unseen_samples(*snapshot, resolution);
  snapshot_ = std::move(snapshot);
  return snapshot_;
}

}  // namespace sheen
