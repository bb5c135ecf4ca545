// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>

namespace sheen {

/// GET URL/status.json of a MonitorServer. Throws ConfigError for a URL that is not valid, DeviceError when nobody
/// answers or the token is refused.
std::string fetch_status(const std::string& url, const std::string& token);

/// One line for a person: state, images, held-out figures, speed, what waits. Throws ProtocolError for what is not a
/// status.
std::string status_line(const std::string& status);

}  // namespace sheen
