// SPDX-License-Identifier: Apache-2.0
#include "reconstructor/models/intrinsic_lumigraph/intrinsic_lumigraph.h"

#include <algorithm>
#include <cmath>

#include "common/base/errors.h"
#include "common/base/stage_clock.h"
#include "reconstructor/models/intrinsic_lumigraph/decomposition.h"
#include "reconstructor/models/intrinsic_lumigraph/image_geometry.h"
#include "reconstructor/radiance/capture_rules.h"
#include "reconstructor/radiance/light_refusal.h"
#include "reconstructor/radiance/radiance_image.h"

namespace sheen {
namespace {

constexpr float kGuessedAmbient = 0.1f;  // where no pixel shows both light and shadow

ImageHalf halves(const ImageF& image) {
  ImageHalf out(image.width(), image.height(), image.channels());
  std::transform(image.data(), image.data() + image.size(), out.data(), [](float v) { return Eigen::half(v); });
  return out;
}

ImageF floats(const ImageHalf& image) {
  ImageF out(image.width(), image.height(), image.channels());
  std::transform(image.data(), image.data() + image.size(), out.data(),
                 [](Eigen::half v) { return static_cast<float>(v); });
  return out;
}

}  // namespace

IntrinsicLumigraph::IntrinsicLumigraph(std::shared_ptr<const Mesh> mesh, const IntrinsicLumigraphOptions& options)
    : mesh_(std::move(mesh)), options_(options) {
  options_.require_valid();
  if (!is_view_plane(*mesh_)) occluders_ = std::make_shared<const Occluders>(*mesh_);
}

std::string IntrinsicLumigraph::refusal(const Capture& capture) const {
  if (!capture.pose.usable()) return "no_pose";
  const LightKind kind = views_.empty() ? capture.light.kind : views_.front().images.front().light.kind;
  if (std::string refused = light_refusal(capture.light, kind); !refused.empty()) return refused;
  const PosedCamera posed{capture.camera, capture.pose.camera_from_object};
  for (const View& view : views_)
    if (same_place(view.from, posed))
      for (const LitImage& image : view.images)
        if (same_light_place(image.light.position, capture.light.position)) return "same_view_and_light";
  return {};
}

IntrinsicLumigraph::View* IntrinsicLumigraph::view_of(const Capture& capture) {
  const PosedCamera posed{capture.camera, capture.pose.camera_from_object};
  const auto found =
      std::find_if(views_.begin(), views_.end(), [&](const View& view) { return same_place(view.from, posed); });
  return found == views_.end() ? nullptr : &*found;
}

IngestReport IntrinsicLumigraph::ingest(const Capture& capture) {
  IngestReport report;
  const bool held_out = capture.pose.usable() && is_held_out(capture, options_.hold_out_every);
  report.reason = refusal(capture);
  if (held_out && (report.reason.empty() || report.reason == "same_view_and_light")) {
    report.reason.clear();
    report.status = IngestStatus::kHeldOut;
    return report;
  }
  if (!report.reason.empty()) return report;
  StageClock clock(report.stage_ms);
  ImageF radiance = level_radiance(capture, 1);
  if (!std::all_of(radiance.data(), radiance.data() + radiance.size(), [](float v) { return std::isfinite(v); })) {
    report.reason = "broken_pixels";
    return report;
  }
  for (std::size_t i = 0; i < radiance.size(); ++i)
    radiance.data()[i] /= capture.light.rgb[static_cast<Eigen::Index>(i % 3)];
  if (views_.empty()) first_ = {capture.source_session, capture.sequence};
  View* view = view_of(capture);
  if (!view) view = &views_.emplace_back(View{{capture.camera, capture.pose.camera_from_object}});
  LightState light = capture.light;
  if (light.kind == LightKind::kDirectional) light.position.normalize();
  view->images.push_back({capture.source_session, capture.sequence, light, halves(radiance)});
  newest_ = nullptr;
  clock.done("encode");
  report.status = IngestStatus::kAccepted;
  report.patches_updated = 1;
  return report;
}

bool IntrinsicLumigraph::withdraw(const Capture& capture) {
  bool found = false;
  for (View& view : views_) {
    const bool here = std::erase_if(view.images, [&](const LitImage& image) {
                        return image.source_session == capture.source_session && image.sequence == capture.sequence;
                      }) > 0;
    found |= here;
  }
  std::erase_if(views_, [](const View& view) { return view.images.empty(); });
  if (found) newest_ = nullptr;
  return found;
}

bool IntrinsicLumigraph::began_with(const Capture& capture) const {
  return !views_.empty() && first_ == std::pair{capture.source_session, capture.sequence};
}

void IntrinsicLumigraph::restart(int) {
  views_.clear();
  newest_ = nullptr;
}

LightSet IntrinsicLumigraph::light_set() const {
  LightSet lights;
  std::vector<Eigen::Vector3d> places;
  for (const View& view : views_)
    for (const LitImage& image : view.images) {
      lights.kind = image.light.kind;
      const auto same = [&](const Eigen::Vector3d& p) { return same_light_place(p, image.light.position); };
      if (std::none_of(places.begin(), places.end(), same)) places.push_back(image.light.position);
    }
  lights.places.resize(3, static_cast<Eigen::Index>(places.size()));
  for (std::size_t i = 0; i < places.size(); ++i) lights.places.col(static_cast<Eigen::Index>(i)) = places[i];
  return lights;
}

CapturedView IntrinsicLumigraph::captured(const View& view, const LightSet& lights) const {
  CapturedView out{.from = view.from};
  for (int light = 0; light < lights.size(); ++light)
    for (const LitImage& image : view.images) {
      if (!same_light_place(image.light.position, lights.places.col(light))) continue;
      out.lights.push_back(light);
      out.radiance.push_back(floats(image.radiance));
    }
  return out;
}

LumigraphData IntrinsicLumigraph::on_mesh(const LightSet& lights) const {
  LumigraphData data{.lights = lights};
  for (const View& view : views_) {
    CapturedView images = captured(view, lights);
    const SeenSurface surface(*occluders_, view.from);
    images.depth = surface.depth();
    images.normals = surface.normals();
    for (const int light : images.lights) images.arrives.push_back(surface.reached(lights.lamp(light)));
    double ambient = ambient_light(images, lights);
    if (!(ambient > 0)) ambient = kGuessedAmbient;
    data.views.push_back(std::make_shared<const IntrinsicView>(
        decompose(images, lights, known_reflectance(images, lights, ambient), ambient)));
  }
  return data;
}

std::shared_ptr<const ModelSnapshot> IntrinsicLumigraph::snapshot() {
  if (newest_) return newest_;
  const LightSet lights = light_set();
  auto data = std::make_shared<LumigraphData>();
  if (occluders_) {
    *data = on_mesh(lights);
  } else {
    std::vector<CapturedView> images;
    for (const View& view : views_) images.push_back(captured(view, lights));
    *data = lumigraph_of_images(std::move(images), lights);
  }
  newest_ = std::make_shared<IntrinsicLumigraphSnapshot>(mesh_, occluders_, std::move(data), ++version_);
  return newest_;
}

std::shared_ptr<const Appearance> IntrinsicLumigraph::constant_colour() const {
  auto model = newest_ ? newest_
                       : std::make_shared<IntrinsicLumigraphSnapshot>(
                             mesh_, occluders_, std::make_shared<const LumigraphData>(), version_);
  return std::make_shared<InterpolatedImages>(std::move(model), true);
}

ModelFigures IntrinsicLumigraph::figures() const {
  ModelFigures figures;
  std::size_t most = 0;
  for (const View& view : views_) {
    figures.images += view.images.size();
    most = std::max(most, view.images.size());
    for (const LitImage& image : view.images) figures.bytes += image.radiance.size() * sizeof(Eigen::half);
  }
  if (views_.empty()) return figures;
  figures.rank_histogram.assign(most + 1, 0);  // a patch is a view, its rank the number of its lights
  for (const View& view : views_) ++figures.rank_histogram[view.images.size()];
  figures.bytes_per_patch = static_cast<double>(figures.bytes) / static_cast<double>(views_.size());
  return figures;
}

MemoryAccount IntrinsicLumigraph::memory(const CaptureSize& image) const {
  const auto bytes = static_cast<double>(figures().bytes);
  return {.ingest = image.bytes, .model = bytes, .snapshots = bytes};
}

}  // namespace sheen
