// SPDX-License-Identifier: Apache-2.0
#include "reconstructor/lumigraph_file/lumigraph_data.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "reconstructor/lumigraph_file/depth_points.h"

namespace sheen {
namespace {

using Eigen::Vector3f;

Vector3f half_rgb(const ImageHalf& image, std::size_t pixel) {
  return Eigen::Map<const Eigen::Matrix<Eigen::half, 3, 1>>(image.data() + 3 * pixel).cast<float>();
}

float cosine_at(const IntrinsicView& view, std::size_t pixel, const Vector3f& incidence) {
  return std::max(0.0f, half_rgb(view.slope, pixel).dot(incidence));
}

/// The weighted sum of a view's images.
ImageF weighted_images(const IntrinsicView& view, const LightSet& lights, const LightWeights& weights,
                       const ForEach& for_each) {
  std::vector<Lamp> lamps;
  for (const int light : view.lights) lamps.push_back(lights.lamp(light));
  ImageF out(view.depth.width(), view.depth.height(), 3);
  for_each_point(view.from, view.depth, for_each, [&](std::size_t pixel, const Vector3f& point) {
    const Vector3f reflectance = half_rgb(view.reflectance, pixel);
    const auto ambient = static_cast<float>(view.ambient.data()[pixel]);
    Vector3f sum = Vector3f::Zero();
    for (const auto& [light, weight] : weights) {
      const Vector3f s = lamps[light].incidence(point);
      const float part = static_cast<float>(view.arrives[light].data()[pixel]) / 255;
      sum += weight * (reflectance * (ambient + part * cosine_at(view, pixel, s)) + view.residual_at(light, pixel));
    }
    Vector3f::Map(out.data() + 3 * pixel) = sum.cwiseMax(0);
  });
  return out;
}

}  // namespace

LightWeights lights_between(const IntrinsicView& view, const LightSet& lights, const Eigen::Vector3d& place) {
  LightSet own{.kind = lights.kind, .places = Eigen::Matrix3Xd(3, static_cast<Eigen::Index>(view.lights.size()))};
  for (std::size_t i = 0; i < view.lights.size(); ++i)
    own.places.col(static_cast<Eigen::Index>(i)) = lights.places.col(view.lights[i]);
  LightWeights out;
  for (const auto& [light, weight] : own.between(place)) out.emplace_back(static_cast<std::size_t>(light), weight);
  return out;
}

RelitView relight(const IntrinsicView& view, const LightSet& lights, const Eigen::Vector3d& place,
                  const ForEach& for_each) {
  const auto between = lights_between(view, lights, place);
  const Lamp lamp = lights.lamp(place);
  RelitView out{ImageF(view.depth.width(), view.depth.height(), 3), ImageF(view.depth.width(), view.depth.height(), 3)};
  for_each_point(view.from, view.depth, for_each, [&](std::size_t pixel, const Vector3f& point) {
    const Vector3f reflectance = half_rgb(view.reflectance, pixel),
                   dark = reflectance * static_cast<float>(view.ambient.data()[pixel]);
    Vector3f lit = dark + reflectance * cosine_at(view, pixel, lamp.incidence(point));
    for (const auto& [light, weight] : between) lit += weight * view.residual_at(light, pixel);
    Vector3f::Map(out.dark.data() + 3 * pixel) = dark;
    Vector3f::Map(out.lit.data() + 3 * pixel) = lit.cwiseMax(0);
  });
  return out;
}

RelitView illuminated(const IntrinsicView& view, const LightSet& lights, const Eigen::Vector3d& place,
                      const ForEach& for_each) {
  const Lamp lamp = lights.lamp(place);
  RelitView out{ImageF(view.depth.width(), view.depth.height(), 3), ImageF(view.depth.width(), view.depth.height(), 3)};
  for_each_point(view.from, view.depth, for_each, [&](std::size_t pixel, const Vector3f& point) {
    const auto ambient = static_cast<float>(view.ambient.data()[pixel]);
    Vector3f::Map(out.dark.data() + 3 * pixel).setConstant(ambient);
    Vector3f::Map(out.lit.data() + 3 * pixel).setConstant(ambient + cosine_at(view, pixel, lamp.incidence(point)));
  });
  return out;
}

ImageF shadowed(const RelitView& relit, const ImageU8& arrives) {
  ImageF out(relit.lit.width(), relit.lit.height(), 3);
  for (std::size_t i = 0; i < out.size(); ++i) {
    const float part = static_cast<float>(arrives.data()[i / 3]) / 255;
    out.data()[i] = relit.dark.data()[i] + part * (relit.lit.data()[i] - relit.dark.data()[i]);
  }
  return out;
}

ImageF interpolated_images(const IntrinsicView& view, const LightSet& lights, const Eigen::Vector3d& place,
                           const ForEach& for_each) {
  return weighted_images(view, lights, lights_between(view, lights, place), for_each);
}

ImageF interpolated_visibility(const IntrinsicView& view, const LightSet& lights, const Eigen::Vector3d& place) {
  ImageF out(view.depth.width(), view.depth.height(), 3);
  for (const auto& [light, weight] : lights_between(view, lights, place))
    for (std::size_t i = 0; i < out.size(); ++i)
      out.data()[i] += weight * static_cast<float>(view.arrives[light].data()[i / 3]) / 255;
  return out;
}

ImageF mean_image(const IntrinsicView& view, const LightSet& lights, const ForEach& for_each) {
  LightWeights all;
  for (std::size_t i = 0; i < view.lights.size(); ++i)
    all.emplace_back(i, 1.0f / static_cast<float>(view.lights.size()));
  return weighted_images(view, lights, all, for_each);
}

void scale(RelitView& relit, const Vector3f& rgb) {
  if (rgb == Vector3f::Ones()) return;
  for (ImageF* image : {&relit.lit, &relit.dark})
    for (std::size_t i = 0; i < image->size(); ++i) image->data()[i] *= rgb[static_cast<Eigen::Index>(i % 3)];
}

std::size_t bytes_of(const IntrinsicView& view) {
  const std::size_t pixels = view.depth.size();
  return pixels * (sizeof(float) + 7 * sizeof(Eigen::half) + 4 * view.lights.size());
}

namespace {

constexpr std::size_t kMostNear = 4;

/// Distance from an eye and index, the nearest first.
std::vector<std::pair<double, std::size_t>> by_distance(const std::vector<std::shared_ptr<const IntrinsicView>>& views,
                                                        const Eigen::Vector3d& eye) {
  std::vector<std::pair<double, std::size_t>> order;
  for (std::size_t v = 0; v < views.size(); ++v)
    order.emplace_back((camera_centre(views[v]->from.camera_from_object) - eye).norm(), v);
  std::sort(order.begin(), order.end());
  return order;
}

/// Each as far as can be from those before.
std::vector<std::size_t> spread_views(const std::vector<std::shared_ptr<const IntrinsicView>>& views) {
  constexpr std::size_t kMost = 6;
  std::vector<std::size_t> chosen;
  std::vector<double> away(views.size(), std::numeric_limits<double>::infinity());
  for (std::size_t next = 0; chosen.size() < std::min(kMost, views.size());) {
    chosen.push_back(next);
    const Eigen::Vector3d centre = camera_centre(views[next]->from.camera_from_object);
    for (std::size_t v = 0; v < views.size(); ++v)
      away[v] = std::min(away[v], (camera_centre(views[v]->from.camera_from_object) - centre).norm());
    next = static_cast<std::size_t>(std::max_element(away.begin(), away.end()) - away.begin());
  }
  return chosen;
}

}  // namespace

std::vector<WeightedView> views_near(const std::vector<std::shared_ptr<const IntrinsicView>>& views,
                                     const Eigen::Vector3d& eye) {
  constexpr double kThere = 1e-6;  // of the distance of the next view
  std::vector<std::pair<double, std::size_t>> order = by_distance(views, eye);
  if (order.empty()) return {};
  if (order.size() == 1 || order[0].first <= kThere * order[1].first) return {{order[0].second, 1.0f}};
  const double reach = order.size() > kMostNear ? order[kMostNear].first : 2 * order.back().first;
  order.resize(std::min(order.size(), kMostNear));
  std::vector<WeightedView> out;
  double sum = 0;
  for (const auto& [distance, view] : order) {
    const double weight = std::max(1e-6, 1 - distance / reach) / distance;
    out.push_back({view, static_cast<float>(weight)});
    sum += weight;
  }
  for (WeightedView& view : out) view.weight /= static_cast<float>(sum);
  return out;
}

std::vector<WeightedView> views_round(const std::vector<std::shared_ptr<const IntrinsicView>>& views,
                                      const Eigen::Vector3d& eye) {
  constexpr double kAmong = 0.25;  // by so much nearer than the fifth is the nearest view to an eye among the views
  std::vector<WeightedView> out = views_near(views, eye);
  if (views.size() <= kMostNear) return out;
  const auto order = by_distance(views, eye);
  const double among = std::min(1.0, (1 - order[0].first / order[kMostNear].first) / kAmong);
  if (among >= 1) return out;
  const auto near = static_cast<float>(among * among * (3 - 2 * among));
  for (WeightedView& view : out) view.weight *= near;
  const std::vector<std::size_t> all_round = spread_views(views);
  for (const std::size_t v : all_round) {
    const float weight = (1 - near) / static_cast<float>(all_round.size());
    const auto same = std::find_if(out.begin(), out.end(), [v](const WeightedView& view) { return view.view == v; });
    if (same != out.end())
      same->weight += weight;
    else
      out.push_back({v, weight});
  }
  return out;
}

}  // namespace sheen
