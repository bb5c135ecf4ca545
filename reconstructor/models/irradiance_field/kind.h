// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "reconstructor/models/model_kind.h"

namespace sheen {

/// The reflected irradiance field, as a kind of model.
const ModelKind& irradiance_field_kind();

}  // namespace sheen
