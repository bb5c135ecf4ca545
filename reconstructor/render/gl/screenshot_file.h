// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>

#include "reconstructor/render/gl/view_controls.h"

namespace sheen {

/// A name for a picture of the window, by mode and time, that is free: two in a second do not overwrite each other.
std::filesystem::path free_screenshot(const std::filesystem::path& folder, ViewMode mode);

}  // namespace sheen
