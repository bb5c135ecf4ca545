// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <filesystem>
#include <memory>
#include <string>
#include <vector>

#include "common/simulation/rig_recording.h"

namespace sheen {

struct CameraServerOptions {
  std::string address =
      "127.0.0.1";  ///< of the loopback interface, which must have it; one camera per address: the port is fixed
  double frame_rate_hz = 0;           ///< 0: the recording's
  std::filesystem::path description;  ///< GenICam XML that the camera gives of itself; empty: Aravis' fake camera
  bool loop = false;                  ///< start again after the last frame; else it is repeated
};

struct SentFrame {
  std::uint64_t camera_frame_id = 0;
  std::size_t rig_index = 0;
};

/// Puts a recording behind a GigE Vision endpoint, indistinguishable from a camera for who connects. All frames are
/// held in memory. The first is sent when acquisition first starts; a client that comes back goes on where the last one
/// stopped. Destruction is like unplugging the camera.
class CameraServer {
 public:
  /// Throws FileError for a frame that is missing or of the wrong size, ConfigError for an address off the loopback
  /// network, DeviceError when the address is in use.
  CameraServer(const RigRecording& recording, const CameraServerOptions& options);
  /// Of a recording that is still rendered; its first `ready` frames, one at least, are there.
  CameraServer(const RigRecording& recording, const CameraServerOptions& options, std::size_t ready);
  ~CameraServer();

  /// By now this many are there. Until then the last of them is sent again and again. Throws FileError.
  void load_until(std::size_t ready);

  /// Which frames have been sent since the last call, in order.
  std::vector<SentFrame> take_sent();
  /// Whether the recording's last frame has been sent at least once.
  bool exhausted() const;

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace sheen
