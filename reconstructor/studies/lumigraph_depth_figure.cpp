// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <cmath>

#include "common/base/format.h"
#include "reconstructor/studies/lumigraph_figures.h"

namespace sheen {
namespace {

constexpr double kDepthGoal = 0.5;         // of the best light's error: Sheen's own
constexpr float kWhiteDepthError = 0.02f;  // metres that an error map shows as white

ImageU8 shown_depth_error(const ImageF& depth, const ImageF& truth) {
  ImageU8 shown(depth.width(), depth.height(), 1);
  for (std::size_t i = 0; i < shown.size(); ++i)
    if (truth.data()[i] > 0)
      shown.data()[i] = static_cast<std::uint8_t>(
          std::min(255.0f, 255 * std::abs(depth.data()[i] - truth.data()[i]) / kWhiteDepthError));
  return shown;
}

ImageU8 shown_depth(const ImageF& depth, const ImageF& truth) {
  float near = 1e30f, far = 0;
  for (std::size_t i = 0; i < truth.size(); ++i)
    if (truth.data()[i] > 0) {
      near = std::min(near, truth.data()[i]);
      far = std::max(far, truth.data()[i]);
    }
  ImageU8 shown(depth.width(), depth.height(), 1);
  for (std::size_t i = 0; i < shown.size(); ++i)
    if (truth.data()[i] > 0)
      shown.data()[i] =
          static_cast<std::uint8_t>(std::clamp(255 * (far - depth.data()[i]) / (far - near), 0.0f, 255.0f));
  return shown;
}

std::string millimetres(double metres) {
  return format("%.2f", 1e3 * metres);
}

}  // namespace

Figure figure_merged_depth(const DepthsByLight& depths) {
  const double best = depths.least_error(depths.on_planes), variance = depths.error(depths.by_variance),
               texture = depths.error(depths.by_texture), all = depths.error(depths.by_all);
  Figure figure{.number = 3,
                .title = "depth merged over lights",
                .paper =
                    "confidences by variance and by the Hessian are alike, and significantly better than any one "
                    "light",
                .ours = format("%.2f times the error of the best light by variance, %.2f by the Hessian; costs of all "
                               "lights added, and found between planes, %.2f",
                               variance / best, texture / best, all / best),
                .holds = std::max(variance, texture) < best && std::abs(variance / texture - 1) < 0.1 &&
                         all <= kDepthGoal * best};
  Figure::Table table{"lumigraph_depth",
                      "Mean error of the depth of the central view",
                      {"depth", "on planes, mm", "found between planes, mm"},
                      {}};
  for (std::size_t l = 0; l < depths.on_planes.size(); ++l)
    table.rows.push_back({format("light %zu", l + 1), millimetres(depths.error(depths.on_planes[l])),
                          millimetres(depths.error(depths.refined[l]))});
  table.rows.push_back({"merged by variance (eq. 1)", millimetres(variance), ""});
  table.rows.push_back({"merged by the Hessian (eq. 2-4)", millimetres(texture), ""});
  table.rows.push_back({"costs of all lights added", "", millimetres(all)});
  figure.tables.push_back(std::move(table));
  const std::size_t middle = depths.on_planes.size() / 2;
  std::vector<std::vector<ImageU8>> rows(2);
  for (const ImageF* depth :
       {&depths.truth, &depths.on_planes[middle], &depths.by_variance, &depths.by_texture, &depths.by_all}) {
    rows[0].push_back(shown_depth(*depth, depths.truth));
    rows[1].push_back(shown_depth_error(*depth, depths.truth));
  }
  figure.pictures.push_back({"lumigraph_depth",
                             "depth: the truth, one light, merged by variance, by the Hessian, costs of all lights "
                             "added; below, errors: 20 mm are white",
                             mosaic(rows)});
  return figure;
}

}  // namespace sheen
