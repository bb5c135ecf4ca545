// SPDX-License-Identifier: Apache-2.0
#include "tracker/sources/video_controls.h"

#include <linux/videodev2.h>

#include <array>
#include <cerrno>
#include <cmath>
#include <cstring>
#include <optional>

#include "common/base/format.h"

namespace sheen {
namespace {

constexpr double kExposureUnit_us = 100;  ///< of V4L2_CID_EXPOSURE_ABSOLUTE

struct Control {
  std::uint32_t id;
  const char* name;
};
constexpr Control kExposure{V4L2_CID_EXPOSURE_ABSOLUTE, "exposure_time_absolute"};
constexpr Control kRed{V4L2_CID_RED_BALANCE, "red_balance"}, kBlue{V4L2_CID_BLUE_BALANCE, "blue_balance"};

/// What changes by itself, and the value that stops it.
struct Switch {
  Control control;
  std::int32_t off;
};
constexpr std::array kSwitches{Switch{{V4L2_CID_EXPOSURE_AUTO, "auto_exposure"}, V4L2_EXPOSURE_MANUAL},
                               Switch{{V4L2_CID_EXPOSURE_AUTO_PRIORITY, "exposure_dynamic_framerate"}, 0},
                               Switch{{V4L2_CID_AUTOGAIN, "gain_automatic"}, 0},
                               Switch{{V4L2_CID_AUTO_WHITE_BALANCE, "white_balance_automatic"}, 0},
                               Switch{{V4L2_CID_FOCUS_AUTO, "focus_automatic_continuous"}, 0}};

class Controls {
 public:
  explicit Controls(const DeviceCall& call) : call_(call) {}

  bool has(const Control& control) const {
    v4l2_queryctrl query{};
    query.id = control.id;
    return call_(VIDIOC_QUERYCTRL, &query) == 0 && !(query.flags & V4L2_CTRL_FLAG_DISABLED);
  }
  /// Nothing where it cannot be read.
  std::optional<std::int32_t> get(const Control& control) const {
    v4l2_control value{};
    value.id = control.id;
    if (call_(VIDIOC_G_CTRL, &value) != 0) return std::nullopt;
    return value.value;
  }
  /// Sets, reads back, compares in multiples of `unit`. A device that refuses the value may have it already.
  LockedFeature set(const Control& control, double asked, double unit) const {
    LockedFeature result{control.name, format("%.6g", asked), {}, false};
    v4l2_control value{};
    value.id = control.id;
    value.value = static_cast<std::int32_t>(std::lround(asked / unit));
    const std::string refusal = call_(VIDIOC_S_CTRL, &value) == 0 ? "" : std::strerror(errno);
    const std::optional<std::int32_t> got = get(control);
    if (!got) {
      result.got = std::strerror(errno);
      return result;
    }
    result.holds = holds(asked, *got * unit, unit / 2);
    result.got = format("%.6g", *got * unit);
    if (!result.holds && !refusal.empty()) result.got += " (" + refusal + ")";
    return result;
  }

 private:
  const DeviceCall& call_;
};

LockedFeature missing(const char* name, const std::string& asked, const std::string& why) {
  return {name, asked, why, false};
}

/// A V4L2 device names its gain and balance in numbers of its own, and has no black level.
void lock_levels(const Controls& controls, const SourceSettings& settings, std::vector<LockedFeature>& all) {
  if (settings.gain_db >= 0)
    all.push_back(missing("gain", format("%g dB", settings.gain_db),
                          "a video device's gain is not in dB: set it with v4l2-ctl, and leave out gain_db"));
  if (settings.black_level >= 0)
    all.push_back(missing("black_level", format("%g", settings.black_level), "a video device has none"));
  if (settings.white_balance[0] <= 0) return;
  for (const auto& [control, asked] :
       {std::pair{kRed, settings.white_balance[0]}, std::pair{kBlue, settings.white_balance[2]}})
    all.push_back(controls.has(control) ? controls.set(control, asked, 1)
                                        : missing(control.name, format("%g", asked), "this device has none"));
}

}  // namespace

VideoLocks lock_video_device(const DeviceCall& call, const SourceSettings& settings) {
  const Controls controls(call);
  VideoLocks locks;
  for (const Switch& by_itself : kSwitches)
    if (controls.has(by_itself.control)) locks.features.push_back(controls.set(by_itself.control, by_itself.off, 1));
  const bool has_exposure = controls.has(kExposure);
  if (settings.exposure_us > 0)
    locks.features.push_back(
        has_exposure ? controls.set(kExposure, settings.exposure_us, kExposureUnit_us)
                     : missing(kExposure.name, format("%g us", settings.exposure_us), "this device has none"));
  lock_levels(controls, settings, locks.features);
  if (has_exposure) locks.exposure_s = controls.get(kExposure).value_or(0) * kExposureUnit_us * 1e-6;
  return locks;
}

}  // namespace sheen
