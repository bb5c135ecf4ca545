// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <span>
#include <string_view>

#include "reconstructor/models/model_kind.h"

namespace sheen {

/// The kinds of model that this program knows; the first is taken where a scene does not choose. The one place outside
/// the models' own folders that names them: each program links the list that it is to know.
std::span<const ModelKind* const> model_kinds();

}  // namespace sheen
