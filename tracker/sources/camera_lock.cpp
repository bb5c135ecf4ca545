// SPDX-License-Identifier: Apache-2.0
#include "tracker/sources/camera_lock.h"

#include <arv.h>

#include <array>

#include "common/base/format.h"

namespace sheen {
namespace {

constexpr double kExposureStep_us = 20;  ///< a line of a slow sensor
constexpr double kGainStep_dB = 0.15;
constexpr double kRatioStep = 0.01;

/// What changes by itself, and the value that stops it.
struct Switch {
  const char* feature;
  const char* off;
};
constexpr std::array kSwitches{Switch{"ExposureAuto", "Off"}, Switch{"GainAuto", "Off"},
                               Switch{"BalanceWhiteAuto", "Off"}, Switch{"BlackLevelAuto", "Off"}};

const std::vector<std::string>& names_of(CameraSetting setting) {
  static const std::vector<std::string> exposure{"ExposureTime", "ExposureTimeAbs", "ExposureTimeRaw"};
  static const std::vector<std::string> gain{"Gain", "GainAbs", "GainRaw"};
  static const std::vector<std::string> black{"BlackLevel", "BlackLevelAbs", "BlackLevelRaw"};
  static const std::vector<std::string> balance{"BalanceRatio", "BalanceRatioAbs", "BalanceRatioRaw"};
  static const std::vector<std::string> format{"PixelFormat"};
  switch (setting) {
    case CameraSetting::kExposure:
      return exposure;
    case CameraSetting::kGain:
      return gain;
    case CameraSetting::kBlackLevel:
      return black;
    case CameraSetting::kWhiteBalance:
      return balance;
    case CameraSetting::kPixelFormat:
      break;
  }
  return format;
}

/// What one of the camera's own units of exposure is, us; a feature that does not say has the standard's.
double exposure_unit_us(const std::string& unit) {
  if (unit == "s") return 1e6;
  if (unit == "ms") return 1e3;
  return unit == "ns" ? 1e-3 : 1;
}

/// Calls `lock` with the name of the camera's feature for a setting; says what is missing where it has none.
template <typename Lock>
void lock_setting(CameraSetting setting, const CameraFeatures& features, const std::string& asked,
                  std::vector<LockedFeature>& all, Lock lock) {
  const CameraFeature feature = find_feature(setting, [&](const std::string& name) { return features.has(name); });
  if (feature.name.empty())
    all.push_back({names_of(setting).front(), asked, feature.absence, false});
  else
    lock(feature.name);
}

void lock_exposure(const CameraFeatures& features, double asked_us, std::vector<LockedFeature>& all) {
  lock_setting(CameraSetting::kExposure, features, format("%g us", asked_us), all, [&](const std::string& name) {
    const double unit_us = exposure_unit_us(features.unit(name));
    all.push_back(features.set_number(name, asked_us / unit_us, kExposureStep_us / unit_us));
  });
}

void lock_gain(const CameraFeatures& features, double asked_db, std::vector<LockedFeature>& all) {
  lock_setting(CameraSetting::kGain, features, format("%g dB", asked_db), all,
               [&](const std::string& name) { all.push_back(features.set_number(name, asked_db, kGainStep_dB)); });
}

void lock_black_level(const CameraFeatures& features, double asked, std::vector<LockedFeature>& all) {
  lock_setting(CameraSetting::kBlackLevel, features, CameraFeatures::number_text(asked), all,
               [&](const std::string& name) { all.push_back(features.set_number(name, asked, 0)); });
}

void lock_colours(const CameraFeatures& features, const std::string& ratio_name, const std::array<double, 3>& asked,
                  std::vector<LockedFeature>& all) {
  constexpr const char* kSelector = "BalanceRatioSelector";
  constexpr std::array kColours{"Red", "Green", "Blue"};
  if (!features.has(kSelector)) return all.push_back({kSelector, "Red", "the camera has no such feature", false});
  for (std::size_t c = 0; c < kColours.size(); ++c) {
    LockedFeature selector = features.set_text(kSelector, kColours[c]);
    if (!selector.holds && c == 1 && asked[1] == 1) continue;  // cameras that balance red and blue against green
    if (!selector.holds) {
      all.push_back(std::move(selector));
      continue;
    }
    LockedFeature ratio = features.set_number(ratio_name, asked[c], kRatioStep);
    ratio.feature += std::string("[") + kColours[c] + "]";
    all.push_back(std::move(ratio));
  }
}

void lock_balance(const CameraFeatures& features, const std::array<double, 3>& asked, std::vector<LockedFeature>& all) {
  lock_setting(CameraSetting::kWhiteBalance, features, format("%g, %g, %g", asked[0], asked[1], asked[2]), all,
               [&](const std::string& name) { lock_colours(features, name, asked, all); });
}

/// Values are to be proportional to light.
void switch_gamma_off(const CameraFeatures& features, std::vector<LockedFeature>& all) {
  if (features.has("GammaEnable"))
    all.push_back(features.set_off("GammaEnable"));
  else if (features.has("GammaEnabled"))
    all.push_back(features.set_off("GammaEnabled"));
  else if (features.has("Gamma"))
    all.push_back(features.set_number("Gamma", 1, kRatioStep));
}

}  // namespace

CameraFeature find_feature(CameraSetting setting, const std::function<bool(const std::string&)>& has) {
  std::string names;
  for (const std::string& name : names_of(setting)) {
    if (has(name)) return {name, {}};
    names += (names.empty() ? "" : ", ") + name;
  }
  return {{}, "the camera has no feature for it (looked for " + names + ")"};
}

std::vector<LockedFeature> lock_camera(ArvCamera* camera, const SourceSettings& settings) {
  const CameraFeatures features(camera);
  std::vector<LockedFeature> all;
  for (const Switch& one : kSwitches)
    if (features.has(one.feature)) all.push_back(features.set_text(one.feature, one.off));
  switch_gamma_off(features, all);
  if (settings.exposure_us > 0) lock_exposure(features, settings.exposure_us, all);
  if (settings.gain_db >= 0) lock_gain(features, settings.gain_db, all);
  if (settings.black_level >= 0) lock_black_level(features, settings.black_level, all);
  if (settings.white_balance[0] > 0) lock_balance(features, settings.white_balance, all);
  return all;
}

std::optional<double> setting_of(ArvCamera* camera, CameraSetting setting) {
  const CameraFeatures features(camera);
  const CameraFeature feature = find_feature(setting, [&](const std::string& name) { return features.has(name); });
  if (feature.name.empty()) return std::nullopt;
  const std::optional<double> value = features.number(feature.name);
  if (!value || setting != CameraSetting::kExposure) return value;
  return *value * exposure_unit_us(features.unit(feature.name));
}

std::string lock_failures(const std::vector<LockedFeature>& features) {
  std::string text;
  for (const LockedFeature& feature : features)
    if (!feature.holds)
      text += (text.empty() ? "" : "; ") + feature.feature + ": asked " + feature.asked + ", got " + feature.got;
  return text;
}

}  // namespace sheen
