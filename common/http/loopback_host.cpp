// SPDX-License-Identifier: Apache-2.0
#include "common/http/loopback_host.h"

#include <arpa/inet.h>

namespace sheen {

bool is_loopback_host(const std::string& host) {
  in_addr v4{};
  if (::inet_pton(AF_INET, host.c_str(), &v4) == 1) return (ntohl(v4.s_addr) >> 24) == 127;
  return host == "localhost" || host == "::1" || host == "[::1]";
}

bool names_loopback(const std::string& header) {
  const std::size_t colon = header.rfind(':');
  return is_loopback_host(colon == std::string::npos || header.ends_with("]") ? header : header.substr(0, colon));
}

}  // namespace sheen
