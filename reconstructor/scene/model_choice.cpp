// SPDX-License-Identifier: Apache-2.0
#include "reconstructor/scene/model_choice.h"

#include <algorithm>

#include "common/base/files.h"
#include "reconstructor/models/model_registry.h"

namespace sheen {
namespace {

constexpr const char* kAuto = "auto";

const ModelKind& kind_for(const RigMotion& motion) {
  const auto kinds = model_kinds();
  const auto fits =
      std::find_if(kinds.begin(), kinds.end(), [&](const ModelKind* kind) { return kind->motion() == motion; });
  return fits == kinds.end() ? *kinds.front() : **fits;
}

}  // namespace

SceneRequest::SceneRequest(const std::string& config, const std::string& model) : file_(config), model_(model) {
  if (file_.empty()) {
    automatic_ = model_ == kAuto;
    if (!automatic_) default_scene(model_);
    return;
  }
  text_ = read_file(file_);
  automatic_ = scene_chooses_model(text_, file_);
  if (!automatic_) return;
  for (const ModelKind* kind : model_kinds()) parse_scene_config(text_, file_, kind);
}

SceneConfig SceneRequest::named() const {
  return file_.empty() ? default_scene(model_) : parse_scene_config(text_, file_);
}

SceneConfig SceneRequest::chosen_by(const RigMotion& motion) const {
  const ModelKind& kind = kind_for(motion);
  return file_.empty() ? default_scene(kind.name()) : parse_scene_config(text_, file_, &kind);
}

std::string names_of_kinds() {
  std::string names;
  for (const ModelKind* kind : model_kinds()) names += (names.empty() ? "" : ", ") + std::string(kind->name());
  std::replace(names.begin(), names.end(), '_', '-');
  return names;
}

std::string motion_warning(const ModelKind& kind, const RigMotion& seen) {
  const RigMotion is = kind.motion();
  const bool camera = is.camera == Motion::kStill && seen.camera == Motion::kMoves;
  if (!camera && !(is.light == Motion::kStill && seen.light == Motion::kMoves)) return {};
  return std::string("the ") + (camera ? "camera" : "light") + " moves, but this model (" + kind.title() +
         ") takes it to stand still; `sheen-reconstructor build SESSION --model auto` chooses by what has moved";
}

}  // namespace sheen
