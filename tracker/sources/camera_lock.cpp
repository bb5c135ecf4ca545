// SPDX-License-Identifier: Apache-2.0
#include "tracker/sources/camera_lock.h"

#include <arv.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <optional>

#include "common/base/format.h"

namespace sheen {
namespace {

constexpr double kSame = 0.01;           ///< part of a value by which a camera may round it
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

/// A camera's features by name. An error of the camera is a sentence in place of a value.
class Features {
 public:
  explicit Features(ArvCamera* camera) : camera_(camera) {}

  bool has(const std::string& name) const { return arv_camera_is_feature_available(camera_, name.c_str(), nullptr); }

  LockedFeature set_text(const std::string& name, const std::string& asked) const {
    return attempt(
        name, asked, [&](GError** e) { arv_camera_set_string(camera_, name.c_str(), asked.c_str(), e); },
        [&](GError** e) {
          const char* got = arv_camera_get_string(camera_, name.c_str(), e);
          return std::string(got ? got : "");
        },
        [&](const std::string& got) { return got == asked; });
  }

  LockedFeature set_number(const std::string& name, double asked, double step) const {
    const bool whole = is_integer(name);
    return attempt(
        name, number_text(asked),
        [&](GError** e) {
          if (whole)
            arv_camera_set_integer(camera_, name.c_str(), std::llround(asked), e);
          else
            arv_camera_set_float(camera_, name.c_str(), asked, e);
        },
        [&](GError** e) {
          return number_text(whole ? double(arv_camera_get_integer(camera_, name.c_str(), e))
                                   : arv_camera_get_float(camera_, name.c_str(), e));
        },
        [&](const std::string& got) { return holds(asked, std::stod(got), step); });
  }

  LockedFeature set_off(const std::string& name) const {
    return attempt(
        name, "off", [&](GError** e) { arv_camera_set_boolean(camera_, name.c_str(), false, e); },
        [&](GError** e) { return std::string(arv_camera_get_boolean(camera_, name.c_str(), e) ? "on" : "off"); },
        [](const std::string& got) { return got == "off"; });
  }

  static std::string number_text(double value) { return format("%.6g", value); }

  /// Sets, reads back, compares. A camera that refuses the value may have it already.
  template <typename Set, typename Get, typename Holds>
  LockedFeature attempt(const std::string& name, const std::string& asked, Set set, Get get, Holds same) const {
    LockedFeature result{name, asked, {}, false};
    GError* error = nullptr;
    set(&error);
    const std::string refusal = error ? error->message : "";
    g_clear_error(&error);
    const std::string got = get(&error);
    if (error) {
      result.got = error->message;
      g_clear_error(&error);
      return result;
    }
    result.holds = same(got);
    result.got = result.holds || refusal.empty() ? got : got + " (" + refusal + ")";
    return result;
  }

 private:
  bool is_integer(const std::string& name) const {
    return ARV_IS_GC_INTEGER(arv_device_get_feature(arv_camera_get_device(camera_), name.c_str())) &&
           !ARV_IS_GC_FLOAT(arv_device_get_feature(arv_camera_get_device(camera_), name.c_str()));
  }

  ArvCamera* camera_;
};

/// Calls `lock` with the name of the camera's feature for a setting; says what is missing where it has none.
template <typename Lock>
void lock_setting(CameraSetting setting, const Features& features, const std::string& asked,
                  std::vector<LockedFeature>& all, Lock lock) {
  const CameraFeature feature = find_feature(setting, [&](const std::string& name) { return features.has(name); });
  if (feature.name.empty())
    all.push_back({names_of(setting).front(), asked, feature.absence, false});
  else
    lock(feature.name);
}

void lock_exposure(ArvCamera* camera, const Features& features, double asked_us, std::vector<LockedFeature>& all) {
  lock_setting(CameraSetting::kExposure, features, format("%g us", asked_us), all, [&](const std::string& name) {
    all.push_back(features.attempt(
        name, Features::number_text(asked_us), [&](GError** e) { arv_camera_set_exposure_time(camera, asked_us, e); },
        [&](GError** e) { return Features::number_text(arv_camera_get_exposure_time(camera, e)); },
        [&](const std::string& got) { return holds(asked_us, std::stod(got), kExposureStep_us); }));
  });
}

void lock_gain(ArvCamera* camera, const Features& features, double asked_db, std::vector<LockedFeature>& all) {
  lock_setting(CameraSetting::kGain, features, format("%g dB", asked_db), all, [&](const std::string& name) {
    all.push_back(features.attempt(
        name, Features::number_text(asked_db), [&](GError** e) { arv_camera_set_gain(camera, asked_db, e); },
        [&](GError** e) { return Features::number_text(arv_camera_get_gain(camera, e)); },
        [&](const std::string& got) { return holds(asked_db, std::stod(got), kGainStep_dB); }));
  });
}

void lock_black_level(const Features& features, double asked, std::vector<LockedFeature>& all) {
  lock_setting(CameraSetting::kBlackLevel, features, Features::number_text(asked), all,
               [&](const std::string& name) { all.push_back(features.set_number(name, asked, 0)); });
}

void lock_colours(const Features& features, const std::string& ratio_name, const std::array<double, 3>& asked,
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

void lock_balance(const Features& features, const std::array<double, 3>& asked, std::vector<LockedFeature>& all) {
  lock_setting(CameraSetting::kWhiteBalance, features, format("%g, %g, %g", asked[0], asked[1], asked[2]), all,
               [&](const std::string& name) { lock_colours(features, name, asked, all); });
}

/// Values are to be proportional to light.
void switch_gamma_off(const Features& features, std::vector<LockedFeature>& all) {
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

bool holds(double asked, double got, double step) {
  return std::abs(got - asked) <= std::max(step, kSame * std::abs(asked));
}

std::vector<LockedFeature> lock_camera(ArvCamera* camera, const SourceSettings& settings) {
  const Features features(camera);
  std::vector<LockedFeature> all;
  for (const Switch& one : kSwitches)
    if (features.has(one.feature)) all.push_back(features.set_text(one.feature, one.off));
  switch_gamma_off(features, all);
  if (settings.exposure_us > 0) lock_exposure(camera, features, settings.exposure_us, all);
  if (settings.gain_db >= 0) lock_gain(camera, features, settings.gain_db, all);
  if (settings.black_level >= 0) lock_black_level(features, settings.black_level, all);
  if (settings.white_balance[0] > 0) lock_balance(features, settings.white_balance, all);
  return all;
}

std::string lock_failures(const std::vector<LockedFeature>& features) {
  std::string text;
  for (const LockedFeature& feature : features)
    if (!feature.holds)
      text += (text.empty() ? "" : "; ") + feature.feature + ": asked " + feature.asked + ", got " + feature.got;
  return text;
}

}  // namespace sheen
