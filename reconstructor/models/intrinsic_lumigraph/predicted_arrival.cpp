// SPDX-License-Identifier: Apache-2.0
#include "reconstructor/models/intrinsic_lumigraph/predicted_arrival.h"

#include <tbb/parallel_for.h>

#include <algorithm>
#include <opencv2/imgproc.hpp>

#include "common/parallel/for_each.h"
#include "reconstructor/lumigraph_file/depth_points.h"

namespace sheen {
namespace {

using Eigen::Vector3f;

constexpr std::uint8_t kShadow = 200;  // of what arrives: up to here a pixel is not wholly lit
constexpr int kSpeck = 3;              // pixels: smaller spots of light or shadow are noise
constexpr int kEdge = 3;               // pixels: over which edges are smoothed, as wrong as they are

/// The pixels next to one of the other class, by 3 x 3 ways each.
ImageU8 sampled_at_edges(const ShadowHull& hull, const IntrinsicView& view, const Lamp& lamp, const ImageU8& classes) {
  constexpr int kSamples = 3;
  const DepthPoints points(view.from);
  ImageU8 sampled = classes;
  const auto at_edge = [&](int x, int y) {
    for (int v = y - 1; v <= y + 1; ++v)
      for (int u = x - 1; u <= x + 1; ++u)
        if (classes.at(u, v) != classes.at(x, y)) return true;
    return false;
  };
  tbb::parallel_for(1, std::max(1, classes.height() - 1), [&](int y) {
    for (int x = 1; x + 1 < classes.width(); ++x) {
      const float depth = view.depth.at(x, y);
      if (!(depth > 0) || !at_edge(x, y)) continue;
      int reached = 0;
      for (int j = 0; j < kSamples; ++j)
        for (int i = 0; i < kSamples; ++i)
          reached +=
              !hull.hides(points.at(x + (i + 0.5) / kSamples - 0.5, y + (j + 0.5) / kSamples - 0.5, depth), lamp);
      sampled.at(x, y) = static_cast<std::uint8_t>(255 * reached / (kSamples * kSamples));
    }
  });
  return sampled;
}

}  // namespace

ImageU8 reached_past(const ShadowHull& hull, const IntrinsicView& view, const Lamp& lamp) {
  const int w = view.depth.width(), h = view.depth.height();
  ImageU8 classes(w, h, 1, 255);
  for_each_point(view.from, view.depth, in_parallel, [&](std::size_t pixel, const Vector3f& point) {
    if (view.depth.data()[pixel] > 0 && hull.hides(point, lamp)) classes.data()[pixel] = 0;
  });
  ImageU8 sampled = sampled_at_edges(hull, view, lamp, classes), out(w, h, 1);
  const cv::Mat found(h, w, CV_8UC1, sampled.data());
  cv::Mat clean, smooth(h, w, CV_8UC1, out.data());
  cv::medianBlur(found, clean, kSpeck);
  cv::GaussianBlur(clean, smooth, {kEdge, kEdge}, 0, 0, cv::BORDER_REPLICATE);
  return out;
}

ImageU8 predicted_arrival(const LumigraphData& data, const IntrinsicView& view, const Eigen::Vector3d& place) {
  const LightWeights between = lights_between(view, data.lights, place);
  if (between.size() == 1 && same_light_place(data.lights.places.col(view.lights[between[0].first]), place))
    return view.arrives[between[0].first];
  ImageU8 out = reached_past(data.hull, view, data.lights.lamp(place));
  for (std::size_t i = 0; i < out.size(); ++i)
    if (std::all_of(between.begin(), between.end(),
                    [&](const auto& neighbour) { return view.arrives[neighbour.first].data()[i] <= kShadow; }))
      out.data()[i] = 0;
  return out;
}

}  // namespace sheen
