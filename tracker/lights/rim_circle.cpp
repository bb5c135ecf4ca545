// SPDX-License-Identifier: Apache-2.0
#include "tracker/lights/rim_circle.h"

#include <Eigen/Cholesky>
#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <random>

#include "common/base/order_statistics.h"

namespace sheen {
namespace {

constexpr int kHypotheses = 8000;
constexpr double kNearlyAsGood = 0.7;  // of the best circle
constexpr std::size_t kCirclesFitted = 8;
constexpr double kSupportBesideBest = 0.85;
constexpr double kLeastSigma_px = 0.05;  // of an edge
constexpr double kMirrored_px = 0.15;    // what a ball mirrors along its outline moves all of its edges
constexpr std::size_t kBlocks = 24;

Eigen::Vector2d way(double angle) {
  return {std::cos(angle), std::sin(angle)};
}

std::optional<BallCircle> circle_through(const Eigen::Vector2d& a, const Eigen::Vector2d& b, const Eigen::Vector2d& c) {
  Eigen::Matrix2d sides;
  sides << (b - a).transpose(), (c - a).transpose();
  if (!(std::abs(sides.determinant()) > 1e-6)) return std::nullopt;
  const Eigen::Vector2d halves((b - a).squaredNorm() / 2, (c - a).squaredNorm() / 2);
  const Eigen::Vector2d from_a = sides.inverse() * halves;
  return BallCircle{a + from_a, from_a.norm()};
}

/// For each ray the edge that is nearest to a circle; no edge: none within `tolerance`.
std::vector<const RimPoint*> nearest_edges(const std::vector<RimPoint>& edges, std::size_t rays,
                                           const BallCircle& circle, double tolerance) {
  std::vector<const RimPoint*> nearest(rays, nullptr);
  std::vector<double> distance(rays, tolerance);
  for (const RimPoint& edge : edges) {
    const double off = std::abs((edge.at - circle.centre).norm() - circle.radius);
    if (off > distance[edge.ray]) continue;
    distance[edge.ray] = off;
    nearest[edge.ray] = &edge;
  }
  std::erase(nearest, nullptr);
  return nearest;
}

double tolerance_of(double radius) {
  return std::max(1.0, 0.012 * radius);
}

std::size_t visible_rays(const BallCircle& circle, std::size_t rays, const Shown& shown) {
  std::size_t visible = 0;
  for (std::size_t ray = 0; ray < rays; ++ray)
    visible +=
        shown(circle.centre + circle.radius * way(2 * M_PI * static_cast<double>(ray) / static_cast<double>(rays)));
  return std::max<std::size_t>(visible, 1);
}

/// Circles through three edges that agree with many others, the best first.
std::vector<BallCircle> consensus(const std::vector<RimPoint>& edges, std::size_t rays, const BallCircle& about,
                                  const Shown& shown) {
  if (edges.size() < 12) return {};
  struct Hypothesis {
    BallCircle circle;
    double agreed;
  };
  std::vector<Hypothesis> all;
  double most = 0;
  std::mt19937 random(5);
  std::uniform_int_distribution<std::size_t> any(0, edges.size() - 1);
  for (int i = 0; i < kHypotheses; ++i) {
    const RimPoint &a = edges[any(random)], &b = edges[any(random)], &c = edges[any(random)];
    const double spread = std::min({(a.at - b.at).norm(), (b.at - c.at).norm(), (c.at - a.at).norm()});
    if (spread < about.radius / 2) continue;
    const auto circle = circle_through(a.at, b.at, c.at);
    if (!circle || (circle->centre - about.centre).norm() > kRimSearch * about.radius ||
        std::abs(circle->radius - about.radius) > kRimSearch * about.radius)
      continue;
    const auto near = nearest_edges(edges, rays, *circle, tolerance_of(circle->radius));
    all.push_back({*circle, static_cast<double>(near.size())});
    most = std::max(most, all.back().agreed);
  }
  // Of a circle that is partly hidden fewer can agree.
  std::erase_if(all, [&](const Hypothesis& h) { return h.agreed < kNearlyAsGood * most; });
  for (Hypothesis& h : all) h.agreed *= h.agreed / static_cast<double>(visible_rays(h.circle, rays, shown));
  std::sort(all.begin(), all.end(), [](const Hypothesis& a, const Hypothesis& b) { return a.agreed > b.agreed; });
  std::vector<BallCircle> circles;
  for (const Hypothesis& h : all) {
    const auto alike = [&](const BallCircle& other) {
      return (other.centre - h.circle.centre).norm() + std::abs(other.radius - h.circle.radius) < 0.05 * other.radius;
    };
    if (std::none_of(circles.begin(), circles.end(), alike)) circles.push_back(h.circle);
    if (circles.size() == kCirclesFitted) break;
  }
  return circles;
}

/// What one edge adds to the normal equations of centre and radius.
struct Pull {
  std::size_t block;  ///< part of the outline
  Eigen::Vector3d row;
  double off, weight;
};

/// By Tukey's weights.
std::vector<Pull> pulls_on(const std::vector<RimPoint>& edges, std::size_t rays, const BallCircle& circle) {
  const auto near = nearest_edges(edges, rays, circle, 1.5 * tolerance_of(circle.radius));
  std::vector<double> sizes;
  for (const RimPoint* edge : near) sizes.push_back(std::abs((edge->at - circle.centre).norm() - circle.radius));
  if (sizes.size() < 8) return {};
  const double reach = 4.685 * std::max(1.4826 * median(sizes), kLeastSigma_px);
  std::vector<Pull> pulls;
  for (const RimPoint* edge : near) {
    const Eigen::Vector2d from = edge->at - circle.centre;
    const double off = from.norm() - circle.radius, part = off / reach;
    if (std::abs(part) >= 1) continue;
    pulls.push_back({edge->ray * kBlocks / rays,
                     {from.x() / from.norm(), from.y() / from.norm(), 1},
                     off,
                     std::pow(1 - part * part, 2)});
  }
  return pulls;
}

/// Least squares of the distances from the circle. What is mirrored along the outline moves its edges together, over
/// many pixels: the covariance is that of blocks of the outline, which err independently of each other.
std::optional<RimCircle> fit_circle(const std::vector<RimPoint>& edges, std::size_t rays, BallCircle circle,
                                    const Shown& shown) {
  RimCircle fit;
  for (int round = 0; round < 15; ++round) {
    Eigen::Matrix3d normal = Eigen::Matrix3d::Zero();
    Eigen::Matrix<double, 3, kBlocks> blocks = Eigen::Matrix<double, 3, kBlocks>::Zero();
    for (const Pull& pull : pulls_on(edges, rays, circle)) {
      normal += pull.weight * pull.row * pull.row.transpose();
      blocks.col(static_cast<Eigen::Index>(pull.block)) += pull.weight * pull.off * pull.row;
    }
    const Eigen::LDLT<Eigen::Matrix3d> solver(normal);
    if (!(solver.vectorD().minCoeff() > 1e-6)) return std::nullopt;
    const Eigen::Vector3d step = solver.solve(blocks.rowwise().sum());
    circle.centre += step.head<2>();
    circle.radius += step.z();
    const Eigen::Matrix3d inverse = normal.inverse();
    fit.circle = circle;
    fit.covariance =
        inverse * (blocks * blocks.transpose()) * inverse + kMirrored_px * kMirrored_px * Eigen::Matrix3d::Identity();
    if (step.norm() < 1e-4) break;
  }
  const auto visible = static_cast<double>(visible_rays(circle, rays, shown));
  const auto agreed = static_cast<double>(nearest_edges(edges, rays, circle, tolerance_of(circle.radius)).size());
  fit.visible = visible / static_cast<double>(rays);
  fit.support = std::min(1.0, agreed / visible);
  return fit;
}

}  // namespace

std::optional<RimCircle> fit_rim(const std::vector<RimPoint>& edges, std::size_t rays, const BallCircle& about,
                                 const Shown& shown) {
  std::vector<RimCircle> fits;
  double best = 0;
  for (const BallCircle& guess : consensus(edges, rays, about, shown))
    if (const auto fit = fit_circle(edges, rays, guess, shown)) {
      fits.push_back(*fit);
      best = std::max(best, fit->support);
    }
  std::erase_if(fits, [&](const RimCircle& fit) { return fit.support < kSupportBesideBest * best; });
  if (fits.empty()) return std::nullopt;
  const auto fit = std::max_element(fits.begin(), fits.end(), [](const RimCircle& a, const RimCircle& b) {
    return a.circle.radius < b.circle.radius;
  });
  return *fit;
}

}  // namespace sheen
