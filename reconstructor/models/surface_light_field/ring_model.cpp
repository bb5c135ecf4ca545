// SPDX-License-Identifier: Apache-2.0
#include "reconstructor/models/surface_light_field/ring_model.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

#include "reconstructor/models/surface_light_field/fill_unseen.h"

namespace sheen {
namespace {

// Runs of neighbouring samples share cache lines: an eighth of the samples is an eighth of the memory.
constexpr std::size_t kTestedRun = 16, kTestedEvery = 128;
// A repetition differs by its own noise and by that of the view it repeats, of which a basis has averaged a part.
constexpr double kRepeatedNoise = 1.5, kRepeatedColumn = 2;
constexpr float kSensorVariance = 2e-5f;  // about one grey level of 255, encoded

/// For each row of the column, whether it is known; empty when all are.
std::vector<std::uint8_t> known_rows(std::span<const std::uint8_t> visible, std::size_t shown) {
  if (shown == visible.size()) return {};
  std::vector<std::uint8_t> known(3 * visible.size());
  for (std::size_t row = 0; row < known.size(); ++row) known[row] = visible[row / 3];
  return known;
}

}  // namespace

RingFactorOptions ring_factor_options(RingFactorOptions options) {
  options.channels = 3;
  options.sensor_variance = kSensorVariance;
  return options;
}

double image_weight(const RingFactorOptions& options, double share_shown) {
  return options.imputation == Imputation::kLeastSquares ? 1 : share_shown * share_shown;
}

RingModel::RingModel(int samples, const RingModelOptions& options, unsigned phase)
    : options_(options),
      factor_(3 * samples, ring_factor_options(options.factor), phase),
      interpolation_(phase),
      shown_(static_cast<std::size_t>(samples), 0) {}

/// The paper's imputation takes images that show part of a ring only with half of it visible, and when the basis rests
/// on some that show all (000 sec. 3.2: after 8 to 10).
bool RingModel::shows_enough(std::size_t shown, std::size_t samples) const {
  constexpr int kFirstWhole = 9;
  const bool gated = options_.factor.imputation == Imputation::kLeastSquares && shown < samples;
  if (gated && (images_ < kFirstWhole || 2 * shown < samples)) return false;
  return shown > 0 && static_cast<double>(shown) >= options_.min_visible * static_cast<double>(samples);
}

RingModel::Absorbed RingModel::absorb(std::vector<SharedRows<float>> column, std::span<const std::uint8_t> visible,
                                      const Eigen::Vector3f& direction, float cosine, float reliability) {
  Absorbed result;
  const auto shown = static_cast<std::size_t>(std::count(visible.begin(), visible.end(), 1));
  if (!shows_enough(shown, visible.size())) return result;
  result.used = true;
  const float share = static_cast<float>(shown) / static_cast<float>(visible.size());
  const RingFactor::Reports folded =
      factor_.add(std::move(column), known_rows(visible, shown), image_weight(options_.factor, share));
  for (std::size_t s = 0; s < visible.size(); ++s)
    if (visible[s] && shown_[s] < std::numeric_limits<std::uint16_t>::max()) ++shown_[s];
  views_.add(direction, reliability * share);
  best_cosine_ = std::max(best_cosine_, cosine);
  ++images_;
  follow(folded, result);
  snapshot_.reset();
  result.wants_interpolation = can_choose_interpolation() && interpolation_.due(images_);
  return result;
}

void RingModel::fold_pending() {
  Absorbed unused;
  follow(factor_.fold(), unused);
}

void RingModel::withdraw(const Eigen::VectorXf& column, std::span<const std::uint8_t> visible,
                         const Eigen::Vector3f& direction) {
  const auto shown = static_cast<std::size_t>(std::count(visible.begin(), visible.end(), 1));
  if (images_ == 0 || !shows_enough(shown, visible.size())) return;
  const int view = views_.view_from(direction), folded = factor_.folded_views();
  if (view < folded) {
    const float share = static_cast<float>(shown) / static_cast<float>(visible.size());
    const double weight = factor_.weight_of(view), taken = image_weight(options_.factor, share);
    factor_.take_from(view, column, known_rows(visible, shown), taken);
    if (factor_.folded_views() < folded)
      views_.remove(view);
    else  // it was merged: the view moves back to where the others are
      views_.take_from(view, static_cast<float>(weight), direction, static_cast<float>(taken));
  } else {
    factor_.remove(view);
    views_.remove(view);
  }
  for (std::size_t s = 0; s < visible.size(); ++s)
    if (visible[s] && shown_[s] > 0) --shown_[s];
  --images_;
  snapshot_.reset();
}

float RingModel::nearest_cosine(const Eigen::Vector3f& direction) const {
  return views_.nearest(direction).cosine;
}

bool RingModel::may_repeat(const Eigen::Vector3f& direction) const {
  return options_.repeat_angle > 0 && nearest_cosine(direction) >= std::cos(static_cast<float>(options_.repeat_angle));
}

bool RingModel::repeats(const Eigen::VectorXf& column, std::span<const std::uint8_t> visible,
                        const Eigen::Vector3f& direction) const {
  if (!may_repeat(direction)) return false;
  const int view = views_.nearest(direction).view;
  const int waiting = view - factor_.folded_views();  // < 0: folded
  const Eigen::VectorXf coefficients = waiting < 0 ? factor_.coefficients().col(view) : Eigen::VectorXf();
  const auto kept = [&](Eigen::Index row) -> float {
    return waiting < 0 ? factor_.basis().row(row).dot(coefficients)
                       : factor_.pending_value(waiting, static_cast<int>(row));
  };
  double unexplained = 0;
  int rows = 0;
  for (std::size_t run = 0; run < visible.size(); run += kTestedEvery)
    for (std::size_t s = run; s < std::min(run + kTestedRun, visible.size()); ++s) {
      if (!visible[s]) continue;
      if (shown_[s] == 0) return false;
      const auto row = static_cast<Eigen::Index>(3 * s);
      const Eigen::Vector3f known(kept(row), kept(row + 1), kept(row + 2));
      unexplained += (column.segment<3>(row) - known).squaredNorm();
      rows += 3;
    }
  return rows > 0 && unexplained <= (waiting < 0 ? kRepeatedNoise : kRepeatedColumn) * factor_.row_noise() * rows;
}

void RingModel::follow(const RingFactor::Reports& reports, Absorbed& result) {
  for (const ColumnReport& report : reports) {
    result.energy += report.norm * report.norm;
    result.residual_energy += report.residual_norm * report.residual_norm;
    if (report.first) continue;
    const auto memory = static_cast<float>(options_.residual_memory);
    const auto relative = static_cast<float>(report.residual_norm / std::max(report.norm, 1e-12));
    residual_ = memory * residual_ + (1 - memory) * relative;
  }
  if (!reports.empty()) thin_views();
}

/// Two views that nearly coincide say the same: of more than `max_views`, the nearest two become one.
void RingModel::thin_views() {
  views_.set_folded(factor_.folded_views());
  while (factor_.folded_views() > options_.max_views) {
    const auto [kept, removed] = views_.closest_pair();
    views_.merge(kept, removed, static_cast<float>(factor_.weight_of(kept)),
                 static_cast<float>(factor_.weight_of(removed)));
    factor_.merge_views(kept, removed);
  }
}

void RingModel::limit_terms(int max_rank, int internal_rank, int block) {
  Absorbed unused;
  follow(factor_.limit(max_rank, internal_rank, block), unused);
  snapshot_.reset();
}

RingModel::Prediction RingModel::predict(const Eigen::VectorXf& column, std::span<const std::uint8_t> visible,
                                         const Eigen::Vector3f& direction, const Eigen::Vector3f& normal) const {
  Prediction predicted;
  if (rank() == 0) return predicted;
  const ViewInterpolant interpolant =
      interpolation_.krige(views_, with_pending(factor_.displayed_coefficients()), normal);
  const Eigen::VectorXf h = interpolation_.at(interpolant, views_, direction, normal);
  for (std::size_t s = 0; s < visible.size(); ++s) {
    const auto row = static_cast<Eigen::Index>(3 * s);
    const auto basis = factor_.displayed_basis().middleRows<3>(row);
    if (!visible[s] || basis.isZero(0)) continue;
    predicted.squared_error += (column.segment<3>(row) - basis * h).squaredNorm();
    predicted.values += 3;
  }
  return predicted;
}

bool RingModel::can_choose_interpolation() const {
  return RingInterpolation::can_choose(views());
}

/// Those of the folded views, and of the pending ones: rank x views.
Eigen::MatrixXf RingModel::with_pending(const Eigen::Ref<const Eigen::MatrixXf>& folded) const {
  Eigen::MatrixXf coefficients(rank(), views());
  coefficients << folded, factor_.pending_coefficients().topRows(rank());
  return coefficients;
}

/// Of all views. To tell how the ring varies, those that are at hand do: the ones that a picture is made of
/// (`displayed_coefficients`) differ for views that hide rows alone, and cost as much again as all the comparing.
Eigen::MatrixXf RingModel::known_coefficients() const {
  return with_pending(factor_.coefficients().topRows(rank()));
}

InterpolationErrors RingModel::interpolation_errors(const Eigen::Vector3f& normal) const {
  return interpolation_.errors(views_, known_coefficients(), normal);
}

void RingModel::set_interpolation(const ViewInterpolation& interpolation) {
  const bool same = interpolation_.chosen() == interpolation;
  interpolation_.choose(interpolation, images_);
  if (!same) snapshot_.reset();
}

void RingModel::set_reflection(std::shared_ptr<const ReflectionDrift> reflection) {
  interpolation_.share(std::move(reflection));
  if (interpolation_.chosen().drift) snapshot_.reset();
}

RingLevels RingModel::levels(const Eigen::Vector3f& normal) const {
  if (rank() == 0) return {normal, {}, {}, {}};  // all is black, or waits to be folded
  Eigen::MatrixXf mean = Eigen::MatrixXf::Zero(3, rank());
  int seen = 0;
  for (std::size_t s = 0; s < shown_.size(); ++s)
    if (shown_[s] > 0) {
      mean += factor_.displayed_basis().middleRows<3>(static_cast<Eigen::Index>(3 * s));
      ++seen;
    }
  return {normal, views_.direction_matrix(), mean / static_cast<float>(std::max(seen, 1)) * known_coefficients(),
          views_.reliability()};
}

std::size_t RingModel::bytes() const {
  return sizeof(*this) + factor_.bytes() + shown_.size() * sizeof(shown_[0]) + views_.bytes();
}

std::size_t RingModel::snapshot_bytes() const {
  if (images_ == 0) return 0;
  const auto rank = static_cast<std::size_t>(factor_.displayed_rank()),
             views = static_cast<std::size_t>(factor_.views());
  return sizeof(RingSnapshot) + shown_.size() +
         sizeof(float) * (3 * shown_.size() * rank + views * (4 + rank) + 2 * rank);
}

double RingModel::largest_bytes(double samples, const RingModelOptions& options) {
  const RingFactorOptions& factor = options.factor;
  const double rows = 3 * samples, views = options.max_views + factor.block;
  return sizeof(RingModel) + sizeof(std::uint16_t) * samples + views * ViewSet::bytes_for(1) +
         RingFactor::bytes_for(rows, factor.terms_kept(), factor.block, views,
                               factor.witnesses(static_cast<int>(rows)));
}

double RingModel::largest_snapshot_bytes(double samples, const RingModelOptions& options) {
  const double rank = options.factor.max_rank, views = options.max_views + options.factor.block;
  return sizeof(RingSnapshot) + samples + sizeof(float) * (3.0 * samples * rank + views * (4 + rank) + 2 * rank);
}

std::shared_ptr<const RingSnapshot> RingModel::snapshot(const Eigen::Matrix3f& frame, std::span<const int> resolution) {
  if (snapshot_ || images_ == 0) return snapshot_;
  if (factor_.pending() == 0) {
    snapshot_ = settled_snapshot(frame, resolution);
  } else {  // what is seen must not depend on when it is looked at: a copy is folded
    RingModel settled = *this;
    settled.fold_pending();
    snapshot_ = settled.settled_snapshot(frame, resolution);
  }
  return snapshot_;
}

std::shared_ptr<const RingSnapshot> RingModel::settled_snapshot(const Eigen::Matrix3f& frame,
                                                                std::span<const int> resolution) const {
  auto snapshot = std::make_shared<RingSnapshot>();
  snapshot->basis = factor_.displayed_basis();
  snapshot->directions = views_.direction_matrix();
  snapshot->reliability = views_.reliability();
  snapshot->frame = frame;
  snapshot->shown.resize(shown_.size());
  for (std::size_t s = 0; s < shown_.size(); ++s) snapshot->shown[s] = shown_share(shown_[s], images_);
  snapshot->set_interpolation(interpolation_.krige(views_, factor_.displayed_coefficients(), frame.row(2)),
                              interpolation_.chosen().kernel, interpolation_.reflection());
  if (options_.interpolation.method == ViewMethod::kDelaunay)
    snapshot->set_triangulation(factor_.displayed_coefficients());
  snapshot->residual = residual_;
  snapshot->best_cosine = best_cosine_;
  snapshot->views_folded = images_;
  fill_unseen_samples(*snapshot, resolution);
  return snapshot;
}

}  // namespace sheen
