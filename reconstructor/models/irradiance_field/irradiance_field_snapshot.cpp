// SPDX-License-Identifier: Apache-2.0
#include "reconstructor/models/irradiance_field/irradiance_field_snapshot.h"

#include <algorithm>
#include <cmath>
#include <functional>

#include "common/base/errors.h"
#include "common/base/order_statistics.h"
#include "common/image/color.h"
#include "reconstructor/models/irradiance_field/compress.h"
#include "reconstructor/models/irradiance_field/field_file.h"
#include "reconstructor/models/irradiance_field/light_intervals.h"
#include "reconstructor/models/light_refusal.h"

namespace sheen {
namespace {

/// Between lights the absolute weights add up to 3 at most; what lies beyond them is a difference of ever larger ones.
constexpr float kMostWeight = 4;

constexpr double kOnPlane = 1e-4;  // of its distance: nearer than that a lamp is on its plane

/// The nearer a light, the more it counts; none less than nothing.
Eigen::VectorXf weights_by_distance(const Eigen::Matrix3Xd& lights, const Eigen::Vector3d& place) {
  const Eigen::VectorXd weights = (lights.colwise() - place).colwise().squaredNorm().cwiseInverse().transpose();
  return (weights / weights.sum()).cast<float>();
}

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
      relighting_(std::make_shared<const Relighting>(dequantise(*field_))) {
  if (field_->lights == 0) return;
  kriging_.emplace(scene_.lights, scene_.kernel);
  plane_ = light_plane(scene_);
  cameras_.push_back(scene_.camera);
}

LightState IrradianceFieldSnapshot::known_light(const LightState& light) const {
  if (light.kind == LightKind::kFixed) return light;
  LightState known = light;
  const bool far = light.kind == LightKind::kDirectional;
  const std::string wrong = light_refusal(light, far ? LightKind::kDirectional : LightKind::kPoint);
  const auto met = plane_ && wrong.empty() ? plane_->meet(light.position) : std::nullopt;
  if (met) {
    // Lamps on the plane keep their brightness to the last bit.
    const double off = std::abs(plane_->normal.dot(light.position) - plane_->distance);
    if (!far && off <= kOnPlane * plane_->distance) return light;
    const double reference = far ? plane_->distance : light.position.norm();
    known.kind = LightKind::kPoint;
    known.position = *met;
    known.rgb *= static_cast<float>(met->squaredNorm() / (reference * reference));
    return known;
  }
  if (!wrong.empty() || light.kind != scene_.kind)
    throw ConfigError(
        scene_.kind == LightKind::kDirectional
            ? "this irradiance field was built in directional light: give directions, not positions"
            : "this irradiance field was built in the light of near lamps: give positions, not directions");
  if (far) known.position.normalize();
  return known;
}

Eigen::VectorXf IrradianceFieldSnapshot::weights(const LightState& light) const {
  if (light.kind == LightKind::kFixed)
    return Eigen::VectorXf::Constant(field_->lights, 1.0f / static_cast<float>(field_->lights));
  const Eigen::VectorXf kriged = kriging_->weights(light.position);
  const float sum = kriged.cwiseAbs().sum();
  if (sum <= kMostWeight) return kriged;
  const float part = kMostWeight / sum;
  return part * kriged + (1 - part) * weights_by_distance(scene_.lights, light.position);
}

std::vector<LightState> IrradianceFieldSnapshot::lights() const {
  std::vector<LightState> lights;
  for (Eigen::Index i = 0; i < scene_.lights.cols(); ++i)
    lights.push_back({.kind = scene_.kind, .position = scene_.lights.col(i)});
  return lights;
}

ImageF IrradianceFieldSnapshot::picture(const LightState& light) const {
  if (empty()) return ImageF(std::max(1, field_->size.width), std::max(1, field_->size.height), 3);
  const LightState known = known_light(light);
  ImageF picture = relighting_->encoded_picture(weights(known));
  decode_levels(picture);
  if (known.rgb != Eigen::Vector3f::Ones())
    for (std::size_t i = 0; i < picture.size(); ++i) picture.data()[i] *= known.rgb[static_cast<Eigen::Index>(i % 3)];
  return picture;
}

ImageU8 IrradianceFieldSnapshot::screen_picture(const LightState& light) const {
  if (empty()) return to_srgb8(picture(light));
  const LightState known = known_light(light);
  if (known.rgb != Eigen::Vector3f::Ones()) return to_srgb8(picture(light));
  return rounded_levels(relighting_->encoded_picture(weights(known)));
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
  return judge_lights(scene_, *kriging_, *relighting_, tolerance);
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
