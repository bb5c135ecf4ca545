// SPDX-License-Identifier: Apache-2.0
#include "tracker/open_rig.h"

#include <algorithm>
#include <utility>

#include "common/base/errors.h"
#include "tracker/lights/frame_lights.h"
#include "tracker/sources/source_uri.h"
#include "tracker/sources/stream_address.h"

namespace sheen {
namespace {

std::optional<Rig> rig_of(const CameraConfig& config, const std::optional<StageLayout>& stage) {
  if (config.light && (!config.camera || !stage))
    throw ConfigError("[light] is in the frame of the stage: the configuration must name [camera] and [stage], too");
  if (!config.camera || !stage) return std::nullopt;
  Rig rig{.camera = *config.camera, .stage = *stage, .still = config.still, .lights = {}};
  rig.photometry = config.photometry;
  if (config.light) rig.lights = make_frame_lights(*config.light);
  if (config.light && config.light->tag && rig.stage.find(*config.light->tag))
    throw ConfigError("light.tag: " + std::to_string(*config.light->tag) +
                      " is a tag of the stage; the lamp's must be another");
  return rig;
}

TrackedCamera open_camera(const CameraConfig& config, const std::optional<StageLayout>& stage, std::uint64_t frames) {
  try {
    TrackedCamera camera{.name = config.name, .source = {}, .rig = rig_of(config, stage), .options = {}};
    const SourceUri uri = parse_source_uri(*config.source_uri);
    camera.source = open_source(uri, config.source);
    camera.options = {.gate = config.gate, .max_frames = frames};
    if (is_stream_address(uri.target)) camera.options.queue = 1;  // its newest frame waits where it is read
    camera.options.camera_name = config.name;
    const bool replays = !camera.source->session().empty();
    if (config.light && replays)
      throw ConfigError("[light] is for a camera or a video: this source's images come with their lights");
    if (!config.name.empty() && replays)
      throw ConfigError(without_password(*config.source_uri) +
                        " is no camera but a data set, which runs alone: --source");
    return camera;
  } catch (const ConfigError& error) {
    if (config.name.empty()) throw;
    throw ConfigError("camera " + config.name + ": " + error.what());
  } catch (const DeviceError& error) {
    if (config.name.empty()) throw;
    throw DeviceError("camera " + config.name + ": " + error.what());
  }
}

}  // namespace

std::vector<TrackedCamera> open_cameras(const RigConfig& config, std::uint64_t frames) {
  std::optional<StageLayout> stage;
  if (config.stage_file) stage = load_stage(*config.stage_file);
  if (config.cameras.size() > 1 && !stage)
    throw ConfigError("several cameras need a [stage] with the file of the tags that all of them see");
  std::vector<TrackedCamera> cameras;
  for (const CameraConfig& camera : config.cameras) cameras.push_back(open_camera(camera, stage, frames));
  return cameras;
}

RigMotion motion_of(const std::vector<TrackedCamera>& cameras) {
  const TrackedCamera& first = cameras.front();
  if (!first.source->session().empty() || !first.rig) return first.source->motion();
  const bool lit = std::any_of(cameras.begin(), cameras.end(), [](const auto& camera) { return camera.rig->lights; });
  return {.camera = cameras.size() == 1 && first.rig->still ? Motion::kStill : Motion::kMoves,
          .light = lit ? Motion::kMoves : Motion::kStill};
}

}  // namespace sheen
