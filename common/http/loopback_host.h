// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>

namespace sheen {

/// 127.0.0.0/8, ::1 or localhost, without a port.
bool is_loopback_host(const std::string& host);
/// Whether a request's Host header, with or without a port, names this machine. A page of another site can point its
/// own name here, and browsers would let it read what is answered to that name.
bool names_loopback(const std::string& host_header);

}  // namespace sheen
