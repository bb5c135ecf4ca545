// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>

namespace sheen {

/// What is wrong with an address to listen on or to connect to, and how to write it; empty when nothing is.
std::string endpoint_error(const std::string& endpoint);

/// The address for either side of a link: "localhost" is 127.0.0.1 on both. Throws ConfigError.
std::string resolved_endpoint(const std::string& endpoint);

}  // namespace sheen
