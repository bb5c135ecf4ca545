// SPDX-License-Identifier: Apache-2.0
#include "reconstructor/commands/picture_layers.h"

#include <algorithm>
#include <array>
#include <utility>

#include "common/base/errors.h"
#include "reconstructor/render/surface_pictures.h"

namespace sheen {
namespace {

struct PropertyLayer {
  const char* name;
  SurfaceProperty property;
  std::vector<std::string> channels;
};
const std::array<PropertyLayer, 3> kPropertyLayers{{{"reflectance", SurfaceProperty::kReflectance, {"R", "G", "B"}},
                                                    {"illumination", SurfaceProperty::kIllumination, {"R", "G", "B"}},
                                                    {"shadow", SurfaceProperty::kShadow, {"Y"}}}};

/// The first channels of a picture.
ImageF channels_of(const ImageF& picture, std::size_t count) {
  ImageF out(picture.width(), picture.height(), static_cast<int>(count));
  for (std::size_t i = 0; i < out.size(); ++i) out.data()[i] = picture.data()[3 * (i / count) + i % count];
  return out;
}

}  // namespace

ValueCheck is_layer() {
  return one_of({"depth", "normals", "reflectance", "illumination", "shadow"});
}

PictureLayers::PictureLayers(const std::vector<std::string>& names, std::shared_ptr<const ModelSnapshot> snapshot,
                             const std::string& model)
    : snapshot_(std::move(snapshot)) {
  const auto* const surface = dynamic_cast<const KnownSurface*>(snapshot_.get());
  const bool is_mesh = !surface || surface->is_mesh();
  const auto asked = [&](const char* name) { return std::find(names.begin(), names.end(), name) != names.end(); };
  const auto refuse = [&](const char* name, const char* why) {
    throw ConfigError(model + " has no layer " + name + ": " + why);
  };
  depth_ = asked("depth");
  if (depth_ && !is_mesh) places_ = surface->property(SurfaceProperty::kPlace);
  if (depth_ && !is_mesh && !places_) refuse("depth", "an irradiance field is a picture, and knows of no surface");
  if (asked("normals")) {
    if (!is_mesh) refuse("normals", "it was built without a mesh");
    normals_ = vertex_normals(snapshot_->mesh());
  }
  for (const PropertyLayer& layer : kPropertyLayers) {
    if (!asked(layer.name)) continue;
    auto appearance = surface ? surface->property(layer.property) : nullptr;
    if (!appearance) refuse(layer.name, "only an intrinsic lumigraph tells reflectance, illumination and shadow apart");
    properties_.push_back({layer.name, layer.channels, std::move(appearance)});
  }
}

void PictureLayers::add(const RayPainter& painter, const PosedCamera& from, const LightState& light,
                        ExrFile& file) const {
  const auto paint = [&](const Appearance& appearance) {
    return painter.paint(appearance, from.camera, from.camera_from_object, light);
  };
  const std::vector<Hit> hits = (depth_ && !places_) || !normals_.empty()
                                    ? painter.cast(from.camera, from.camera_from_object)
                                    : std::vector<Hit>();
  const auto known_depth = [&] {
    if (!places_) return depth_picture(snapshot_->mesh(), hits, from);
    const PaintedView places = paint(*places_);
    std::vector<bool> known(places.coverage.size());
    for (std::size_t i = 0; i < known.size(); ++i) known[i] = places.coverage.data()[i] == kCoverageMeasured;
    return depth_picture(places.beauty, known, from);
  };
  if (depth_) file.parts.push_back({"depth", {"Z"}, known_depth(), ExrPrecision::kFloat});
  if (!normals_.empty())
    file.parts.push_back({"normals",
                          {"X", "Y", "Z"},
                          normal_picture(snapshot_->mesh(), normals_, hits, from.camera),
                          ExrPrecision::kFloat});
  for (const Property& property : properties_)
    file.parts.push_back({property.name, property.channels,
                          channels_of(paint(*property.appearance).beauty, property.channels.size()),
                          ExrPrecision::kHalf});
}

}  // namespace sheen
