// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>

namespace sheen {

/// Whether a source's target is the address of a stream on the network (it has "://"), and not a path.
bool is_stream_address(const std::string& target);

/// Nothing where the address can be opened; else what is wrong with it: another scheme than http, https, rtsp and
/// rtsps, no host, blanks.
std::string address_error(const std::string& address);

/// A text with an address in it as it may be shown and logged: the password in front of the host, and those among the
/// parameters behind it (`?user=me&pwd=...`), are three asterisks.
std::string without_password(const std::string& text);

}  // namespace sheen
