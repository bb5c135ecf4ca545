// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "reconstructor/models/model_kind.h"

namespace sheen {

/// The surface light field, as a kind of model.
const ModelKind& surface_light_field_kind();

}  // namespace sheen
