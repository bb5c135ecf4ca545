// SPDX-License-Identifier: Apache-2.0
#include "tracker/sources/aravis_camera.h"

#include <arv.h>

#include <algorithm>
#include <array>
#include <atomic>

#include "common/base/clock.h"
#include "common/base/errors.h"
#include "common/base/format.h"

namespace sheen {
namespace {

constexpr int kBuffers = 16;  ///< half a second at 30 frames/s

struct Format {
  PixelFormat format;
  ArvPixelFormat aravis;
};
/// In the order of preference: a mosaic is what the sensor saw, at a third of the bytes.
constexpr std::array kFormats{Format{PixelFormat::kBayerRG8, ARV_PIXEL_FORMAT_BAYER_RG_8},
                              Format{PixelFormat::kBayerGR8, ARV_PIXEL_FORMAT_BAYER_GR_8},
                              Format{PixelFormat::kBayerGB8, ARV_PIXEL_FORMAT_BAYER_GB_8},
                              Format{PixelFormat::kBayerBG8, ARV_PIXEL_FORMAT_BAYER_BG_8},
                              Format{PixelFormat::kRGB8, ARV_PIXEL_FORMAT_RGB_8_PACKED},
                              Format{PixelFormat::kMono8, ARV_PIXEL_FORMAT_MONO_8}};

PixelFormat from_aravis(ArvPixelFormat format) {
  const auto it = std::ranges::find(kFormats, format, &Format::aravis);
  return it == kFormats.end() ? PixelFormat::kUnspecified : it->format;
}

std::string name_of(ArvPixelFormat format) {
  const PixelFormat known = from_aravis(format);
  return known == PixelFormat::kUnspecified ? sheen::format("format 0x%08x", unsigned(format))
                                            : std::string(pfnc_name(known));
}

std::string offered_names(const gint64* formats, guint count) {
  std::string names;
  for (guint i = 0; i < count; ++i) names += (i ? ", " : "") + name_of(ArvPixelFormat(formats[i]));
  return names;
}

struct Unref {
  void operator()(void* object) const { g_object_unref(object); }
};

/// Collects the GError of a call and turns it into an exception that names the setting.
class Call {
 public:
  Call(const std::string& camera, const char* what) : camera_(camera), what_(what) {}
  ~Call() { g_clear_error(&error_); }
  Call(const Call&) = delete;
  Call& operator=(const Call&) = delete;
  operator GError**() { return &error_; }
  bool failed() const { return error_ != nullptr; }
  void require() const {
    if (error_) throw DeviceError("camera " + camera_ + ": " + what_ + ": " + error_->message);
  }

 private:
  const std::string& camera_;
  const char* what_;
  GError* error_ = nullptr;
};

bool is_loopback(GSocketAddress* address) {
  return address && G_IS_INET_SOCKET_ADDRESS(address) &&
         g_inet_address_get_is_loopback(g_inet_socket_address_get_address(G_INET_SOCKET_ADDRESS(address)));
}

/// "127.0.0.1"
std::string address_of(GSocketAddress* address) {
  const std::unique_ptr<char, void (*)(void*)> text(
      g_inet_address_to_string(g_inet_socket_address_get_address(G_INET_SOCKET_ADDRESS(address))), g_free);
  return text.get();
}

void on_control_lost(ArvDevice*, std::atomic<bool>* lost) {
  *lost = true;
}

}  // namespace

struct AravisCamera::Impl {
  std::string id;
  std::unique_ptr<ArvCamera, Unref> camera;
  std::unique_ptr<ArvStream, Unref> stream;
  std::atomic<bool> lost = false;
  gulong lost_handler = 0;
  Exposure exposure;
  std::vector<LockedFeature> locks;
  std::vector<ResetFeature> resets;
  double frame_rate_hz = 0;
  RawImage delivered;  ///< size and format of what it delivers, without pixels; size 0: it does not tell
  std::uint64_t foreign = 0;

