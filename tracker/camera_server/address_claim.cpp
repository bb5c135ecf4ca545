// SPDX-License-Identifier: Apache-2.0
#include "tracker/camera_server/address_claim.h"

#include <sys/socket.h>
#include <sys/un.h>
#include <unistd.h>

#include <algorithm>
#include <cstddef>

#include "common/base/errors.h"

namespace sheen {

AddressClaim::AddressClaim(const std::string& address) : socket_(::socket(AF_UNIX, SOCK_DGRAM | SOCK_CLOEXEC, 0)) {
  // A name that begins with a zero is no file: it is of this network alone, and gone with the socket (unix(7),
  // "abstract").
  const std::string name = std::string(1, '\0') + "sheen-camera-" + address;
  sockaddr_un place{.sun_family = AF_UNIX, .sun_path = {}};
  name.copy(place.sun_path, sizeof place.sun_path);
  const auto length =
      static_cast<socklen_t>(offsetof(sockaddr_un, sun_path) + std::min(name.size(), sizeof place.sun_path));
  if (::bind(socket_, reinterpret_cast<const sockaddr*>(&place), length) == 0) return;
  ::close(socket_);
  throw DeviceError("a simulated camera serves on " + address +
                    " already: end it, or give this one another --interface");
}

AddressClaim::~AddressClaim() {
  ::close(socket_);
}

}  // namespace sheen
