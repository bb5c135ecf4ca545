// SPDX-License-Identifier: Apache-2.0
#include "tracker/sources/camera_reset.h"

#include <array>

namespace sheen {
namespace {

struct Choice {
  const char* feature;
  const char* wanted;
};
constexpr std::array kChoices{Choice{"AcquisitionMode", "Continuous"}, Choice{"ExposureMode", "Timed"},
                              Choice{"TestPattern", "Off"}, Choice{"TestImageSelector", "Off"}};
constexpr std::array kSwitchedOff{"ReverseX", "ReverseY", "LUTEnable", "ChunkModeActive"};
constexpr std::array kOne{"BinningHorizontal", "BinningVertical", "DecimationHorizontal", "DecimationVertical"};

bool contains(const std::vector<std::string>& all, const std::string& one) {
  for (const std::string& each : all)
    if (each == one) return true;
  return false;
}

class Reset {
 public:
  explicit Reset(_ArvCamera* camera) : features_(camera) {}

  /// Of a camera that does not know the wanted value under this name the feature is left alone.
  void choice(const char* feature, const char* wanted, const std::string& selected = "") {
    const std::optional<std::string> was = features_.text(feature);
    if (!was || *was == wanted || !contains(features_.choices(feature), wanted)) return;
    add(features_.set_text(feature, wanted), *was, selected);
  }
  void off(const char* feature) {
    if (features_.on(feature).value_or(false)) add(features_.set_off(feature), "on");
  }
  void one(const char* feature) {
    const std::optional<double> was = features_.number(feature);
    if (was && *was != 1) add(features_.set_number(feature, 1, 0), CameraFeatures::number_text(*was));
  }
  /// Each trigger that the camera has: of a frame, of a series of frames, ...
  void triggers() {
    constexpr const char* kSelector = "TriggerSelector";
    const std::vector<std::string> selectors = features_.choices(kSelector);
    if (selectors.empty()) choice("TriggerMode", "Off");
    for (const std::string& selector : selectors)
      if (features_.set_text(kSelector, selector).holds) choice("TriggerMode", "Off", "[" + selector + "]");
  }
  std::vector<ResetFeature> take() { return std::move(all_); }

 private:
  void add(LockedFeature now, const std::string& was, const std::string& selected = "") {
    now.feature += selected;
    all_.push_back({std::move(now), was});
  }

  CameraFeatures features_;
  std::vector<ResetFeature> all_;
};

}  // namespace

std::vector<ResetFeature> reset_camera(_ArvCamera* camera) {
  Reset reset(camera);
  reset.triggers();
  for (const Choice& one : kChoices) reset.choice(one.feature, one.wanted);
  for (const char* feature : kSwitchedOff) reset.off(feature);
  for (const char* feature : kOne) reset.one(feature);
  return reset.take();
}

std::string reset_text(const std::vector<ResetFeature>& features) {
  std::string text;
  for (const ResetFeature& feature : features)
    text += (text.empty() ? "" : "; ") + feature.now.feature + " was " + feature.was + ", is " + feature.now.got;
  return text;
}

}  // namespace sheen