  void open();
  void connect(const std::string& name);
  bool reached_from_afar() const;
  void set_up(const SourceSettings& settings);
  void reset();
  void set_region(const SourceSettings& settings);
  void set_frame_rate(double asked_hz);
  void require_holds(const std::vector<LockedFeature>& features) const;
  [[noreturn]] void refuse_size(int width, int height, const SourceSettings& settings) const;
  void choose_pixel_format(const SourceSettings& settings);
  void lock_exposure(const SourceSettings& settings);
  bool is_own(const RawImage& image) const;
};

AravisCamera::AravisCamera(const std::string& id, const SourceSettings& settings) : impl_(std::make_unique<Impl>()) {
  impl_->id = id;
  impl_->open();
  impl_->set_up(settings);
}

AravisCamera::~AravisCamera() {
  g_signal_handler_disconnect(arv_camera_get_device(impl_->camera.get()), impl_->lost_handler);
  if (impl_->stream && !impl_->lost) arv_camera_stop_acquisition(impl_->camera.get(), nullptr);
}

void AravisCamera::Impl::open() {
  connect(id);
  // One of this machine, found by its name over a network's interface, would send its images to that network.
  if (reached_from_afar())
    connect(address_of(arv_gv_device_get_device_address(ARV_GV_DEVICE(arv_camera_get_device(camera.get())))));
  ArvDevice* device = arv_camera_get_device(camera.get());
  if (ARV_IS_GV_DEVICE(device) && !arv_gv_device_is_controller(ARV_GV_DEVICE(device)))
    throw DeviceError("camera " + id + " is controlled by another program; end it, or wait some seconds if it crashed");
  lost_handler = g_signal_connect(device, "control-lost", G_CALLBACK(on_control_lost), &lost);
}

void AravisCamera::Impl::connect(const std::string& name) {
  camera.reset();  // a camera has one controller
  GError* error = nullptr;
  camera.reset(arv_camera_new(name.c_str(), &error));
  const std::string reason = error ? error->message : "";
  g_clear_error(&error);
  if (!camera)
    throw DeviceError("camera " + id + " does not answer" + (reason.empty() ? "" : " (" + reason + ")") +
                      "; `sheen-tracker cameras` lists those that do");
}

bool AravisCamera::Impl::reached_from_afar() const {
  ArvDevice* const device = arv_camera_get_device(camera.get());
  if (!ARV_IS_GV_DEVICE(device)) return false;
  return is_loopback(arv_gv_device_get_device_address(ARV_GV_DEVICE(device))) &&
         !is_loopback(arv_gv_device_get_interface_address(ARV_GV_DEVICE(device)));
}

void AravisCamera::Impl::set_up(const SourceSettings& settings) {
  reset();
  set_region(settings);
  choose_pixel_format(settings);
  set_frame_rate(settings.frame_rate_hz);
  lock_exposure(settings);
  if (arv_camera_is_gv_device(camera.get())) {
    Call call(id, "packet size");
    arv_camera_gv_auto_packet_size(camera.get(), call);
    call.require();
  }
}

/// A program that crashed may have left the camera running, and a running one takes no settings.
void AravisCamera::Impl::reset() {
  arv_camera_stop_acquisition(camera.get(), nullptr);
  resets = reset_camera(camera.get());
  std::vector<LockedFeature> features;
  for (const ResetFeature& feature : resets) features.push_back(feature.now);
  require_holds(features);
}

/// The upper left of the sensor, or all of it where no size is asked for: where a region lies is part of a calibration.
void AravisCamera::Impl::set_region(const SourceSettings& settings) {
  Call call(id, "region");
  int sensor_width = 0, sensor_height = 0;
  arv_camera_get_sensor_size(camera.get(), &sensor_width, &sensor_height, call);
  int x = 0, y = 0, width = 0, height = 0;
  if (!call.failed()) arv_camera_get_region(camera.get(), &x, &y, &width, &height, call);
  if (settings.width == 0 && (call.failed() || (x == 0 && y == 0))) return;
  call.require();
  const int asked_width = settings.width > 0 ? settings.width : sensor_width;
  const int asked_height = settings.width > 0 ? settings.height : sensor_height;
  if (asked_width > sensor_width || asked_height > sensor_height) refuse_size(sensor_width, sensor_height, settings);
  arv_camera_set_region(camera.get(), 0, 0, asked_width, asked_height, call);
  call.require();
  if (x != 0 || y != 0)
    resets.push_back({{"region", "", format("%d x %d at 0, 0", asked_width, asked_height), true},
                      format("%d x %d at %d, %d", width, height, x, y)});
  arv_camera_get_region(camera.get(), &x, &y, &width, &height, call);
  call.require();
  if (settings.width > 0 && (width != asked_width || height != asked_height)) refuse_size(width, height, settings);
}

void AravisCamera::Impl::set_frame_rate(double asked_hz) {
  if (asked_hz > 0) {
    Call call(id, "frame rate");
    arv_camera_set_frame_rate(camera.get(), asked_hz, call);
    const CameraFeatures features(camera.get());
    const bool set = call.failed() && (features.set_number("AcquisitionFrameRate", asked_hz, 0.5).holds ||
                                       features.set_number("AcquisitionFrameRateAbs", asked_hz, 0.5).holds);
    if (!set) call.require();
  }
  Call rate(id, "frame rate");
  frame_rate_hz = arv_camera_get_frame_rate(camera.get(), rate);
  if (rate.failed()) frame_rate_hz = asked_hz;
}

void AravisCamera::Impl::require_holds(const std::vector<LockedFeature>& features) const {
  if (const std::string failures = lock_failures(features); !failures.empty())
    throw DeviceError("camera " + id + " does not stay as it is set: " + failures);
}

void AravisCamera::Impl::refuse_size(int width, int height, const SourceSettings& settings) const {
  throw DeviceError("camera " + id + " delivers " + std::to_string(width) + " x " + std::to_string(height) +
                    " pixels, but the configuration's [camera] is " + std::to_string(settings.width) + " x " +
                    std::to_string(settings.height));
}

void AravisCamera::Impl::choose_pixel_format(const SourceSettings& settings) {
  Call call(id, "pixel format");
  guint count = 0;
  const std::unique_ptr<gint64, void (*)(void*)> offered(
      arv_camera_dup_available_pixel_formats(camera.get(), &count, call), g_free);
  call.require();
  for (const Format& format : kFormats) {
    if (!settings.pixel_format.empty() && pfnc_name(format.format) != settings.pixel_format) continue;
    if (std::find(offered.get(), offered.get() + count, gint64(format.aravis)) == offered.get() + count) continue;
    arv_camera_set_pixel_format(camera.get(), format.aravis, call);
    call.require();
    const ArvPixelFormat got = arv_camera_get_pixel_format(camera.get(), call);
    call.require();
    if (got != format.aravis)
      throw DeviceError("camera " + id + " does not stay as it is set: PixelFormat: asked " +
                        std::string(pfnc_name(format.format)) + ", got " + name_of(got));
    return;
  }
  if (!settings.pixel_format.empty())
    throw DeviceError("camera " + id + ": PixelFormat: asked " + settings.pixel_format + ", the camera offers " +
                      offered_names(offered.get(), count));
  throw DeviceError("camera " + id + " offers no 8-bit Bayer, RGB8 or Mono8 pixel format");
}

void AravisCamera::Impl::lock_exposure(const SourceSettings& settings) {
  ArvCamera* c = camera.get();
  locks = lock_camera(c, settings);
  require_holds(locks);
  const std::optional<double> exposure_us = setting_of(c, CameraSetting::kExposure);
  const std::optional<double> gain_db = setting_of(c, CameraSetting::kGain);
  exposure = {.exposure_s = exposure_us.value_or(0) * 1e-6, .gain_db = gain_db.value_or(0)};
  exposure.locked = exposure_us || !arv_camera_is_exposure_time_available(c, nullptr);
}

bool AravisCamera::Impl::is_own(const RawImage& image) const {
  return delivered.width == 0 ||
         (image.width == delivered.width && image.height == delivered.height && image.format == delivered.format);
}

void AravisCamera::start() {
  ArvCamera* const camera = impl_->camera.get();
  Call call(impl_->id, "stream");
  int x = 0, y = 0;
  arv_camera_get_region(camera, &x, &y, &impl_->delivered.width, &impl_->delivered.height, nullptr);
  impl_->delivered.format = from_aravis(arv_camera_get_pixel_format(camera, call));
  call.require();
  impl_->stream.reset(arv_camera_create_stream(camera, nullptr, nullptr, call));
  call.require();
  const guint payload = arv_camera_get_payload(camera, call);
  call.require();
  for (int i = 0; i < kBuffers; ++i) arv_stream_push_buffer(impl_->stream.get(), arv_buffer_new_allocate(payload));
  arv_camera_start_acquisition(camera, call);
  call.require();
}

std::optional<Frame> AravisCamera::grab(std::chrono::milliseconds timeout) {
  ArvBuffer* buffer = arv_stream_timeout_pop_buffer(impl_->stream.get(), std::max<guint64>(timeout.count(), 1) * 1000);
  if (!buffer) return std::nullopt;
  const ArvBufferStatus status = arv_buffer_get_status(buffer);
  std::size_t size = 0;
  const auto* data = static_cast<const std::uint8_t*>(arv_buffer_get_data(buffer, &size));
  Frame frame;
  frame.times.grabbed_ns = steady_now_ns();
  frame.complete = status == ARV_BUFFER_STATUS_SUCCESS;
  frame.camera_frame_id = arv_buffer_get_frame_id(buffer);
  frame.exposure = impl_->exposure;
  const bool has_image = status == ARV_BUFFER_STATUS_SUCCESS || status == ARV_BUFFER_STATUS_MISSING_PACKETS ||
                         status == ARV_BUFFER_STATUS_TIMEOUT;
  if (has_image && data) {
    frame.times.device_ns = static_cast<std::int64_t>(arv_buffer_get_timestamp(buffer));
    frame.image.format = from_aravis(arv_buffer_get_image_pixel_format(buffer));
    frame.image.width = arv_buffer_get_image_width(buffer);
    frame.image.height = arv_buffer_get_image_height(buffer);
    frame.image.stride = frame.image.width * bytes_per_pixel(frame.image.format);
    const std::size_t bytes = frame.image.stride * frame.image.height;
    if (bytes > 0 && bytes <= size) frame.image.bytes.assign(data, data + bytes);
  }
  arv_stream_push_buffer(impl_->stream.get(), buffer);
  if (frame.complete && !impl_->is_own(frame.image)) {
    ++impl_->foreign;
    return std::nullopt;
  }
  if (status == ARV_BUFFER_STATUS_CLEARED || status == ARV_BUFFER_STATUS_ABORTED) return std::nullopt;
  frame.complete = frame.complete && !frame.image.bytes.empty();
  return frame;
}

bool AravisCamera::control_lost() const {
  return impl_->lost;
}
const std::vector<LockedFeature>& AravisCamera::locks() const {
  return impl_->locks;
}
std::string AravisCamera::changes() const {
  return reset_text(impl_->resets);
}
const Exposure& AravisCamera::exposure() const {
  return impl_->exposure;
}
double AravisCamera::frame_rate_hz() const {
  return impl_->frame_rate_hz;
}

std::uint64_t AravisCamera::underruns() const {
  if (!impl_->stream) return 0;
  guint64 completed = 0, failures = 0, underruns = 0;
  arv_stream_get_statistics(impl_->stream.get(), &completed, &failures, &underruns);
  return underruns;
}

std::uint64_t AravisCamera::missing_packets() const {
  if (!impl_->stream || !ARV_IS_GV_STREAM(impl_->stream.get())) return 0;
  guint64 resent = 0, missing = 0;
  arv_gv_stream_get_statistics(ARV_GV_STREAM(impl_->stream.get()), &resent, &missing);
  return missing;
}

std::uint64_t AravisCamera::foreign() const {
  return impl_->foreign;
}

}  // namespace sheen
