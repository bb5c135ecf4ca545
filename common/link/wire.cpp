// SPDX-License-Identifier: Apache-2.0
#include "common/link/wire.h"

#include <algorithm>
#include <array>

#include "common/base/crc32c.h"
#include "common/base/errors.h"
#include "common/capture/capture_validation.h"
#include "common/image/image_codec.h"
#include "common/link/proto_io.h"
#include "common/link/wire_messages.h"
#include "proto/capture.pb.h"

namespace sheen {
namespace {

template <typename Range>
void append(const Range& values, auto* field) {
  field->Reserve(static_cast<int>(values.size()));
  for (const auto value : values) field->Add(value);
}

v1::Capture to_proto(const Capture& capture) {
  v1::Capture out;
  out.set_source_session(capture.source_session);
  out.set_sequence(capture.sequence);
  out.set_camera_frame_id(capture.camera_frame_id);
  out.set_name(capture.name);
  out.set_verdict(static_cast<v1::FrameVerdict>(capture.verdict));
  out.set_purpose(static_cast<v1::Purpose>(capture.purpose));
  out.set_calibration_hash(capture.calibration_hash);
  out.set_stage_hash(capture.stage_hash);

  v1::FrameTimes& times = *out.mutable_times();
  times.set_device_ns(capture.times.device_ns);
  times.set_grabbed_ns(capture.times.grabbed_ns);
  times.set_sent_ns(capture.times.sent_ns);
  times.set_received_ns(capture.times.received_ns);

  v1::Camera& camera = *out.mutable_camera();
  camera.set_width(capture.camera.width);
  camera.set_height(capture.camera.height);
  camera.set_fx(capture.camera.fx);
  camera.set_fy(capture.camera.fy);
  camera.set_cx(capture.camera.cx);
  camera.set_cy(capture.camera.cy);
  camera.set_lens(capture.camera.lens == LensModel::kFisheye ? v1::LENS_MODEL_FISHEYE : v1::LENS_MODEL_OPENCV);
  append(capture.camera.distortion, camera.mutable_distortion());

  v1::Image& image = *out.mutable_image();
  image.set_format(static_cast<v1::PixelFormat>(capture.image.format));
  image.set_transfer(static_cast<v1::Transfer>(capture.image.transfer));
  image.set_width(capture.image.width);
  image.set_height(capture.image.height);
  image.set_stride(static_cast<std::uint32_t>(capture.image.stride));
  if (!capture.mask.empty()) {
    out.mutable_mask()->set_width(capture.mask.width());
    out.mutable_mask()->set_height(capture.mask.height());
  }

  v1::Exposure& exposure = *out.mutable_exposure();
  exposure.set_exposure_s(capture.exposure.exposure_s);
  exposure.set_gain_db(capture.exposure.gain_db);
  append(capture.exposure.white_balance, exposure.mutable_white_balance());
  exposure.set_black_level(capture.exposure.black_level);
  exposure.set_locked(capture.exposure.locked);
  exposure.set_config_epoch(capture.exposure.config_epoch);

  if (capture.photometry) {
    v1::Photometry& photometry = *out.mutable_photometry();
    append(capture.photometry->response, photometry.mutable_response());
    append(std::array{capture.photometry->vignette.cx, capture.photometry->vignette.cy},
           photometry.mutable_vignette_centre());
    append(capture.photometry->vignette.k, photometry.mutable_vignette());
    append(capture.photometry->white_balance, photometry.mutable_white_balance());
    photometry.set_saturation(capture.photometry->saturation);
  }

  v1::Pose& pose = *out.mutable_pose();
  pose.set_status(static_cast<v1::PoseStatus>(capture.pose.status));
  append(capture.pose.camera_from_object.rotation.coeffs(), pose.mutable_rotation());
  append(capture.pose.camera_from_object.translation, pose.mutable_translation());
  append(capture.pose.covariance.transpose().reshaped(), pose.mutable_covariance());
  pose.set_reprojection_rms_px(capture.pose.reprojection_rms_px);
  pose.set_blur_px(capture.pose.blur_px);
  pose.set_tags_used(capture.pose.tags_used);

  for (const TagObservation& tag : capture.tags) {
    v1::TagObservation& observation = *out.add_tags();
    observation.set_id(tag.id);
    for (const Eigen::Vector2d& corner : tag.corners) append(corner, observation.mutable_corners());
    observation.set_residual_px(tag.residual_px);
    observation.set_used(tag.used);
  }

  v1::Light& light = *out.mutable_light();
  light.set_kind(static_cast<v1::LightKind>(capture.light.kind));
  append(capture.light.position, light.mutable_position());
  append(capture.light.rgb, light.mutable_rgb());
  return out;
}

/// Rejects values that this version does not know before a cast could fold them into ones that it does.
template <typename Enum>
Enum known_enum(int value, Enum last, const char* field) {
  if (value < 0 || value > static_cast<int>(last))
    throw ProtocolError(std::string(field) + ": unknown value " + std::to_string(value));
  return static_cast<Enum>(value);
}

int bounded(std::uint32_t value, std::uint32_t max, const char* field) {
  if (value > max) throw ProtocolError(std::string(field) + ": " + std::to_string(value) + " is too large");
  return static_cast<int>(value);
}

void copy_exactly(const auto& field, std::size_t count, auto* out, const char* name) {
  if (static_cast<std::size_t>(field.size()) != count)
    throw ProtocolError(std::string(name) + ": has " + std::to_string(field.size()) + " numbers, must have " +
                        std::to_string(count));
  std::copy(field.begin(), field.end(), out);
}

TagObservation from_proto(const v1::TagObservation& in) {
  TagObservation tag;
  tag.id = bounded(in.id(), 1u << 30, "tags.id");
  std::array<double, 8> corners;
  copy_exactly(in.corners(), corners.size(), corners.data(), "tags.corners");
  for (std::size_t k = 0; k < tag.corners.size(); ++k) tag.corners[k] = {corners[2 * k], corners[2 * k + 1]};
  tag.residual_px = in.residual_px();
  tag.used = in.used();
  return tag;
}

PoseEstimate from_proto(const v1::Pose& in) {
  PoseEstimate pose;
  pose.status = known_enum(in.status(), PoseStatus::kInconsistent, "pose.status");
  copy_exactly(in.rotation(), 4, pose.camera_from_object.rotation.coeffs().data(), "pose.rotation");
  copy_exactly(in.translation(), 3, pose.camera_from_object.translation.data(), "pose.translation");
  Eigen::Matrix<double, 6, 6, Eigen::RowMajor> covariance;
  copy_exactly(in.covariance(), 36, covariance.data(), "pose.covariance");
  pose.covariance = covariance;
  pose.reprojection_rms_px = in.reprojection_rms_px();
  pose.blur_px = in.blur_px();
  pose.tags_used = bounded(in.tags_used(), kMaxTags, "pose.tags_used");
  return pose;
}

Camera from_proto(const v1::Camera& in) {
  Camera camera;
  camera.width = bounded(in.width(), 1u << 16, "camera.width");
  camera.height = bounded(in.height(), 1u << 16, "camera.height");
  camera.fx = in.fx();
  camera.fy = in.fy();
  camera.cx = in.cx();
  camera.cy = in.cy();
  if (in.lens() != v1::LENS_MODEL_OPENCV && in.lens() != v1::LENS_MODEL_FISHEYE)
    throw ProtocolError("camera.lens: unknown value " + std::to_string(in.lens()));
  camera.lens = in.lens() == v1::LENS_MODEL_FISHEYE ? LensModel::kFisheye : LensModel::kOpenCv;
  copy_exactly(in.distortion(), camera.distortion.size(), camera.distortion.data(), "camera.distortion");
  return camera;
}

Exposure from_proto(const v1::Exposure& in) {
  Exposure exposure;
  exposure.exposure_s = in.exposure_s();
  exposure.gain_db = in.gain_db();
  copy_exactly(in.white_balance(), 3, exposure.white_balance.data(), "exposure.white_balance");
  exposure.black_level = in.black_level();
  exposure.locked = in.locked();
  exposure.config_epoch = in.config_epoch();
  return exposure;
}

Photometry from_proto(const v1::Photometry& in) {
  Photometry photometry;
  copy_exactly(in.response(), photometry.response.size(), photometry.response.data(), "photometry.response");
  std::array<double, 2> centre;
  copy_exactly(in.vignette_centre(), 2, centre.data(), "photometry.vignette_centre");
  photometry.vignette.cx = centre[0];
  photometry.vignette.cy = centre[1];
  copy_exactly(in.vignette(), 3, photometry.vignette.k.data(), "photometry.vignette");
  copy_exactly(in.white_balance(), 3, photometry.white_balance.data(), "photometry.white_balance");
  photometry.saturation = in.saturation();
  return photometry;
}

LightState from_proto(const v1::Light& in) {
  LightState light;
  light.kind = known_enum(in.kind(), LightKind::kEnvironment, "light.kind");
  copy_exactly(in.position(), 3, light.position.data(), "light.position");
  copy_exactly(in.rgb(), 3, light.rgb.data(), "light.rgb");
  return light;
}

/// Format and sizes; the pixels come from the blob.
RawImage from_proto(const v1::Image& in) {
  RawImage image;
  image.format = known_enum(in.format(), PixelFormat::kRGB32f, "image.format");
  image.transfer = known_enum(in.transfer(), Transfer::kSrgb, "image.transfer");
  image.width = bounded(in.width(), 1u << 16, "image.width");
  image.height = bounded(in.height(), 1u << 16, "image.height");
  image.stride = in.stride();
  return image;
}

/// Everything but the pixels.
Capture from_proto(const v1::Capture& in) {
  Capture capture;
  capture.source_session = in.source_session();
  capture.sequence = in.sequence();
  capture.camera_frame_id = in.camera_frame_id();
  capture.name = in.name();
  capture.times = {in.times().device_ns(), in.times().grabbed_ns(), in.times().sent_ns(), in.times().received_ns()};
  capture.camera = from_proto(in.camera());
  capture.image = from_proto(in.image());
  capture.exposure = from_proto(in.exposure());
  if (in.has_photometry()) capture.photometry = from_proto(in.photometry());
  capture.pose = from_proto(in.pose());
  bounded(in.tags_size(), kMaxTags, "tags");
  for (const v1::TagObservation& tag : in.tags()) capture.tags.push_back(from_proto(tag));
  capture.light = from_proto(in.light());
  capture.verdict = known_enum(in.verdict(), FrameVerdict::kIncomplete, "verdict");
  capture.purpose = known_enum(in.purpose(), Purpose::kHeldOut, "purpose");
  capture.calibration_hash = in.calibration_hash();
  capture.stage_hash = in.stage_hash();
  return capture;
}

void check_envelope(std::span<const std::uint8_t> bytes, MessageType* type) {
  const Envelope envelope = decode_envelope(bytes);
  if (const std::string error = version_error(envelope, "the capture's writer"); !error.empty())
    throw ProtocolError(error);
  if (envelope.type != MessageType::kKeep && envelope.type != MessageType::kLive)
    throw ProtocolError("envelope: message type " + std::to_string(static_cast<int>(envelope.type)) +
                        " is not a capture");
  *type = envelope.type;
}

void check_sequence(const Capture& capture, MessageType type) {
  if (type == MessageType::kKeep && capture.sequence == 0)
    throw ProtocolError("sequence: must be at least 1 for a capture that is kept");
}

}  // namespace

EncodedCapture encode_capture(const Capture& capture, MessageType type, Codec codec) {
  if (codec != Codec::kRaw && codec != Codec::kDeltaZstd) throw ProtocolError("blob.codec: unknown");
  if (const std::string error = validation_error(capture); !error.empty()) throw ProtocolError(error);
  check_sequence(capture, type);
  EncodedCapture out;
  const auto envelope = encode_envelope(type);
  out.envelope.assign(envelope.begin(), envelope.end());
  thread_local PixelPacker packer;
  out.blob = packer.pack(capture.image, capture.mask, codec);
  v1::Capture header = to_proto(capture);
  header.mutable_blob()->set_codec(static_cast<v1::Codec>(codec));
  header.mutable_blob()->set_bytes(out.blob.size());
  header.mutable_blob()->set_crc32c(crc32c(out.blob));
  out.header = serialize(header);
  return out;
}

CaptureLabel decode_label(std::span<const std::uint8_t> envelope, std::span<const std::uint8_t> header) {
  MessageType type;
  check_envelope(envelope, &type);
  const auto message = parse<v1::Capture>(header, kMaxHeaderBytes, "header");
  return {message.source_session(), message.name(), message.sequence()};
}

Capture decode_capture(std::span<const std::uint8_t> envelope, std::span<const std::uint8_t> header,
                       std::span<const std::uint8_t> blob) {
  MessageType type;
  check_envelope(envelope, &type);
  const auto message = parse<v1::Capture>(header, kMaxHeaderBytes, "header");
  Capture capture = from_proto(message);
  check_sequence(capture, type);
  const int mask_width = bounded(message.mask().width(), 1u << 16, "mask.width");
  const int mask_height = bounded(message.mask().height(), 1u << 16, "mask.height");
  if (const std::string error = size_error(capture.image, mask_width, mask_height); !error.empty())
    throw ProtocolError(error);

  const auto codec = known_enum(message.blob().codec(), Codec::kDeltaZstd, "blob.codec");
  if (codec == Codec::kUnspecified) throw ProtocolError("blob.codec: missing");
  if (message.blob().bytes() != blob.size())
    throw ProtocolError("blob.bytes: header says " + std::to_string(message.blob().bytes()) + ", " +
                        std::to_string(blob.size()) + " came");
  if (message.blob().crc32c() != crc32c(blob)) throw ProtocolError("blob.crc32c: the pixels were damaged on the way");
  const std::size_t mask_bytes = static_cast<std::size_t>(mask_width) * mask_height;
  require_unpacked_size(blob, codec, capture.image.stride * capture.image.height + mask_bytes);
  if (mask_width > 0) capture.mask = ImageU8(mask_width, mask_height, 1);
  unpack_pixels(blob, codec, capture.image, capture.mask);

  if (const std::string error = validation_error(capture); !error.empty()) throw ProtocolError(error);
  return capture;
}

}  // namespace sheen
