// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>

namespace sheen {

/// An address of this machine's loopback network for one simulated camera, as long as this lives: a second would share
/// the port of the first, and either could answer. It ends with the process, however that ends.
class AddressClaim {
 public:
  /// Throws DeviceError where another process, or this one, has it.
  explicit AddressClaim(const std::string& address);
  ~AddressClaim();
  AddressClaim(const AddressClaim&) = delete;
  AddressClaim& operator=(const AddressClaim&) = delete;

 private:
  int socket_;
};

}  // namespace sheen
