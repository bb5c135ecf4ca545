// SPDX-License-Identifier: Apache-2.0
#include "common/base/content_hash.h"

#include <sodium.h>

#include <array>
#include <cerrno>
#include <cstring>
#include <fstream>
#include <vector>

#include "common/base/errors.h"

namespace sheen {
namespace {

class Hasher {
 public:
  Hasher() { crypto_generichash_init(&state_, nullptr, 0, kBytes); }
  void add(std::string_view bytes) {
    crypto_generichash_update(&state_, reinterpret_cast<const unsigned char*>(bytes.data()), bytes.size());
  }
  std::string text() {
    std::array<unsigned char, kBytes> digest;
    crypto_generichash_final(&state_, digest.data(), digest.size());
    std::array<char, 2 * kBytes + 1> hexadecimal;
    return sodium_bin2hex(hexadecimal.data(), hexadecimal.size(), digest.data(), digest.size());
  }

 private:
  static constexpr std::size_t kBytes = 16;
  crypto_generichash_state state_;
};

}  // namespace

std::string content_hash(std::string_view bytes) {
  Hasher hasher;
  hasher.add(bytes);
  return hasher.text();
}

std::string content_hash_of_file(const std::filesystem::path& file) {
  std::ifstream in(file, std::ios::binary);
  if (!in) throw FileError(file.string(), std::string("cannot be opened: ") + std::strerror(errno));
  Hasher hasher;
  std::vector<char> piece(1 << 18);
  while (in) {
    in.read(piece.data(), static_cast<std::streamsize>(piece.size()));
    hasher.add({piece.data(), static_cast<std::size_t>(in.gcount())});
  }
  if (in.bad()) throw FileError(file.string(), std::string("cannot be read: ") + std::strerror(errno));
  return hasher.text();
}

}  // namespace sheen
