// SPDX-License-Identifier: Apache-2.0
#include "reconstructor/render/gl/screenshot_file.h"

#include <ctime>
#include <string>

namespace sheen {

std::filesystem::path free_screenshot(const std::filesystem::path& folder, ViewMode mode) {
  const std::time_t now = std::time(nullptr);
  std::tm local{};
  localtime_r(&now, &local);
  char stamp[32];
  std::strftime(stamp, sizeof stamp, "%Y%m%d-%H%M%S", &local);
  const std::string stem = std::string("sheen-") + to_string(mode) + "-" + stamp;
  std::filesystem::path path = folder / (stem + ".png");
  for (int i = 2; std::filesystem::exists(path); ++i) path = folder / (stem + "-" + std::to_string(i) + ".png");
  return path;
}

}  // namespace sheen
