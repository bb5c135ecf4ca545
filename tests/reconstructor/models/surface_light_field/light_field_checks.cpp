// SPDX-License-Identifier: Apache-2.0
#include "tests/reconstructor/models/surface_light_field/light_field_checks.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <bit>
#include <cmath>
#include <numeric>

#include "common/image/image_metrics.h"
#include "reconstructor/render/ray_painter.h"

namespace sheen {
namespace {

template <typename M>
bool same_bits(const M& a, const M& b) {
  return a.rows() == b.rows() && a.cols() == b.cols() &&
         std::equal(a.data(), a.data() + a.size(), b.data(), [](float x, float y) {
           return std::bit_cast<std::uint32_t>(x) == std::bit_cast<std::uint32_t>(y);
         });
}

double shown(float linear) {
  return std::clamp(double(srgb_encode(linear)), 0.0, 1.0);
}

}  // namespace

void ingest_all(SurfaceLightField& model, const std::vector<Capture>& captures) {
  for (const Capture& capture : captures) {
    const IngestReport report = model.ingest(capture);
    ASSERT_EQ(report.status, IngestStatus::kAccepted) << report.reason;
  }
}

double Comparison::psnr_db() const {
  return -20 * std::log10(rms);
}

Comparison compare(const Appearance& model, const analytic::Scene& scene, const std::vector<Eigen::Vector3d>& eyes) {
  Comparison result;
  const RayPainter painter(model.mesh());
  double sum = 0;
  for (const Eigen::Vector3d& eye : eyes) {
    const Rigid3 pose = analytic::towards_origin(eye);
    const PaintedView painted = painter.paint(model, camera_at(eye), pose);
    const ImageF truth = analytic::picture(scene, camera_at(eye), pose);
    ImageU8 silhouette = painted.coverage;
    for (std::size_t i = 0; i < silhouette.size(); ++i) silhouette.data()[i] = silhouette.data()[i] ? 255 : 0;
    silhouette = erode(silhouette, 3);
    for (std::size_t i = 0; i < silhouette.size(); ++i) {
      if (!silhouette.data()[i]) continue;
      if (painted.coverage.data()[i] < kCoverageImputed) {
        ++result.unseen;
        continue;
      }
      ++result.pixels;
      for (int c = 0; c < 3; ++c) {
        const double p = shown(painted.beauty.data()[3 * i + c]), t = shown(truth.data()[3 * i + c]);
        sum += (p - t) * (p - t);
        result.worst = std::max(result.worst, std::abs(p - t));
        result.darkest_ratio = std::min(result.darkest_ratio, p / t);
      }
    }
  }
  result.rms = std::sqrt(sum / (3.0 * static_cast<double>(result.pixels)));
  return result;
}

const SurfaceLightFieldSnapshot& light_field(const ModelSnapshot& snapshot) {
  return dynamic_cast<const SurfaceLightFieldSnapshot&>(snapshot);
}

void expect_same_patches(const ModelSnapshot& first, const ModelSnapshot& second) {
  const SurfaceLightFieldSnapshot &a = light_field(first), &b = light_field(second);
  ASSERT_EQ(a.shapes().patch_of, b.shapes().patch_of);
  ASSERT_EQ(a.maps().total_samples(), b.maps().total_samples());
  for (std::size_t i = 0; i < a.patches().size(); ++i) {
    const PatchSnapshot *p = a.patches()[i].get(), *q = b.patches()[i].get();
    ASSERT_EQ(p == nullptr, q == nullptr) << "patch " << i;
    if (!p) continue;
    EXPECT_TRUE(same_bits(p->colours(), q->colours())) << "patch " << i;
    EXPECT_EQ(p->shown, q->shown) << "patch " << i;
    for (std::size_t k = 0; k < p->vertices.size(); ++k) {
      const VertexInterpolant &v = p->vertices[k], &w = q->vertices[k];
      EXPECT_TRUE(same_bits(v.views->directions, w.views->directions)) << "patch " << i;
      EXPECT_TRUE(same_bits(v.weights.unpacked(), w.weights.unpacked())) << "patch " << i;
      EXPECT_TRUE(same_bits(v.mean, w.mean)) << "patch " << i;
      EXPECT_EQ(v.views->kernel, w.views->kernel) << "patch " << i;
      EXPECT_EQ(v.sill, w.sill) << "patch " << i;
      EXPECT_EQ(v.residual, w.residual) << "patch " << i;
      EXPECT_EQ(v.views->best_cosine, w.views->best_cosine) << "patch " << i;
      EXPECT_EQ(v.views_folded, w.views_folded) << "patch " << i;
    }
  }
}

double share_of_rank_up_to(const SurfaceLightField& model, std::size_t rank) {
  const std::vector<std::size_t> histogram = model.figures().rank_histogram;
  const auto end = histogram.begin() + static_cast<std::ptrdiff_t>(std::min(rank + 1, histogram.size()));
  return std::accumulate(histogram.begin(), end, 0.0) / std::accumulate(histogram.begin(), histogram.end(), 0.0);
}

}  // namespace sheen
