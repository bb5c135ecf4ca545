// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <chrono>
#include <cstdint>
#include <optional>
#include <string>

#include "common/capture/capture.h"
#include "common/capture/rig_motion.h"
#include "common/link/status.h"

namespace sheen {

/// One image as a source delivers it, before anything is known about where it was taken from.
struct Frame {
  std::uint64_t camera_frame_id = 0;
  FrameTimes times;  ///< device_ns and grabbed_ns
  RawImage image;
  Exposure exposure;
  bool complete = true;  ///< false: packets were lost on the camera link, part of the image is missing
  /// Set by sources whose images come with their pose: everything that is known. `image` is then empty.
  std::optional<Capture> given;
};

struct SourceStats {
  std::uint64_t frames = 0;           ///< handed out, incomplete ones included
  std::uint64_t incomplete = 0;       ///< of these, with packets missing
  std::uint64_t missed = 0;           ///< gaps in the camera's frame ids: taken, but never seen here
  std::uint64_t underruns = 0;        ///< of these, because no buffer was free
  std::uint64_t missing_packets = 0;  ///< as the driver counts them
  std::uint64_t foreign = 0;          ///< images of another size or format than the camera's: another sent them here
  std::uint64_t reopened = 0;         ///< times the camera came back after it had vanished; its ids then begin again
  std::uint64_t first_frame_id = 0, last_frame_id = 0;  ///< of a camera: handed out first and last
};

/// Where frames come from. Constructors throw DeviceError, FileError or ConfigError. From then on what may pass (a
/// cable that is loose) is told by `state`; what ends the source before its time is thrown by `next`, naming the frame.
/// `next` is called from one thread, everything else from any.
class FrameSource {
 public:
  virtual ~FrameSource() = default;

  /// The next frame; nothing when none came within `timeout` or the source has ended.
  virtual std::optional<Frame> next(std::chrono::milliseconds timeout) = 0;
  virtual SourceState state() const = 0;
  /// One line for a person: what the source is doing, or what went wrong with it.
  virtual std::string message() const = 0;
  virtual SourceStats stats() const = 0;
  /// Whether frames come whether or not anybody takes them (a camera), or wait to be taken (files).
  virtual bool live() const = 0;
  /// Names the source session where running the same source again gives the same captures; else empty.
  virtual std::string session() const { return {}; }
  /// How many captures such a source has.
  virtual std::uint64_t session_size() const { return 0; }

  /// What changes between its frames, as far as the source itself knows.
  virtual RigMotion motion() const { return {}; }

  /// Whether its images were compressed with losses, which moves edges by parts of a pixel.
  virtual bool compressed() const { return false; }

  /// What a person should know about the source, a line each; empty: nothing.
  virtual std::string remarks() const { return {}; }

  bool ended() const { return state() == SourceState::kEnded; }
};

}  // namespace sheen
