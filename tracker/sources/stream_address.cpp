// SPDX-License-Identifier: Apache-2.0
#include "tracker/sources/stream_address.h"

#include <algorithm>
#include <array>
#include <cctype>
#include <string_view>

namespace sheen {
namespace {

constexpr std::string_view kBehindScheme = "://";
constexpr const char* kHidden = "***";
constexpr std::array<std::string_view, 4> kSchemes{"http", "https", "rtsp", "rtsps"};
/// A parameter whose name holds one of them is a secret.
constexpr std::array<std::string_view, 8> kSecrets{"pass", "pwd", "token", "secret",
                                                   "auth", "key", "sig",   "credential"};

std::string lower(std::string_view text) {
  std::string low(text);
  std::transform(low.begin(), low.end(), low.begin(), [](unsigned char c) { return std::tolower(c); });
  return low;
}

bool is_number(std::string_view text) {
  return std::all_of(text.begin(), text.end(), [](unsigned char c) { return std::isdigit(c); });
}

bool is_secret(std::string_view name) {
  const std::string low = lower(name);
  return std::any_of(kSecrets.begin(), kSecrets.end(),
                     [&](std::string_view word) { return low.find(word) != std::string::npos; });
}

/// "user=me&pwd=x" with what is secret hidden.
std::string shown_parameters(std::string_view parameters) {
  std::string shown;
  while (!parameters.empty()) {
    const std::size_t end = std::min(parameters.find_first_of("&;#"), parameters.size());
    const std::string_view one = parameters.substr(0, end);
    const std::size_t value = one.find('=');
    const bool hides = value != std::string_view::npos && is_secret(one.substr(0, value));
    shown += hides ? std::string(one.substr(0, value + 1)) + kHidden : std::string(one);
    if (end == parameters.size()) break;
    shown += parameters[end];
    parameters.remove_prefix(end + 1);
  }
  return shown;
}

}  // namespace

bool is_stream_address(const std::string& target) {
  return target.find(kBehindScheme) != std::string::npos;
}

std::string address_error(const std::string& address) {
  const std::size_t scheme_end = address.find(kBehindScheme);
  const std::string scheme = lower(std::string_view(address).substr(0, scheme_end));
  if (scheme_end == std::string::npos || std::find(kSchemes.begin(), kSchemes.end(), scheme) == kSchemes.end())
    return "is not the address of a stream; it begins with http://, https://, rtsp:// or rtsps://";
  if (std::any_of(address.begin(), address.end(), [](unsigned char c) { return c <= ' ' || c == 0x7f; }))
    return "has blanks in it; write %20 for a blank";
  const std::size_t host = scheme_end + kBehindScheme.size();
  const std::string authority = address.substr(host, address.find_first_of("/?#", host) - host);
  const std::size_t behind_user = authority.rfind('@') == std::string::npos ? 0 : authority.rfind('@') + 1;
  if (authority.size() == behind_user || authority[behind_user] == ':')
    return "names no host; it is written as " + scheme + "://HOST:PORT/PATH";
  return {};
}

std::string without_password(const std::string& text) {
  const std::size_t scheme_end = text.find(kBehindScheme);
  if (scheme_end == std::string::npos) return text;
  const std::size_t user = scheme_end + kBehindScheme.size();
  const std::size_t path = std::min(text.find_first_of("/?#", user), text.size());
  const std::size_t colon = text.find(':', user), at = text.rfind('@');
  const bool named = at != std::string::npos && colon < at;
  // A password that holds "/" or "?" is a mistake, but to be hidden, too; what stands behind a port is none.
  const bool hides = named && (at < path || (colon < path && !is_number(text.substr(colon + 1, path - colon - 1))));
  std::string shown = text.substr(0, hides ? colon + 1 : user) + (hides ? kHidden : "");
  const std::string rest = text.substr(hides ? at : user);
  const std::size_t query = rest.find('?');
  if (query == std::string::npos) return shown + rest;
  return shown + rest.substr(0, query + 1) + shown_parameters(std::string_view(rest).substr(query + 1));
}

}  // namespace sheen
