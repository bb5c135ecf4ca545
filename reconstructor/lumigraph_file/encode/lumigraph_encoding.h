// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>

#include "common/base/progress.h"
#include "reconstructor/lumigraph_file/lumigraph_data.h"

namespace sheen {

/// The views' file, docs/intrinsic_lumigraph_format.md.
std::string encode_lumigraph(const LumigraphData& data, const StepsDone& progress = {});

}  // namespace sheen
