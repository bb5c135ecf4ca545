// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>

#include "common/capture/rig_motion.h"
#include "reconstructor/scene/scene_config.h"

namespace sheen {

/// What a scene file or a command line asks to be modelled: a kind of model by its name or "auto", the one that is for
/// what moves between the images. A surface that only the camera moves about, or nothing, gets the first known kind.
class SceneRequest {
 public:
  /// `config`: a scene file, else empty; `model`: a name in place of it (`default_scene`). A file that says "auto" may
  /// have the sections of all kinds; all are checked. Throws ConfigError and FileError as `load_scene_config` does.
  SceneRequest(const std::string& config, const std::string& model);

  bool automatic() const { return automatic_; }
  /// Of a request that is not automatic.
  SceneConfig named() const;
  /// Of one that is.
  SceneConfig chosen_by(const RigMotion& motion) const;

 private:
  std::string file_, text_, model_;
  bool automatic_ = false;
};

/// The names that `--model` takes, for a person: "surface-light-field, ...". "auto" is not among them.
std::string names_of_kinds();

/// What moves although a kind of model takes it to stand still, for a person; empty where nothing does.
std::string motion_warning(const ModelKind& kind, const RigMotion& seen);

}  // namespace sheen
