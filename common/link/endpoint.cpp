// SPDX-License-Identifier: Apache-2.0
#include "common/link/endpoint.h"

#include <algorithm>
#include <charconv>
#include <string_view>

#include "common/base/errors.h"

namespace sheen {
namespace {

constexpr std::string_view kTcp = "tcp://", kIpc = "ipc://", kInproc = "inproc://", kLocalhost = "tcp://localhost:";

bool is_port(std::string_view text) {
  if (text == "*") return true;
  unsigned port = 0;
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), port);
  return error == std::errc() && end == text.data() + text.size() && port <= 65535;
}

bool is_host(std::string_view text) {
  if (text.starts_with('[')) return text.ends_with(']') && text.size() > 2;
  return !text.empty() && text.find(':') == std::string_view::npos;
}

}  // namespace

std::string endpoint_error(const std::string& endpoint) {
  const auto wrong = [&](const char* what) {
    return "endpoint \"" + endpoint + "\": " + what + "; write it as tcp://HOST:PORT, as in tcp://127.0.0.1:7410";
  };
  if (std::any_of(endpoint.begin(), endpoint.end(), [](unsigned char c) { return c <= ' ' || c == 0x7f; }))
    return wrong("has blanks or control characters in it");
  for (const std::string_view local : {kIpc, kInproc})
    if (endpoint.starts_with(local)) return endpoint.size() > local.size() ? "" : wrong("names nothing");
  if (!endpoint.starts_with(kTcp)) return wrong("does not begin with tcp://");
  const std::string_view address = std::string_view(endpoint).substr(kTcp.size());
  const std::size_t colon = address.rfind(':');
  if (colon == std::string_view::npos || address.ends_with(']')) return wrong("has no port");
  if (!is_port(address.substr(colon + 1))) return wrong("the port must be a number up to 65535");
  if (!is_host(address.substr(0, colon))) return wrong("the host is missing, or an IPv6 address without [brackets]");
  return {};
}

std::string resolved_endpoint(const std::string& endpoint) {
  if (const std::string error = endpoint_error(endpoint); !error.empty()) throw ConfigError(error);
  if (!endpoint.starts_with(kLocalhost)) return endpoint;
  return "tcp://127.0.0.1:" + endpoint.substr(kLocalhost.size());
}

}  // namespace sheen
