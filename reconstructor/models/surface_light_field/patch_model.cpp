// SPDX-License-Identifier: Apache-2.0
#include "reconstructor/models/surface_light_field/patch_model.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

#include "reconstructor/numerics/shipped_factor.h"

namespace sheen {
namespace {

// Runs of neighbouring samples share cache lines: an eighth of the samples is an eighth of the memory.
constexpr std::size_t kTestedRun = 16, kTestedEvery = 128;
// A repetition differs by its own noise and by that of the view it repeats, of which a basis has averaged a part.
constexpr double kRepeatedNoise = 1.5, kRepeatedColumn = 2;
constexpr int kFirstMapChoice = 4;    // images; with fewer, all that differs is displayed
constexpr int kFineChromaImages = 3;  // may ask for chroma as fine as luma; then what is displayed decides
constexpr int kDifferently = 2;       // samples that so many times fewer images show are imputed, and say so
constexpr std::size_t kPackedValue = sizeof(std::int16_t), kPackedScale = sizeof(double);  // as PackedColumns has them

/// Of a vertex in it: directions, reliabilities and drift of its views; weights, mean and drift.
template <typename Count>
Count vertex_bytes(Count views, Count rank) {
  return sizeof(VertexInterpolant) + sizeof(VertexViews) + 5 * sizeof(float) * views +
         rank * (kPackedScale + kPackedValue * views + 2 * sizeof(float));
}

/// Rows of a plane lie side by side.
OnlineSvdOptions plane_factor_options(const OnlineSvdOptions& options) {
  OnlineSvdOptions of_planes = patch_factor_options(options);
  of_planes.channels = 1;
  return of_planes;
}

std::shared_ptr<const ColourPlanes> first_planes(const MapSides& sides, bool coarse_chroma) {
  return std::make_shared<const ColourPlanes>(sides, coarse_chroma ? half_sides(sides) : sides);
}

}  // namespace

PatchModelOptions PatchModelOptions::limited_to(const PatchLimit& limit) const {
  PatchModelOptions limited = *this;
  limited.factor = factor.limited_to(limit.max_rank, limit.internal_rank, limit.block);
  limited.max_views = std::min(max_views, limit.max_views);
  return limited;
}

OnlineSvdOptions patch_factor_options(OnlineSvdOptions options) {
  return shipped_factor(options);
}

double image_weight(const OnlineSvdOptions& options, double fraction_shown) {
  return options.imputation == Imputation::kLeastSquares ? 1 : fraction_shown * fraction_shown;
}

PatchModel::PatchModel(const MapSides& sides, std::size_t vertices, const SurfaceSite& centre,
                       const PatchModelOptions& options, unsigned phase)
    : options_(options),
      centre_(centre),
      planes_(first_planes(sides, options.coarse_chroma)),
      factor_(planes_->row_planes(), plane_factor_options(options.factor), phase),
      views_(centre.place, vertices),
      schedule_(phase),
      shown_(static_cast<std::size_t>(planes_->samples()), 0),
      fine_chroma_until_(kFineChromaImages) {}

/// The paper's imputation takes images that show part of a patch only with half of it visible, and when the basis rests
/// on some that show all (000 sec. 3.2: after 8 to 10).
bool PatchModel::shows_enough(std::size_t shown, std::size_t samples) const {
  constexpr int kFirstWhole = 9;
  const bool gated = options_.factor.imputation == Imputation::kLeastSquares && shown < samples;
  if (gated && (images_ < kFirstWhole || 2 * shown < samples)) return false;
  return shown > 0 && static_cast<double>(shown) >= options_.min_visible * static_cast<double>(samples);
}

PatchModel::Absorbed PatchModel::absorb(const Eigen::VectorXf& column, std::span<const std::uint8_t> visible,
                                        const Eigen::Vector3f& eye, std::span<const float> reliability) {
  Absorbed result;
  const auto shown = static_cast<std::size_t>(std::count(visible.begin(), visible.end(), 1));
  if (!shows_enough(shown, visible.size())) return result;
  result.used = true;
  if (images_ < fine_chroma_until_) keep_fine_chroma(column, visible);
  const float fraction = static_cast<float>(shown) / static_cast<float>(visible.size());
  const OnlineSvd::Reports folded = factor_.add(planes_->rows_of(column, visible), known_rows(visible, shown),
                                                image_weight(options_.factor, fraction));
  for (std::size_t s = 0; s < visible.size(); ++s)
    shown_[s] += (visible[s] != 0) & (shown_[s] < std::numeric_limits<std::uint16_t>::max());
  views_.add(eye, reliability);
  ++images_;
  maps_due_ = maps_due_ || images_ == kFirstMapChoice;
  follow(folded, result);
  snapshot_.reset();
  result.wants_interpolation = can_choose_interpolation() && schedule_.due(images_);
  return result;
}

void PatchModel::fold_pending() {
  Absorbed unused;
  follow(factor_.fold(), unused);
}

void PatchModel::withdraw(const Eigen::VectorXf& column, std::span<const std::uint8_t> visible,
                          const Eigen::Vector3f& eye) {
  const auto shown = static_cast<std::size_t>(std::count(visible.begin(), visible.end(), 1));
  if (images_ == 0 || !shows_enough(shown, visible.size())) return;
  const int view = views_.view_from(eye), folded = factor_.folded_views();
  if (view < folded) {
    const float fraction = static_cast<float>(shown) / static_cast<float>(visible.size());
    const double weight = factor_.weight_of(view), taken = image_weight(options_.factor, fraction);
    factor_.take_from(view, planes_->rows_of(column, visible), known_rows(visible, shown), taken);
    if (factor_.folded_views() < folded)
      views_.remove(view);
    else  // it was merged: the view moves back to where the others are
      views_.take_from(view, static_cast<float>(weight), eye, static_cast<float>(taken));
  } else {
    factor_.remove(view);
    views_.remove(view);
  }
  for (std::size_t s = 0; s < visible.size(); ++s)
    if (visible[s] && shown_[s] > 0) --shown_[s];
  --images_;
  snapshot_.reset();
}

float PatchModel::nearest_cosine(const Eigen::Vector3f& eye) const {
  return views_.nearest(eye).cosine;
}

bool PatchModel::may_repeat(const Eigen::Vector3f& eye) const {
  return options_.repeat_angle > 0 && nearest_cosine(eye) >= std::cos(static_cast<float>(options_.repeat_angle));
}

bool PatchModel::repeats(const Eigen::VectorXf& column, std::span<const std::uint8_t> visible,
                         const Eigen::Vector3f& eye) const {
  if (!may_repeat(eye)) return false;
  const int view = views_.nearest(eye).view;
  const int waiting = view - factor_.folded_views();  // < 0: folded
  const auto kept = [&](Eigen::Index row) {
    return waiting < 0 ? factor_.explained(view, static_cast<int>(row))
                       : factor_.pending_value(waiting, static_cast<int>(row));
  };
  const Eigen::VectorXf values = planes_->rows_of(column, visible);
  const std::vector<std::uint8_t> known = planes_->known_places(visible);
  double unexplained = 0;
  int rows = 0;
  const auto compare = [&](std::size_t at) {
    const auto row = static_cast<Eigen::Index>(at);
    unexplained += (values[row] - kept(row)) * (values[row] - kept(row));
    ++rows;
  };
  const std::size_t samples = visible.size(), chroma_samples = known.size() - samples;
  for (const auto& [first, behind] : {std::pair(std::size_t{0}, samples), std::pair(samples, known.size())})
    for (std::size_t run = first; run < behind; run += kTestedEvery)
      for (std::size_t place = run; place < std::min(run + kTestedRun, behind); ++place) {
        if (!known[place]) continue;
        if (place < samples && shown_[place] == 0) return false;
        compare(place);
        if (place >= samples) compare(place + chroma_samples);
      }
  return rows > 0 && unexplained <= (waiting < 0 ? kRepeatedNoise : kRepeatedColumn) * factor_.row_noise() * rows;
}

void PatchModel::follow(const OnlineSvd::Reports& reports, Absorbed& result) {
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
void PatchModel::thin_views() {
  views_.set_folded(factor_.folded_views());
  while (factor_.folded_views() > options_.max_views) {
    const auto [kept, removed] = views_.closest_pair();
    views_.merge(kept, removed, static_cast<float>(factor_.weight_of(kept)),
                 static_cast<float>(factor_.weight_of(removed)));
    factor_.merge_views(kept, removed);
  }
}

MapSides PatchModel::sufficient_sides(double detail, double error, const SharedInterpolation& interpolation) {
  maps_due_ = false;
  const MapSides sides = planes_->sides(), chroma_sides = planes_->chroma_sides();
  const auto [least, most] = std::minmax_element(shown_.begin(), shown_.end());
  if (rank() == 0 || *least == 0 || kDifferently * *least < *most) return sides;
  const SmoothedViews displayed =
      smoothed(views_.seen_from_centre(), known_coefficients(), interpolation, centre_.normal);
  const double own_error = std::sqrt(displayed.squared_error / (3.0 * planes_->samples()));
  const auto missed = static_cast<float>(detail * std::min(error, own_error));
  const Eigen::MatrixXf basis = factor_.displayed_basis();
  if (options_.coarse_chroma) {
    const MapSides enough =
        sheen::sufficient_sides(chroma_sides, planes_->chroma_of(basis), displayed.coefficients, missed);
    if (enough != chroma_sides) use(std::make_shared<const ColourPlanes>(sides, enough));
  }
  return sheen::sufficient_sides(sides, basis.topRows(planes_->samples()), displayed.coefficients, missed);
}

/// Chroma keeps its sides, but is no finer than luma. In triangles that become finer so does chroma, and the next
/// images may ask for all of it.
void PatchModel::resample(const MapSides& to) {
  const MapSides from = planes_->sides();
  MapSides chroma = planes_->chroma_sides();
  for (std::size_t i = 0; i < to.size(); ++i) {
    if (to[i] > from[i]) {
      fine_chroma_until_ = images_ + kFineChromaImages;
      chroma[i] = chroma[i] == from[i] ? to[i] : std::max(chroma[i], static_cast<std::uint8_t>(half_side(to[i])));
    }
    chroma[i] = std::min(chroma[i], to[i]);
  }
  use(std::make_shared<const ColourPlanes>(to, chroma));
}

void PatchModel::use(std::shared_ptr<const ColourPlanes> planes) {
  fold_pending();
  const RowResampling by = resampled_planes(*planes_, *planes);
  factor_.resample(by);
  std::vector<std::uint16_t> shown(static_cast<std::size_t>(planes->samples()));
  for (std::size_t s = 0; s < shown.size(); ++s) {
    const auto& [a, b, c] = by.between[s];
    shown[s] = std::min({shown_[a], shown_[b], shown_[c]});
  }
  shown_ = std::move(shown);
  planes_ = std::move(planes);
  snapshot_.reset();
}

/// For each row of a column; empty when all are known. Guesses of chroma count where nothing better has come.
std::vector<std::uint8_t> PatchModel::known_rows(std::span<const std::uint8_t> visible, std::size_t shown) const {
  if (shown == visible.size()) return {};
  std::vector<std::uint8_t> known = planes_->known_places(visible);
  const std::vector<std::uint8_t> guessed = planes_->guessed_places(visible);
  for (std::size_t place = visible.size(); place < known.size(); ++place)
    if (guessed[place] && !factor_.seen(static_cast<int>(place))) known[place] = 1;
  return planes_->known_rows(std::move(known));
}

void PatchModel::keep_fine_chroma(const Eigen::VectorXf& column, std::span<const std::uint8_t> visible) {
  const MapSides chroma = planes_->sides_for_chroma_of(column, visible, std::sqrt(static_cast<float>(kCameraVariance)));
  if (chroma != planes_->chroma_sides()) use(std::make_shared<const ColourPlanes>(planes_->sides(), chroma));
}

void PatchModel::limit(const PatchLimit& limit) {
  options_ = options_.limited_to(limit);
  Absorbed unused;
  follow(factor_.limit(limit.max_rank, limit.internal_rank, limit.block), unused);
  thin_views();
  snapshot_.reset();
}

PatchModel::Prediction PatchModel::predict(const Eigen::VectorXf& column, std::span<const std::uint8_t> visible,
                                           const Eigen::Vector3f& eye, const SharedInterpolation& interpolation) const {
  Prediction predicted;
  if (rank() == 0) return predicted;
  const Eigen::VectorXf h = interpolated(views_.seen_from_centre(), with_pending(factor_.displayed_coefficients()),
                                         interpolation, centre_.normal, (eye - centre_.place).normalized());
  const Eigen::MatrixXf displayed = factor_.displayed_basis();
  const Eigen::VectorXf missed = planes_->rows_of(column, visible) - displayed * h;
  const std::vector<std::uint8_t> known = planes_->known_places(visible);
  const int samples = planes_->samples(), chroma = planes_->chroma_samples();
  for (int s = 0; s < samples; ++s) {
    if (!known[s] || displayed.row(s).isZero(0)) continue;
    predicted.squared_error += missed[s] * missed[s];
    predicted.values += 3;
  }
  for (int row = samples; row < samples + chroma; ++row) {
    const int other = row + chroma;
    if (!known[row] || (displayed.row(row).isZero(0) && displayed.row(other).isZero(0))) continue;
    predicted.squared_error += missed[row] * missed[row] + missed[other] * missed[other];
  }
  return predicted;
}

bool PatchModel::can_choose_interpolation() const {
  return views() >= ChoiceSchedule::kFirstChoice;
}

/// Those of the folded views, and of the pending ones: rank x views.
Eigen::MatrixXf PatchModel::with_pending(const Eigen::Ref<const Eigen::MatrixXf>& folded) const {
  Eigen::MatrixXf coefficients(rank(), views());
  coefficients << folded, factor_.pending_coefficients().topRows(rank());
  return coefficients;
}

/// Of all views. To tell how the patch varies, those that are at hand do: the ones that a picture is made of
/// (`displayed_coefficients`) differ for views that hide rows alone, and cost as much again as all the comparing.
Eigen::MatrixXf PatchModel::known_coefficients() const {
  return with_pending(factor_.coefficients().topRows(rank()));
}

InterpolationErrors PatchModel::interpolation_errors(const ReflectionDrift* reflection) const {
  return sheen::interpolation_errors(views_.seen_from_centre(), known_coefficients(), reflection, centre_.normal);
}

/// Of the displayed basis: 3 x rank.
Eigen::MatrixXf PatchModel::mean_shown_colours() const {
  std::vector<std::uint8_t> seen;
  seen.reserve(shown_.size());
  for (const std::uint16_t images : shown_) seen.push_back(images > 0);
  return planes_->mean_colours(factor_.displayed_basis(), planes_->guessed_places(seen));
}

PatchLevels PatchModel::levels() const {
  return patch_levels(views_.seen_from_centre(), mean_shown_colours(), known_coefficients(), centre_.normal);
}

std::size_t PatchModel::bytes() const {
  return sizeof(*this) + planes_->bytes() + factor_.bytes() + shown_.size() * sizeof(shown_[0]) + views_.bytes();
}

std::size_t PatchModel::snapshot_bytes(std::size_t vertices) const {
  if (images_ == 0) return 0;
  const auto rank = static_cast<std::size_t>(factor_.displayed_rank()),
             views = static_cast<std::size_t>(factor_.views());
  return sizeof(PatchSnapshot) + shown_.size() + factor_.displayed_bytes() + vertices * vertex_bytes(views, rank);
}

double PatchModel::largest_bytes(const Counts& counts, const PatchModelOptions& options) {
  const OnlineSvdOptions& factor = options.factor;
  const double views = options.max_views + factor.block;
  return sizeof(PatchModel) + sizeof(ColourPlanes) + counts.vertices * sizeof(ColourPlanes::Triangle) +
         sizeof(std::uint16_t) * counts.samples +
         views * static_cast<double>(ViewSet::bytes_for(1, static_cast<std::size_t>(counts.vertices))) +
         OnlineSvd::bytes_for(counts.rows(), factor.terms_kept(), factor.block, views,
                              factor.witnesses(static_cast<int>(counts.rows())), kCameraVariance > 0);
}

double PatchModel::largest_snapshot_bytes(const Counts& counts, const PatchModelOptions& options) {
  const double rank = options.factor.max_rank, views = options.max_views + options.factor.block;
  return sizeof(PatchSnapshot) + counts.samples + rank * (kPackedScale + kPackedValue * counts.rows()) +
         counts.vertices * vertex_bytes(views, rank);
}

std::optional<FactorizedPatch> PatchModel::factorized() const {
  if (images_ == 0) return std::nullopt;
  if (factor_.pending() == 0) return settled();
  PatchModel folded = *this;  // what is seen must not depend on when it is looked at
  folded.fold_pending();
  return folded.settled();
}

FactorizedPatch PatchModel::settled() const {
  FactorizedPatch patch{.basis = factor_.packed_displayed_basis(),
                        .planes = planes_,
                        .coefficients = factor_.displayed_coefficients(),
                        .shown = {},
                        .residual = residual_,
                        .images = images_,
                        .views = views_};
  patch.shown.reserve(shown_.size());
  for (const std::uint16_t images : shown_) patch.shown.push_back(shown_fraction(images, images_));
  return patch;
}

}  // namespace sheen
