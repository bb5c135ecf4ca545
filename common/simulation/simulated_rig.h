// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <filesystem>
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "common/image/image.h"
#include "common/image/raw_image.h"
#include "common/simulation/camera_path.h"
#include "common/simulation/path_tracer.h"
#include "common/simulation/rig_recording.h"
#include "common/simulation/sensor.h"
#include "common/stage/stage_layout.h"

namespace sheen {

struct SimulationOptions {
  std::string object = "demo";  ///< see `make_test_object`
  int frames = 130;
  int width = 1024, height = 768;  ///< pixels
  std::uint64_t seed = 1;          ///< of path and noise
  bool truth = false;              ///< also write each frame's linear radiance as EXR
  double frame_rate_hz = 12;       ///< at which the recording is to be served
  /// A lamp moves so in the dimmed studio (`light_path`); empty: the studio alone, which does not change.
  std::string light_path;
  /// It does not move: all frames are from one of its places. Its lens bends nothing: a picture can be a model's
  /// surface.
  bool still_camera = false;
  BakeOptions bake;  ///< coarser ones make small rigs for tests quick
};

/// One frame of the rig with its truth. Radiance is as the lens lays it on the sensor, in units of the white level,
/// before noise and clipping.
struct SimulatedFrame {
  Rigid3 camera_from_object;  ///< at the middle of the exposure
  double blur_px = 0;         ///< `SimulatedRig::blur_px`
  LightState light;           ///< the lamp's, exact; fixed without one
  ImageF radiance;
  ImageU8 mask;  ///< 255 on the object's silhouette, at the middle of the exposure
  RawImage raw;  ///< BayerRG8, linear: what the camera sends
};

/// Object, stage, lights, camera and its path, all generated. Making one bakes the light (seconds); `frame` renders.
/// Throws ConfigError.
class SimulatedRig {
 public:
  explicit SimulatedRig(const SimulationOptions& options);

  std::size_t size() const { return path_.size(); }
  SimulatedFrame frame(std::size_t index) const;
  double blur_px(std::size_t index) const;  ///< streak of the object's centre

  const SimulationOptions& options() const { return options_; }
  const StageLayout& stage() const { return stage_; }
  const TestObject& object() const { return tracer_.scene().object; }
  const PathTracer& tracer() const { return tracer_; }
  const Camera& camera() const { return lens_.camera(); }
  const std::vector<CameraStation>& path() const { return path_; }
  const std::vector<LightState>& lights() const { return lights_; }  ///< per frame; empty without a lamp

 private:
  double meter() const;
  RenderedView blurred(const CameraStation& station, std::size_t index) const;
  RenderOptions lit(RenderOptions options, std::size_t index) const;

  SimulationOptions options_;
  StageLayout stage_;
  PathTracer tracer_;
  LensRays lens_;
  std::vector<CameraStation> path_;
  std::vector<LightState> lights_;
  double white_level_;
};

/// Called after each frame: the first `done` of `total` are there. Any thread, one at a time. What it throws ends the
/// rendering.
using RenderProgress = std::function<void(int done, int total)>;

/// What `write_recording` makes: all of it is known before a frame is rendered.
RigRecording planned_recording(const SimulatedRig& rig, const std::filesystem::path& folder);

/// Renders the rig into a folder as a recording and a dataset (see `RigRecording`), with `rig.toml` for the tracker.
/// `rig.json` is written last: a folder that has it is complete. Every 8th sharp frame is marked as held out; frames
/// with motion blur are in the recording and not in `transforms.json`. Throws FileError.
RigRecording write_recording(const SimulatedRig& rig, const std::filesystem::path& folder,
                             const RenderProgress& progress = {});

/// The folder's recording when it is complete and was rendered from these options.
std::optional<RigRecording> finished_recording(const SimulationOptions& options, const std::filesystem::path& folder);

/// That, else renders it.
struct CachedRecording {
  RigRecording recording;
  bool rendered = false;  ///< false: it was there
};
CachedRecording cached_recording(const SimulationOptions& options, const std::filesystem::path& folder,
                                 const RenderProgress& progress = {});

}  // namespace sheen
