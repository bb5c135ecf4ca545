// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <vector>

#include "common/datasets/dataset.h"

namespace sheen {

/// Poses that were found from photographs alone stand in a frame and a unit of nobody's choice. Brings them into one
/// that is easy to work in: the origin where the cameras look at, z up as the photographs have it (their
/// `exif_orientation` counts), and a unit in which the cameras stand half a metre from the origin (median).
void bring_to_plain_frame(std::vector<DatasetView>& views);

/// The same poses in another unit: lengths are `factor` times as many.
void scale_poses(std::vector<DatasetView>& views, double factor);

}  // namespace sheen
