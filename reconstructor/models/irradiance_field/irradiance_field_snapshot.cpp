// SPDX-License-Identifier: Apache-2.0
#include "reconstructor/models/irradiance_field/irradiance_field_snapshot.h"

#include <algorithm>
#include <cmath>
#include <functional>

#include "common/base/order_statistics.h"
#include "common/image/color.h"
#include "common/parallel/for_each.h"
#include "reconstructor/irradiance_field_file/encode/field_encoding.h"
#include "reconstructor/models/irradiance_field/compress.h"
#include "reconstructor/models/irradiance_field/field_file.h"
#include "reconstructor/models/irradiance_field/light_intervals.h"
#include "reconstructor/models/irradiance_field/picture_plane.h"

namespace sheen {
namespace {

class PictureShader : public ViewShader {
 public:
  PictureShader(std::shared_ptr<const ImageF> picture, bool seen, float error)
      : picture_(std::move(picture)), seen_(seen), error_(error) {}

  SurfaceSample shade(std::uint32_t triangle, float u, float v) const override {
    const int w = picture_->width(), h = picture_->height();
    const Eigen::Vector2f place = picture_place({w, h}, triangle, u, v);
    const int x = static_cast<int>(std::floor(place.x())), y = static_cast<int>(std::floor(place.y()));
    const float right = place.x() - static_cast<float>(x), down = place.y() - static_cast<float>(y);
    const auto pixel = [&](int px, int py) {
      return Eigen::Map<const Eigen::Vector3f>(picture_->pixel(std::clamp(px, 0, w - 1), std::clamp(py, 0, h - 1)));
    };
    const Eigen::Vector3f rgb = (1 - down) * ((1 - right) * pixel(x, y) + right * pixel(x + 1, y)) +
                                down * ((1 - right) * pixel(x, y + 1) + right * pixel(x + 1, y + 1));
    return {rgb, seen_ ? SampleState::kMeasured : SampleState::kUnseen};
  }
  SurfaceQuality quality(std::uint32_t) const override {
    return seen_ ? SurfaceQuality{true, error_, 1, 1} : SurfaceQuality{};
  }

 private:
  std::shared_ptr<const ImageF> picture_;
  bool seen_;
  float error_;
};

}  // namespace

IrradianceFieldSnapshot::IrradianceFieldSnapshot(std::shared_ptr<const Mesh> mesh, LitScene scene, QuantisedField field,
                                                 std::uint64_t version, bool in_one_file)
    : mesh_(std::move(mesh)),
      scene_(std::move(scene)),
      field_(std::make_shared<const QuantisedField>(std::move(field))),
      version_(version),
      in_one_file_(in_one_file),
      relighting_(std::make_shared<const Relighting>(dequantise(*field_), in_parallel)) {
  if (field_->lights == 0) return;
  lights_.emplace(scene_);
  cameras_.push_back(scene_.camera);
}

std::vector<LightState> IrradianceFieldSnapshot::lights() const {
  std::vector<LightState> lights;
  for (Eigen::Index i = 0; i < scene_.lights.cols(); ++i)
    lights.push_back({.kind = scene_.kind, .position = scene_.lights.col(i)});
  return lights;
}

ImageF IrradianceFieldSnapshot::picture(const LightState& light) const {
  if (empty()) return ImageF(std::max(1, field_->size.width), std::max(1, field_->size.height), 3);
  const LightState known = lights_->known(light);
  ImageF picture = relighting_->encoded_picture(lights_->weights(known), in_parallel);
  decode_levels(picture, in_parallel);
  if (known.rgb != Eigen::Vector3f::Ones())
    for (std::size_t i = 0; i < picture.size(); ++i) picture.data()[i] *= known.rgb[static_cast<Eigen::Index>(i % 3)];
  return picture;
}

ImageU8 IrradianceFieldSnapshot::screen_picture(const LightState& light) const {
  if (empty()) return to_srgb8(picture(light));
  const LightState known = lights_->known(light);
  if (known.rgb != Eigen::Vector3f::Ones()) return to_srgb8(picture(light));
  return rounded_levels(relighting_->encoded_picture(lights_->weights(known), in_parallel), in_parallel);
}

std::unique_ptr<ViewShader> IrradianceFieldSnapshot::shader_for(const ViewQuery& query) const {
  auto sum = std::make_shared<ImageF>(picture(query.light));
  for (const LightState& light : query.more_lights) {
    const ImageF more = picture(light);
    std::transform(sum->data(), sum->data() + sum->size(), more.data(), sum->data(), std::plus<>());
  }
  return std::make_unique<PictureShader>(std::move(sum), !empty(), static_cast<float>(scene_.error));
}

SnapshotFigures IrradianceFieldSnapshot::figures() const {
  std::vector<std::size_t> ranks = relighting_->ranks();
  if (empty() || ranks.empty()) return {};
  return {.median_rank = median_of_both_middles<double>(ranks),
          .most_rank = static_cast<int>(*std::max_element(ranks.begin(), ranks.end())),
          .seen = 1,
          .measured = 1};
}

std::shared_ptr<const ModelSnapshot> IrradianceFieldSnapshot::filled() const {
  return std::make_shared<IrradianceFieldSnapshot>(*this);  // its one camera sees all of its surface
}

ViewAdvice IrradianceFieldSnapshot::advise_next_view(const Eigen::Vector3d& eye) const {
  return {.eye = empty() ? eye : camera_centre(scene_.camera.camera_from_object),
          .heuristic = empty() ? 1.0 : std::min(1.0, scene_.error / 0.1),
          .angle_deg = 0,
          .reason = "the camera stands still: more lights say more",
          .worst_psnr_db = empty() ? 0 : -20 * std::log10(std::max(scene_.error, 1e-6))};
}

std::optional<LightAdvice> IrradianceFieldSnapshot::advise_next_light(double tolerance) const {
  if (empty()) return std::nullopt;
  return judge_lights(scene_, lights_->kriging(), *relighting_, tolerance);
}

std::unique_ptr<Compression> IrradianceFieldSnapshot::compression(CompressionTarget target) const {
  return compress_field(*this, std::move(target));
}

void IrradianceFieldSnapshot::save(const std::filesystem::path& path, const ModelMetadata& metadata,
                                   const StepsDone& progress) const {
  if (in_one_file_)
    save_field_file(path, encode_field(scene_, *field_), metadata);
  else
    save_field_folder(path, encode_field(scene_, *field_), metadata);
  if (progress) progress(1, 1);
}

std::unique_ptr<ViewShader> FlatPicture::shader_for(const ViewQuery&) const {
  return std::make_unique<PictureShader>(picture_, true, error_);
}

}  // namespace sheen
