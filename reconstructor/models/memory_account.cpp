// SPDX-License-Identifier: Apache-2.0
#include "reconstructor/models/memory_account.h"

namespace sheen {

std::map<std::string, double> MemoryAccount::parts() const {
  return {{"mesh", mesh},           {"ray_scene", ray_scene}, {"ingest", ingest}, {"model", model},
          {"snapshots", snapshots}, {"held_out", held_out},   {"probe", probe},   {"overhead", overhead()}};
}

CaptureSize size_of(const Capture& capture) {
  return {static_cast<double>(capture.image.width) * capture.image.height,
          static_cast<double>(capture.image.bytes.size() + capture.mask.size()), !capture.camera.is_pinhole()};
}

}  // namespace sheen
