// SPDX-License-Identifier: Apache-2.0
#include "reconstructor/models/irradiance_field/irradiance_field.h"

#include <algorithm>
#include <cmath>

#include "common/base/errors.h"
#include "common/base/stage_clock.h"
#include "common/image/color.h"
#include "reconstructor/irradiance_field_file/encode/field_encoding.h"
#include "reconstructor/models/irradiance_field/compress.h"
#include "reconstructor/models/irradiance_field/find_terms.h"
#include "reconstructor/models/irradiance_field/light_kernels.h"
#include "reconstructor/radiance/capture_rules.h"
#include "reconstructor/radiance/light_refusal.h"
#include "reconstructor/radiance/radiance_image.h"

namespace sheen {
namespace {

// As far as fewer images cannot say: of a guess.
constexpr double kUnknownError = 0.14;
constexpr std::size_t kFewestForError = 8;
// Fainter terms than this, in grey levels, say nothing of 8-bit images.
constexpr double kLeastTerm = 0.02;
// Mean square of what the steps of the model round away, in grey levels: no picture is predicted better.
constexpr double kRounding = kExactStep * kExactStep / 12;

ImageF encoded_levels(const Capture& capture, const Undistortion& undistortion) {
  ImageF image = undistortion.of(level_radiance(capture, 1));
  for (std::size_t i = 0; i < image.size(); ++i) image.data()[i] /= capture.light.rgb[static_cast<Eigen::Index>(i % 3)];
  srgb_encode_fast({image.data(), image.size()});
  for (std::size_t i = 0; i < image.size(); ++i) image.data()[i] *= 255;
  return image;
}

}  // namespace

IrradianceField::IrradianceField(std::shared_ptr<const Mesh> mesh, const IrradianceFieldOptions& options)
    : mesh_(std::move(mesh)), options_(options) {
  options_.require_valid();
  if (mesh_->vertices.size() != 4 || mesh_->triangles.size() != 2)
    throw ConfigError(
        "irradiance_field: its surface is the picture itself, not a mesh; build it from a list of lights (.lp)");
}

std::string IrradianceField::refusal(const Capture& capture) const {
  if (!capture.pose.usable()) return "no_pose";
  const LightKind kind = images_.empty() ? capture.light.kind : images_.front().light.kind;
  if (std::string error = light_refusal(capture.light, kind); !error.empty()) return error;
  if (!images_.empty() && !same_place(camera_, {capture.camera, capture.pose.camera_from_object}))
    return "other_camera";
  const ImageU8 usable = usable_pixels(capture);
  if (std::any_of(usable.data(), usable.data() + usable.size(), [](std::uint8_t u) { return u == 0; }))
    return "broken_pixels";
  return {};
}

IngestReport IrradianceField::ingest(const Capture& capture) {
  IngestReport report;
  report.reason = refusal(capture);
  if (!report.reason.empty()) return report;
  report.status = IngestStatus::kHeldOut;
  if (is_held_out(capture, options_.hold_out_every)) return report;
  report.status = IngestStatus::kRefused;
  for (const LitImage& image : images_)
    if (same_place(image.light, capture.light)) {
      report.reason = "same_light";
      return report;
    }
  report.status = IngestStatus::kAccepted;
  StageClock clock(report.stage_ms);
  if (images_.empty()) {
    camera_ = {capture.camera, capture.pose.camera_from_object};
    undistortion_ = Undistortion(camera_);
  }
  images_.push_back({capture.source_session, capture.sequence, capture.light, encoded_levels(capture, undistortion_)});
  clock.done("encode");
  report.patches_updated = tile_grid({capture.camera.width, capture.camera.height}).tiles();
  newest_ = nullptr;
  return report;
}

bool IrradianceField::withdraw(const Capture& capture) {
  newest_ = nullptr;
  return std::erase_if(images_, [&](const LitImage& image) {
           return image.source_session == capture.source_session && image.sequence == capture.sequence;
         }) > 0;
}

bool IrradianceField::began_with(const Capture& capture) const {
  return !images_.empty() && images_.front().source_session == capture.source_session &&
         images_.front().sequence == capture.sequence;
}

void IrradianceField::restart(int) {
  images_.clear();
  newest_ = nullptr;
}

std::shared_ptr<const ModelSnapshot> IrradianceField::snapshot() {
  if (newest_) return newest_;
  LitScene scene{.camera = undistortion_.camera()};
  QuantisedField field;
  if (!images_.empty()) {
    scene.kind = images_.front().light.kind;
    scene.lights.resize(3, static_cast<Eigen::Index>(images_.size()));
    std::vector<ImageF> images;
    for (std::size_t i = 0; i < images_.size(); ++i) {
      const Eigen::Vector3d& place = images_[i].light.position;
      scene.lights.col(static_cast<Eigen::Index>(i)) =
          scene.kind == LightKind::kDirectional ? place.normalized() : place;
      images.push_back(images_[i].encoded);
    }
    Eigen::MatrixXd gram;
    const FieldTerms terms = find_terms(images, kLeastTerm, gram);
    scene.kernel = choose_kernel(scene.lights, gram, light_kernels(scene.lights));
    scene.error = images.size() < kFewestForError
                      ? kUnknownError
                      : std::sqrt(mean_leave_one_out(PointKriging(scene.lights, scene.kernel), gram) /
                                      static_cast<double>(tile_grid(terms.size).tiles() * kTilePixels * 3) +
                                  kRounding) /
                            255;
    field = quantise(terms, static_cast<int>(images_.size()), kExactStep);
  }
  newest_ = std::make_shared<IrradianceFieldSnapshot>(mesh_, std::move(scene), std::move(field), ++version_, false);
  return newest_;
}

std::shared_ptr<const Appearance> IrradianceField::constant_colour() const {
  if (images_.empty()) return std::make_shared<FlatPicture>(mesh_, ImageF(1, 1, 3), static_cast<float>(kUnknownError));
  ImageF mean(camera_.camera.width, camera_.camera.height, 3);
  for (const LitImage& image : images_)
    for (std::size_t i = 0; i < mean.size(); ++i)
      mean.data()[i] += srgb_decode(image.encoded.data()[i] / 255) / static_cast<float>(images_.size());
  return std::make_shared<FlatPicture>(mesh_, std::move(mean), static_cast<float>(kUnknownError));
}

ModelFigures IrradianceField::figures() const {
  ModelFigures figures{.images = images_.size()};
  if (images_.empty()) return figures;
  for (const LitImage& image : images_) figures.bytes += image.encoded.size() * sizeof(float);
  const std::size_t tiles = tile_grid({camera_.camera.width, camera_.camera.height}).tiles();
  figures.rank_histogram.assign(3 * images_.size() + 1, 0);
  figures.rank_histogram.back() = tiles;  // until terms are found, each image is one
  figures.bytes_per_patch = static_cast<double>(figures.bytes) / static_cast<double>(tiles);
  return figures;
}

MemoryAccount IrradianceField::memory(const CaptureSize& image) const {
  const auto bytes = static_cast<double>(figures().bytes);
  return {.ingest = image.bytes, .model = bytes, .snapshots = 2 * bytes};
}

}  // namespace sheen
