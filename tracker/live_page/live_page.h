// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <limits>
#include <memory>
#include <string>

#include "common/image/raw_image.h"

namespace sheen {

/// What a person reads beside the camera's picture while turning a lens or showing a target.
struct LiveWords {
  std::string first;   ///< what to do, a sentence
  bool well = false;   ///< that nothing needs to be done
  std::string detail;  ///< figures, a line
  /// How sharp the picture is, and how sharp it was at best; NaN: that does not count.
  double focus = std::numeric_limits<double>::quiet_NaN(), best_focus = std::numeric_limits<double>::quiet_NaN();
};

/// A page on this machine's loopback address that shows the camera's newest picture, its middle in full size, and
/// words.
class LivePage {
 public:
  /// Port 0: any free one. Throws DeviceError: a port in use.
  explicit LivePage(int port);
  LivePage(LivePage&&) noexcept;
  ~LivePage();

  /// The newest wins. Never waits; a picture is made only while somebody looks, and at most ten times per second.
  void show(const RawImage& image, const LiveWords& words);
  /// Other words beside the picture that is there.
  void say(const LiveWords& words);
  std::string url() const;

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace sheen
