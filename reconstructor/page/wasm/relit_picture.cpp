// SPDX-License-Identifier: Apache-2.0
#include "reconstructor/page/wasm/relit_picture.h"

#include <algorithm>

#include "common/image/color.h"
#include "common/parallel/for_each.h"
#include "reconstructor/irradiance_field_file/field_reader.h"

namespace sheen {

RelitPicture::RelitPicture(std::string_view bytes, const std::string& file) {
  StoredField stored = read_field(bytes, file);
  const LitScene& scene = stored.scene;
  kind_ = scene.kind;
  lights_.emplace(scene);
  const FieldTerms terms = dequantise(stored.field);
  for (QuantisedField::Component& component : stored.field.components) component = {};  // a phone has little memory
  relighting_.emplace(terms, one_after_the_other);
  places_.assign(scene.lights.data(), scene.lights.data() + scene.lights.size());
  const double away = scene.lights.colwise().norm().mean();
  scene_ = {static_cast<double>(stored.field.size.width), static_cast<double>(stored.field.size.height),
            kind_ == LightKind::kPoint ? 1.0 : 0.0, away};
  const Eigen::Matrix3d axes = scene.camera.camera_from_object.rotation.toRotationMatrix();
  for (int axis = 0; axis < 3; ++axis)
    for (int i = 0; i < 3; ++i) scene_.push_back(axes(axis, i));
}

const std::vector<std::uint8_t>& RelitPicture::in_light(const Eigen::Vector3d& place) {
  const LightState light = lights_->known({.kind = kind_, .position = place});
  const ImageF levels = relighting_->encoded_picture(lights_->weights(light), one_after_the_other);
  const std::size_t count = levels.size() / 3;
  pixels_.resize(4 * count);
  for (std::size_t i = 0; i < count; ++i) {
    for (std::size_t c = 0; c < 3; ++c) {
      // A lamp off the plane of the others has another brightness, which counts in linear light.
      float level = levels.data()[3 * i + c];
      const float brightness = light.rgb[static_cast<Eigen::Index>(c)];
      if (brightness != 1) level = 255 * srgb_encode(brightness * srgb_decode(level / 255));
      pixels_[4 * i + c] = static_cast<std::uint8_t>(std::clamp(level, 0.0f, 255.0f) + 0.5f);
    }
    pixels_[4 * i + 3] = 255;
  }
  return pixels_;
}

}  // namespace sheen
