// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string_view>

namespace sheen {

/// The page that a browser shows: one HTML document, style and script within, nothing from elsewhere. It asks for
/// status.json once per second.
std::string_view status_page();

}  // namespace sheen
