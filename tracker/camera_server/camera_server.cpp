// SPDX-License-Identifier: Apache-2.0
#include "tracker/camera_server/camera_server.h"

#include <arv.h>

#include <algorithm>
#include <cmath>
#include <cstring>
#include <mutex>
#include <optional>
#include <utility>

#include "common/base/errors.h"
#include "common/base/files.h"
#include "tracker/camera_server/address_claim.h"

namespace sheen {
namespace {

ArvPixelFormat to_aravis(PixelFormat format) {
  switch (format) {
    case PixelFormat::kBayerRG8:
      return ARV_PIXEL_FORMAT_BAYER_RG_8;
    case PixelFormat::kMono8:
      return ARV_PIXEL_FORMAT_MONO_8;
    case PixelFormat::kRGB8:
      return ARV_PIXEL_FORMAT_RGB_8_PACKED;
    default:
      throw ConfigError("the camera server sends BayerRG8, Mono8 or RGB8, not " + std::string(pfnc_name(format)));
  }
}

}  // namespace

struct CameraServer::Impl {
  RigRecording recording;
  std::size_t frame_bytes = 0, frame_rows = 0;
  bool loop = false;
  std::optional<AddressClaim> claim;
  ArvGvFakeCamera* camera = nullptr;

  mutable std::mutex mutex;         // guards everything below
  std::vector<std::string> frames;  ///< the recording's first ones
  std::size_t next = 0;
  bool exhausted = false;
  std::vector<SentFrame> sent;

  ~Impl() {
    if (camera) g_object_unref(camera);
  }
  void load_until(std::size_t ready);
  void start(const CameraServerOptions& options);
  void fill(ArvBuffer* buffer);
};

void CameraServer::Impl::load_until(std::size_t ready) {
  for (std::size_t i = frames.size(); i < ready; ++i) {  // this thread alone adds frames
    const std::filesystem::path& file = recording.frames[i].raw_file;
    std::string bytes = read_file(file);
    if (bytes.size() != frame_bytes)
      throw FileError(file.string(),
                      "has " + std::to_string(bytes.size()) + " bytes, a frame has " + std::to_string(frame_bytes));
    const std::lock_guard lock(mutex);
    frames.push_back(std::move(bytes));
  }
}

void CameraServer::Impl::start(const CameraServerOptions& options) {
  if (!options.address.starts_with("127."))
    throw ConfigError("the simulated camera lives on the loopback network: 127.0.0.1, 127.0.0.2, ... and not on " +
                      options.address);
  const double rate = options.frame_rate_hz > 0 ? options.frame_rate_hz : recording.frame_rate_hz;
  if (!(rate > 0)) throw ConfigError("the frame rate must be positive");
  const ArvPixelFormat format = to_aravis(recording.format);
  claim.emplace(options.address);
  camera = arv_gv_fake_camera_new_full(options.address.c_str(), "SHEEN01",
                                       options.description.empty() ? nullptr : options.description.c_str());
  if (!camera || !arv_gv_fake_camera_is_running(camera))
    throw DeviceError("no GigE Vision camera can be started on " + options.address +
                      ": another one serves there, or no interface has this address (ip addr add " + options.address +
                      "/8 dev lo)");
  ArvFakeCamera* fake = arv_gv_fake_camera_get_fake_camera(camera);
  const auto set = [fake](std::uint32_t address, double value) {
    arv_fake_camera_write_register(fake, address, static_cast<std::uint32_t>(std::lround(value)));
  };
  set(ARV_FAKE_CAMERA_REGISTER_SENSOR_WIDTH, recording.camera.width);
  set(ARV_FAKE_CAMERA_REGISTER_SENSOR_HEIGHT, recording.camera.height);
  set(ARV_FAKE_CAMERA_REGISTER_WIDTH, recording.camera.width);
  set(ARV_FAKE_CAMERA_REGISTER_HEIGHT, recording.camera.height);
  set(ARV_FAKE_CAMERA_REGISTER_PIXEL_FORMAT, format);
  set(ARV_FAKE_CAMERA_REGISTER_ACQUISITION_FRAME_PERIOD_US, 1e6 / rate);
  if (recording.exposure.exposure_s > 0)
    set(ARV_FAKE_CAMERA_REGISTER_EXPOSURE_TIME_US, 1e6 * recording.exposure.exposure_s);
  arv_fake_camera_set_fill_pattern(
      fake,
      [](ArvBuffer* buffer, void* self, guint32, guint32, ArvPixelFormat) { static_cast<Impl*>(self)->fill(buffer); },
      this);
}

/// Runs on the thread that also answers the control channel: a copy and no more.
void CameraServer::Impl::fill(ArvBuffer* buffer) {
  const std::lock_guard lock(mutex);
  std::size_t unknown_size = 0;
  auto* data = static_cast<std::uint8_t*>(const_cast<void*>(arv_buffer_get_data(buffer, &unknown_size)));
  if (!data) return;
  // A client may ask for a smaller region: what a sensor would read out of its upper left.
  const std::size_t width = arv_buffer_get_image_width(buffer), rows = arv_buffer_get_image_height(buffer);
  const std::size_t stride = frame_bytes / frame_rows;
  const std::size_t out_stride = width * ARV_PIXEL_FORMAT_BIT_PER_PIXEL(arv_buffer_get_image_pixel_format(buffer)) / 8;
  for (std::size_t y = 0; y < std::min(rows, frame_rows); ++y)
    std::memcpy(data + y * out_stride, frames[next].data() + y * stride, std::min(stride, out_stride));
  sent.push_back({arv_buffer_get_frame_id(buffer), next});
  if (next + 1 < frames.size()) {
    ++next;
  } else if (frames.size() == recording.frames.size()) {
    exhausted = true;
    if (loop) next = 0;
  }
}

CameraServer::CameraServer(const RigRecording& recording, const CameraServerOptions& options)
    : CameraServer(recording, options, recording.frames.size()) {}

CameraServer::CameraServer(const RigRecording& recording, const CameraServerOptions& options, std::size_t ready)
    : impl_(std::make_unique<Impl>()) {
  if (ready == 0) throw FileError(recording.folder.string(), "holds no frame to send");
  impl_->recording = recording;
  impl_->frame_bytes =
      std::size_t(recording.camera.width) * recording.camera.height * bytes_per_pixel(recording.format);
  impl_->frame_rows = recording.camera.height;
  impl_->loop = options.loop;
  impl_->load_until(ready);
  impl_->start(options);
}

CameraServer::~CameraServer() = default;

void CameraServer::load_until(std::size_t ready) {
  impl_->load_until(ready);
}

std::vector<SentFrame> CameraServer::take_sent() {
  const std::lock_guard lock(impl_->mutex);
  return std::exchange(impl_->sent, {});
}

bool CameraServer::exhausted() const {
  const std::lock_guard lock(impl_->mutex);
  return impl_->exhausted;
}

}  // namespace sheen
