// SPDX-License-Identifier: Apache-2.0
#include "reconstructor/studies/depth_merging.h"

#include <algorithm>
#include <cmath>
#include <opencv2/imgproc.hpp>

#include "common/image/color.h"
#include "common/simulation/light_rig_capture.h"
#include "reconstructor/models/intrinsic_lumigraph/image_geometry.h"
#include "reconstructor/radiance/radiance_image.h"

namespace sheen {
namespace {

constexpr double kNoConfidence = 1e-12;
constexpr int kWindow = 5;  // pixels along a side

/// The views in one of their lights.
std::vector<CapturedView> in_light(const std::vector<CapturedView>& views, std::size_t light) {
  std::vector<CapturedView> alone;
  for (const CapturedView& view : views)
    alone.push_back({.from = view.from, .lights = {view.lights[light]}, .radiance = {view.radiance[light]}});
  return alone;
}

std::vector<CapturedView> views_of(const LightRig& rig) {
  std::vector<CapturedView> views;
  for (const PosedCamera& from : rig.cameras()) {
    CapturedView& view = views.emplace_back(CapturedView{.from = from});
    for (std::size_t l = 0; l < rig.lights().size(); ++l) {
      view.lights.push_back(static_cast<int>(l));
      view.radiance.push_back(
          level_radiance(rig_capture(from, rig.lights()[l], rig.picture(from, rig.lights()[l]).radiance, 1), 1));
    }
  }
  return views;
}

ImageF grey_of(const ImageF& radiance) {
  ImageF grey(radiance.width(), radiance.height(), 1);
  for (std::size_t i = 0; i < grey.size(); ++i) grey.data()[i] = luminance(radiance.data() + 3 * i);
  return grey;
}

}  // namespace

ImageF merge_depths(std::span<const ImageF> depths, std::span<const ImageF> confidences) {
  ImageF merged(depths[0].width(), depths[0].height(), 1);
  for (std::size_t i = 0; i < merged.size(); ++i) {
    double weights = kNoConfidence, sum = kNoConfidence * depths[0].data()[i];
    for (std::size_t n = 0; n < depths.size(); ++n) {
      sum += static_cast<double>(confidences[n].data()[i]) * depths[n].data()[i];
      weights += confidences[n].data()[i];
    }
    merged.data()[i] = static_cast<float>(sum / weights);
  }
  return merged;
}

ImageF texture_confidence(const ImageF& grey) {
  ImageF out(grey.width(), grey.height(), 1);
  const cv::Mat values(grey.height(), grey.width(), CV_32FC1, const_cast<float*>(grey.data()));
  cv::Mat eigenvalue(out.height(), out.width(), CV_32FC1, out.data());
  cv::cornerMinEigenVal(values, eigenvalue, kWindow);
  return out;
}

double DepthsByLight::error(const ImageF& depth) const {
  double sum = 0;
  std::size_t count = 0;
  for (std::size_t i = 0; i < truth.size(); ++i)
    if (truth.data()[i] > 0) {
      sum += std::abs(depth.data()[i] - truth.data()[i]);
      ++count;
    }
  return sum / static_cast<double>(count);
}

double DepthsByLight::least_error(const std::vector<ImageF>& depths) const {
  std::vector<double> errors;
  for (const ImageF& depth : depths) errors.push_back(error(depth));
  return *std::min_element(errors.begin(), errors.end());
}

DepthsByLight depths_by_light(const LightRig& rig) {
  const std::vector<CapturedView> views = views_of(rig);
  const std::size_t centre = views.size() / 2;
  DepthsByLight depths{.truth = rig.picture(rig.central_camera(), rig.lights()[0]).depth};
  std::vector<ImageF> confidences, textures;
  for (std::size_t l = 0; l < rig.lights().size(); ++l) {
    depths.refined.push_back(swept_depth(in_light(views, l), centre));
    DepthInLight swept = swept_depth_in_light(views, centre, static_cast<int>(l));
    depths.on_planes.push_back(std::move(swept.depth));
    confidences.push_back(std::move(swept.confidence));
    textures.push_back(texture_confidence(grey_of(views[centre].radiance[l])));
  }
  depths.by_variance = merge_depths(depths.on_planes, confidences);
  depths.by_texture = merge_depths(depths.on_planes, textures);
  depths.by_all = swept_depth(views, centre);
  return depths;
}

}  // namespace sheen
