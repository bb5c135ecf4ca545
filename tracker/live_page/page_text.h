// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string_view>

namespace sheen {

/// The page as one HTML document, style and script within.
std::string_view live_page_text();

}  // namespace sheen
