// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>

#include "reconstructor/models/model_snapshot.h"
#include "reconstructor/surface/opening_view.h"

namespace sheen {

/// How to look at a model first: as `opening_view`, but of the cameras about as high as that one from the one to which
/// the object is brightest. The same as `opening_view` where light moves, or before the first image.
std::optional<OpeningView> best_lit_view(const ModelSnapshot& model);

}  // namespace sheen
