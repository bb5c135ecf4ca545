// SPDX-License-Identifier: Apache-2.0
#include "reconstructor/splats/splat_placement.h"

#include <tbb/blocked_range.h>
#include <tbb/parallel_for.h>

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>
#include <numeric>

#include "common/image/color.h"

namespace sheen {
namespace {

using Eigen::Matrix3f;
using Eigen::Vector3f;
using Vector6f = Eigen::Matrix<float, 6, 1>;

constexpr std::size_t kSamplesPerSplat = 24;
constexpr int kRounds = 8;                          ///< in which pieces grow even
constexpr float kPlain = 0.5f;                      ///< of the mean detail: what is wanted for none
constexpr float kNormalLength = 1.0f;               ///< of unit normals, in pieces' widths: pieces end at sharp edges
constexpr float kWider = 1.9f;                      ///< than a piece is its Gaussian
constexpr float kNarrowest = 0.05f;                 ///< of a mean piece's width
constexpr float kRoundest = 0.4f;                   ///< least ratio of the two widths
constexpr float kThinnest = 0.002f, kFlat = 0.02f;  ///< ratio of thickness to width
constexpr float kOpacity = 0.95f;

/// Of the surface.
struct Sample {
  std::uint32_t triangle;
  float u, v;
  Vector6f place;     ///< and normal, as long as pieces need it
  float density = 1;  ///< of splats that is wanted here
};

/// Spread evenly by `weight` (per triangle and unit of area), `count` in all.
std::vector<Sample> samples_of(const Mesh& mesh, const std::vector<float>& weight, std::size_t count,
                               float normal_length) {
  double total = 0;
  for (std::size_t t = 0; t < weight.size(); ++t) total += mesh.area_normal(t).norm() * weight[t];
  std::vector<Sample> samples;
  samples.reserve(count);
  const std::vector<Vector3f> normals = vertex_normals(mesh);
  double reached = 0;
  for (std::uint32_t t = 0; t < weight.size(); ++t) {
    const Vector3f normal = mesh.area_normal(t);
    reached += normal.norm() * weight[t];
    while (samples.size() < count &&
           (static_cast<double>(samples.size()) + 0.5) * total < reached * static_cast<double>(count)) {
      // The plastic number's sequence fills a square evenly; its half beyond the diagonal is turned back.
      const double i = static_cast<double>(samples.size());
      float u = static_cast<float>(std::fmod(0.5 + i * 0.7548776662466927, 1.0));
      float v = static_cast<float>(std::fmod(0.5 + i * 0.5698402909980532, 1.0));
      if (u + v > 1) {
        u = 1 - u;
        v = 1 - v;
      }
      Sample sample{t, u, v, {}, weight[t]};
      sample.place << (1 - u - v) * mesh.corner(t, 0) + u * mesh.corner(t, 1) + v * mesh.corner(t, 2),
          normal_length * normal.normalized();
      samples.push_back(sample);
    }
  }
  return samples;
}

/// Finds the nearest of some points.
class NearestPoint {
 public:
  explicit NearestPoint(const std::vector<Vector6f>& points) : points_(points), order_(points.size()) {
    std::iota(order_.begin(), order_.end(), 0u);
    axes_.resize(points.size());
    split(0, order_.size());
  }
  std::uint32_t to(const Vector6f& place) const {
    Best best;
    search(place, 0, order_.size(), best);
    return best.point;
  }

 private:
  struct Best {
    float square = std::numeric_limits<float>::infinity();
    std::uint32_t point = 0;
  };
  static constexpr std::size_t kLeaf = 6;

