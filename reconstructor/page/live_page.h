// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string_view>

namespace sheen {

/// The page that shows a model as it is captured: one HTML document, style and script within, nothing from elsewhere.
/// It asks for `scene` and `changes` beside it.
std::string_view live_page();

}  // namespace sheen
