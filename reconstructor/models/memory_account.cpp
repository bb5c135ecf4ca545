// SPDX-License-Identifier: Apache-2.0
#include "reconstructor/models/memory_account.h"

#include <algorithm>

namespace sheen {

MemoryAccount MemoryAccount::unshown() const {
  MemoryAccount account = *this;
  account.snapshots = std::max(0.0, snapshots / 2 - model);
  account.shown = false;
  return account;
}

std::map<std::string, double> MemoryAccount::parts() const {
  return {{"mesh", mesh},           {"ray_scene", ray_scene}, {"ingest", ingest}, {"model", model},
          {"snapshots", snapshots}, {"held_out", held_out},   {"probe", probe},   {"overhead", overhead()}};
}

CaptureSize size_of(const Capture& capture) {
  return {static_cast<double>(capture.image.width) * capture.image.height,
          static_cast<double>(capture.image.bytes.size() + capture.mask.size()), !capture.camera.is_pinhole()};
}

}  // namespace sheen
