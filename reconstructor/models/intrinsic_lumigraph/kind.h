// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "reconstructor/models/model_kind.h"

namespace sheen {

/// The intrinsic lumigraph, as a kind of model.
const ModelKind& intrinsic_lumigraph_kind();

}  // namespace sheen