  /// The middle one of a range divides it, along its widest axis.
  void split(std::size_t begin, std::size_t end) {
    if (end - begin <= kLeaf) return;
    Vector6f low = points_[order_[begin]], high = low;
    for (std::size_t i = begin; i < end; ++i) {
      low = low.cwiseMin(points_[order_[i]]);
      high = high.cwiseMax(points_[order_[i]]);
    }
    int axis = 0;
    (high - low).maxCoeff(&axis);
    const std::size_t middle = (begin + end) / 2;
    std::nth_element(order_.begin() + std::ptrdiff_t(begin), order_.begin() + std::ptrdiff_t(middle),
                     order_.begin() + std::ptrdiff_t(end),
                     [&](std::uint32_t a, std::uint32_t b) { return points_[a][axis] < points_[b][axis]; });
    axes_[middle] = axis;
    split(begin, middle);
    split(middle + 1, end);
  }
  void look_at(const Vector6f& place, std::size_t i, Best& best) const {
    const float square = (points_[order_[i]] - place).squaredNorm();
    if (square < best.square) best = {square, order_[i]};
  }
  void search(const Vector6f& place, std::size_t begin, std::size_t end, Best& best) const {
    if (end - begin <= kLeaf) {
      for (std::size_t i = begin; i < end; ++i) look_at(place, i, best);
      return;
    }
    const std::size_t middle = (begin + end) / 2;
    const int axis = axes_[middle];
    const float beyond = place[axis] - points_[order_[middle]][axis];
    look_at(place, middle, best);
    const auto below = [&] { search(place, begin, middle, best); };
    const auto above = [&] { search(place, middle + 1, end, best); };
    beyond < 0 ? below() : above();
    if (beyond * beyond < best.square) beyond < 0 ? above() : below();
  }

