// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <filesystem>

#include "tracker/calibration/lens_fit.h"
#include "tracker/calibration/target.h"
#include "tracker/commands/live_source.h"

namespace sheen {

/// Tells a person before a camera which view of the target is needed next, and saves those that a calibration gains by
/// into `folder`, until nothing is missing, the person or the source has had enough, or `frames` (0: all) were looked
/// at. Throws Error where none was saved.
void collect_views(LiveSource& source, const CalibrationTarget& target, const LensFit& fit,
                   const std::filesystem::path& folder, std::uint64_t frames);

}  // namespace sheen
