// SPDX-License-Identifier: Apache-2.0
#include "reconstructor/splats/colour_fit.h"

#include <tbb/parallel_for.h>

#include <utility>

namespace sheen {
namespace {

using Eigen::Index;
using Eigen::Matrix3Xf;
using Eigen::MatrixXf;
using Eigen::Vector3f;
using Eigen::VectorXf;

constexpr float kDegreeWeight = 0.05f;  ///< pixels that say a splat looks the same from everywhere, per squared degree
constexpr float kPlaceWeight = 0.1f;    ///< pixels that say it is right already
constexpr std::size_t kGroups = 8;      ///< of views, whose sums are made at once

/// Of each pixel what these colours make of it.
Matrix3Xf shown(const SplatView& view, const MatrixXf& colours) {
  const Index terms = view.harmonics.rows();
  Matrix3Xf seen(3, Index(view.splats.size()));
  for (Index i = 0; i < seen.cols(); ++i)
    for (int c = 0; c < 3; ++c)
      seen(c, i) = colours.col(view.splats[std::size_t(i)]).segment(c * terms, terms).dot(view.harmonics.col(i));
  Matrix3Xf pixels = Matrix3Xf::Zero(3, view.wanted.cols());
  for (Index i = 0; i < pixels.cols(); ++i)
    for (const SplatShares::Share& share : view.shares.of(std::size_t(i)))
      pixels.col(i) += share.weight * seen.col(share.splat);
  return pixels;
}

/// The transpose of this, added.
void add_to_colours(const SplatView& view, const Matrix3Xf& pixels, MatrixXf& colours) {
  const Index terms = view.harmonics.rows();
  Matrix3Xf seen = Matrix3Xf::Zero(3, Index(view.splats.size()));
  for (Index i = 0; i < pixels.cols(); ++i)
    for (const SplatShares::Share& share : view.shares.of(std::size_t(i)))
      seen.col(share.splat) += share.weight * pixels.col(i);
  for (Index i = 0; i < seen.cols(); ++i)
    for (int c = 0; c < 3; ++c)
      colours.col(view.splats[std::size_t(i)]).segment(c * terms, terms) +=
          view.weight * seen(c, i) * view.harmonics.col(i);
}

double dot(const MatrixXf& a, const MatrixXf& b) {
  return a.cwiseProduct(b).cast<double>().sum();
}

}  // namespace

SplatView splat_view(const std::vector<SplatShape>& shapes, int terms, const PosedCamera& from, const ImageF& encoded,
                     const ImageU8& pixels) {
  SplatView view;
  view.shares = splat_shares(shapes, from, pixels);
  std::vector<std::uint32_t> place(shapes.size(), 0);  // in `splats`, counted from 1
  for (SplatShares::Share& share : view.shares.shares) {
    std::uint32_t& at = place[share.splat];
    if (at == 0) {
      view.splats.push_back(share.splat);
      at = static_cast<std::uint32_t>(view.splats.size());
    }
    share.splat = at - 1;
  }
  const Vector3f eye = camera_centre(from.camera_from_object).cast<float>();
  view.harmonics.resize(terms, Index(view.splats.size()));
  for (Index i = 0; i < view.harmonics.cols(); ++i)
    view.harmonics.col(i) = splat_harmonics((shapes[view.splats[std::size_t(i)]].centre - eye).normalized(), terms);
  view.wanted.resize(3, Index(view.shares.pixels.size()));
  for (Index i = 0; i < view.wanted.cols(); ++i) {
    float covered = 0;
    for (const SplatShares::Share& share : view.shares.of(std::size_t(i))) covered += share.weight;
    const Eigen::Map<const Vector3f> rgb(encoded.data() + 3 * std::size_t(view.shares.pixels[std::size_t(i)]));
    view.wanted.col(i) = covered * (rgb.array() - 0.5f);
  }
  return view;
}

ColourFit::ColourFit(std::vector<SplatView> views, std::size_t splats, int terms)
    : views_(std::move(views)), terms_(terms), held_(3 * terms), blocks_(splats) {
  for (int l = 0; l * l < terms; ++l)
    for (int term = l * l; term < (l + 1) * (l + 1); ++term)
      for (int c = 0; c < 3; ++c) held_[c * terms + term] = kPlaceWeight + kDegreeWeight * static_cast<float>(l * l);
  std::vector<MatrixXf> squares(splats, MatrixXf(held_.head(terms).asDiagonal()));
  for (const SplatView& view : views_) {
    VectorXf weights = VectorXf::Zero(Index(view.splats.size()));
    for (const SplatShares::Share& share : view.shares.shares)
      weights[share.splat] += view.weight * share.weight * share.weight;
    tbb::parallel_for(Index{0}, weights.size(), [&](Index i) {
      squares[view.splats[std::size_t(i)]].selfadjointView<Eigen::Lower>().rankUpdate(view.harmonics.col(i),
                                                                                      weights[i]);
    });
  }
  tbb::parallel_for(std::size_t{0}, splats, [&](std::size_t i) { blocks_[i].compute(squares[i]); });
}

void ColourFit::improve(MatrixXf& colours, const std::function<void()>& round_done) const {
  MatrixXf residual = sum_over_views(colours, [&](const SplatView& view, MatrixXf& sum) {
    add_to_colours(view, view.wanted - shown(view, colours), sum);
  });
  MatrixXf better = solved_alone(residual), direction = better;
  double slope = dot(residual, better);
  for (int round = 0; round < kRounds && slope > 0; ++round) {
    MatrixXf curved = sum_over_views(
        direction, [&](const SplatView& view, MatrixXf& sum) { add_to_colours(view, shown(view, direction), sum); });
    curved += held_.asDiagonal() * direction;
    const auto step = static_cast<float>(slope / dot(direction, curved));
    colours += step * direction;
    residual -= step * curved;
    better = solved_alone(residual);
    const double before = std::exchange(slope, dot(residual, better));
    direction = better + static_cast<float>(slope / before) * direction;
    round_done();
  }
}

template <typename Add>
MatrixXf ColourFit::sum_over_views(const MatrixXf& like, const Add& add) const {
  std::vector<MatrixXf> sums(kGroups, MatrixXf::Zero(like.rows(), like.cols()));
  tbb::parallel_for(std::size_t{0}, kGroups, [&](std::size_t group) {
    for (std::size_t i = group; i < views_.size(); i += kGroups) add(views_[i], sums[group]);
  });
  for (std::size_t group = 1; group < kGroups; ++group) sums[0] += sums[group];
  return std::move(sums[0]);
}

MatrixXf ColourFit::solved_alone(MatrixXf residual) const {
  tbb::parallel_for(std::size_t{0}, blocks_.size(), [&](std::size_t i) {
    for (int c = 0; c < 3; ++c) {
      auto part = residual.col(Index(i)).segment(c * terms_, terms_);
      part = blocks_[i].solve(part).eval();
    }
  });
  return residual;
}

}  // namespace sheen