  const std::vector<Vector6f>& points_;
  std::vector<std::uint32_t> order_;
  std::vector<int> axes_;
};

/// Of each sample the piece that it is in.
std::vector<std::uint32_t> pieces_of(const std::vector<Sample>& samples, const std::vector<Vector6f>& middles) {
  const NearestPoint nearest(middles);
  std::vector<std::uint32_t> piece(samples.size());
  tbb::parallel_for(std::size_t{0}, samples.size(), [&](std::size_t i) { piece[i] = nearest.to(samples[i].place); });
  return piece;
}

/// Middles of pieces as even as the samples' density lets them be.
std::vector<Vector6f> even_middles(const std::vector<Sample>& samples, std::size_t count) {
  std::vector<Vector6f> middles(count);
  for (std::size_t i = 0; i < count; ++i) middles[i] = samples[(2 * i + 1) * samples.size() / (2 * count)].place;
  for (int round = 0; round < kRounds; ++round) {
    const std::vector<std::uint32_t> piece = pieces_of(samples, middles);
    std::vector<Vector6f> sums(count, Vector6f::Zero());
    std::vector<float> weights(count, 0);
    for (std::size_t i = 0; i < samples.size(); ++i) {
      sums[piece[i]] += samples[i].density * samples[i].place;
      weights[piece[i]] += samples[i].density;
    }
    for (std::size_t i = 0; i < count; ++i)
      if (weights[i] > 0) middles[i] = sums[i] / weights[i];
  }
  return middles;
}

Vector3f encoded_look(const ViewShader& look, const Sample& sample) {
  return look.shade(sample.triangle, sample.u, sample.v).rgb.unaryExpr([](float value) {
    return srgb_encode(std::clamp(value, 0.0f, 1.0f));
  });
}

/// Mean square by which the look differs within a piece, per piece.
std::vector<float> detail_of(const std::vector<Sample>& samples, const std::vector<std::uint32_t>& piece,
                             std::size_t count, const ViewShader& look) {
  std::vector<Vector3f> sum(count, Vector3f::Zero());
  std::vector<float> squares(count, 0), number(count, 0);
  for (std::size_t i = 0; i < samples.size(); ++i) {
    const Vector3f colour = encoded_look(look, samples[i]);
    sum[piece[i]] += colour;
    squares[piece[i]] += colour.squaredNorm();
    number[piece[i]] += 1;
  }
  std::vector<float> detail(count, 0);
  for (std::size_t i = 0; i < count; ++i)
    if (number[i] > 0) detail[i] = std::max(0.0f, squares[i] / number[i] - (sum[i] / number[i]).squaredNorm());
  return detail;
}

/// Density of splats that is wanted of each triangle: by how much the look differs there within pieces of one size.
std::vector<float> wanted_density(const Mesh& mesh, const ViewShader& look, std::size_t count, float normal_length) {
  const std::size_t triangles = mesh.triangles.size();
  const std::vector<Sample> samples =
      samples_of(mesh, std::vector<float>(triangles, 1), kSamplesPerSplat * count, normal_length);
  const std::vector<Vector6f> middles = even_middles(samples, count);
  const std::vector<std::uint32_t> piece = pieces_of(samples, middles);
  const std::vector<float> detail = detail_of(samples, piece, count, look);
  double sum = 0;
  for (const float square : detail) sum += std::sqrt(square);
  const float plain = kPlain * static_cast<float>(sum / static_cast<double>(count));
  std::vector<float> density(triangles, 0), number(triangles, 0);
  for (std::size_t i = 0; i < samples.size(); ++i) {
    density[samples[i].triangle] += plain + std::sqrt(detail[piece[i]]);
    number[samples[i].triangle] += 1;
  }
  const float usual = plain + static_cast<float>(sum / static_cast<double>(count));
  for (std::size_t t = 0; t < triangles; ++t)
    density[t] = number[t] > 0 && usual > 0 ? density[t] / number[t] / usual : 1;
  return density;
}

SplatShape shape_of(const Vector3f& mean, const Matrix3f& covariance, float least) {
  const Eigen::SelfAdjointEigenSolver<Matrix3f> axes(covariance);
  Matrix3f turn = axes.eigenvectors();
  if (turn.determinant() < 0) turn.col(0) *= -1;
  Vector3f deviation = kWider * axes.eigenvalues().cwiseMax(0.0f).cwiseSqrt();
  deviation[2] = std::max(deviation[2], least);
  deviation[1] = std::max(deviation[1], kRoundest * deviation[2]);
  deviation[0] = std::clamp(deviation[0], kThinnest * deviation[1], kFlat * deviation[1]);
  return {mean, Eigen::Quaternionf(turn).normalized(), deviation, kOpacity};
}

/// Of a part of a surface.
struct Moments {
  float area = 0;
  Vector3f place = Vector3f::Zero(), colour = Vector3f::Zero();  ///< means
  Matrix3f covariance = Matrix3f::Zero();                        ///< of places
};

std::vector<Moments> moments_of(const std::vector<Sample>& samples, const std::vector<std::uint32_t>& piece,
                                std::size_t count, const ViewShader& look) {
  std::vector<Moments> moments(count);
  for (std::size_t i = 0; i < samples.size(); ++i) {
    Moments& of = moments[piece[i]];
    const float area = 1 / samples[i].density;
    of.area += area;
    of.place += area * samples[i].place.head<3>();
    of.colour += area * encoded_look(look, samples[i]);
  }
  for (Moments& of : moments) {
    if (of.area == 0) continue;
    of.place /= of.area;
    of.colour /= of.area;
  }
  for (std::size_t i = 0; i < samples.size(); ++i) {
    Moments& of = moments[piece[i]];
    const Vector3f off = samples[i].place.head<3>() - of.place;
    of.covariance += off * off.transpose() / (samples[i].density * of.area);
  }
  return moments;
}

}  // namespace

float mean_width(const Mesh& mesh, std::size_t count) {
  double area = 0;
  for (std::size_t t = 0; t < mesh.triangles.size(); ++t) area += mesh.area_normal(t).norm() / 2;
  return static_cast<float>(std::sqrt(area / static_cast<double>(count)));
}

Splats place_splats(const Mesh& mesh, const ViewShader& look, std::size_t count, int degree) {
  const float width = mean_width(mesh, count);
  const float normal_length = kNormalLength * width;
  const std::vector<Sample> samples =
      samples_of(mesh, wanted_density(mesh, look, count, normal_length), kSamplesPerSplat * count, normal_length);
  std::vector<Moments> moments = moments_of(samples, pieces_of(samples, even_middles(samples, count)), count, look);
  std::erase_if(moments, [](const Moments& of) { return of.area == 0; });

  Splats splats{.degree = degree, .shapes = {}, .colours = {}};
  const float constant = splat_harmonics(Vector3f::UnitZ(), 1)[0];
  splats.colours = Eigen::MatrixXf::Zero(3 * splats.terms(), Eigen::Index(moments.size()));
  for (std::size_t i = 0; i < moments.size(); ++i) {
    splats.shapes.push_back(shape_of(moments[i].place, moments[i].covariance, kNarrowest * width));
    for (int c = 0; c < 3; ++c) splats.channel(i, c)[0] = (moments[i].colour[c] - 0.5f) / constant;
  }
  return splats;
}

}  // namespace sheen
