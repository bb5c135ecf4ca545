// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "tracker/sources/camera_features.h"
#include "tracker/sources/source_uri.h"

namespace sheen {

/// What of a camera decides what a grey level means.
enum class CameraSetting { kExposure, kGain, kBlackLevel, kWhiteBalance, kPixelFormat };

/// The GenICam feature that a camera has for a setting, or why it has none.
struct CameraFeature {
  std::string name;     ///< empty: none
  std::string absence;  ///< the names that were looked for, a sentence for a person
};
/// `has`: whether the camera's description has a feature of this name. The names are those of the Standard Features
/// Naming Convention and the ones that vendors used before it.
CameraFeature find_feature(CameraSetting setting, const std::function<bool(const std::string&)>& has);

/// Switches off what changes by itself (exposure, gain, white balance, black level, gamma), sets what is asked for, and
/// reads all of it back. A feature that the camera lacks is listed only where a value was asked for it.
std::vector<LockedFeature> lock_camera(_ArvCamera* camera, const SourceSettings& settings);

/// What the camera says of a setting that is a number (us, dB); nothing where it has none or does not say.
std::optional<double> setting_of(_ArvCamera* camera, CameraSetting setting);

/// Of those that do not hold: "Gain: asked 3.7, got 3; ..."; empty when all do.
std::string lock_failures(const std::vector<LockedFeature>& features);

}  // namespace sheen
