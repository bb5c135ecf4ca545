// SPDX-License-Identifier: Apache-2.0
#include "common/content_hash.h"

#include <sodium.h>

#include <array>

namespace sheen {

std::string content_hash(std::string_view bytes) {
  std::array<unsigned char, 16> digest;
  crypto_generichash(digest.data(), digest.size(), reinterpret_cast<const unsigned char*>(bytes.data()), bytes.size(),
                     nullptr, 0);
  std::array<char, 33> text;
  return sodium_bin2hex(text.data(), text.size(), digest.data(), digest.size());
}

}  // namespace sheen
