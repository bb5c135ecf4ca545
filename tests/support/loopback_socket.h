// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <functional>
#include <stop_token>
#include <string>
#include <string_view>

namespace sheen::testing {

// What servers of a test have in common. All waiting ends soon after `stop`.

/// A socket that listens on 127.0.0.1. Throws std::runtime_error.
int listen_on_loopback(int& port);
void close_socket(int socket);
/// One caller after the other, until `stop`.
void serve_callers(int listener, const std::stop_token& stop, const std::function<void(int caller)>& serve);
/// The head of the next request; empty when the caller has gone.
std::string request_of(int caller, const std::stop_token& stop);
/// False when the caller has gone. One who does not read is waited for.
bool sent_all(int caller, std::string_view bytes, const std::stop_token& stop);

}  // namespace sheen::testing
