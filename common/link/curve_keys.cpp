// SPDX-License-Identifier: Apache-2.0
#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>
#include <zmq.h>

#include <array>
#include <cerrno>
#include <cstring>
#include <sstream>

#include "common/base/errors.h"
#include "common/base/files.h"
#include "common/link/transport.h"
#include "common/link/transport_internals.h"

namespace sheen {
namespace {

constexpr std::size_t kZ85Length = 40;
constexpr std::uintmax_t kMaxKeyFileBytes = 4096;

void write_new_file(const std::filesystem::path& path, mode_t mode, const std::string& text) {
  const int fd = ::open(path.c_str(), O_WRONLY | O_CREAT | O_EXCL | O_CLOEXEC, mode);
  if (fd < 0) {
    if (errno == EEXIST) throw FileError(path, "exists already; keys are never overwritten");
    throw FileError(path, std::string("cannot be written: ") + std::strerror(errno));
  }
  const bool written = ::write(fd, text.data(), text.size()) == static_cast<ssize_t>(text.size()) && ::fsync(fd) == 0;
  ::close(fd);
  if (!written) {
    ::unlink(path.c_str());
    throw FileError(path, "cannot be written");
  }
}

}  // namespace

bool is_z85_key(const std::string& text) {
  std::array<std::uint8_t, 32> binary;
  return text.size() == kZ85Length && zmq_z85_decode(binary.data(), text.c_str()) != nullptr;
}

CurveKeys generate_keys(const std::filesystem::path& folder, const std::string& name) {
  if (name.empty() || name.find('/') != std::string::npos)
    throw ConfigError("key name '" + name + "': must be a file name");
  std::array<char, kZ85Length + 1> public_key{}, secret_key{};
  if (zmq_curve_keypair(public_key.data(), secret_key.data()) != 0)
    throw Error("this build of ZeroMQ has no CURVE security");
  const CurveKeys keys{public_key.data(), secret_key.data()};
  std::error_code ignored;  // the write below says what is wrong
  std::filesystem::create_directories(folder, ignored);
  const std::filesystem::path pub_file = folder / (name + ".pub");
  if (std::filesystem::exists(pub_file)) throw FileError(pub_file, "exists already; keys are never overwritten");
  write_new_file(folder / (name + ".key"), 0600, "public " + keys.public_key + "\nsecret " + keys.secret_key + "\n");
  write_new_file(pub_file, 0644, keys.public_key + "\n");
  return keys;
}

CurveKeys load_keys(const std::filesystem::path& key_file) {
  std::istringstream text(read_file(key_file, kMaxKeyFileBytes));
  struct stat info {};
  if (::stat(key_file.c_str(), &info) == 0 && (info.st_mode & 077) != 0)
    throw FileError(key_file, "holds a secret that other users may read; run chmod 600 on it");
  CurveKeys keys;
  std::string public_word, secret_word;
  text >> public_word >> keys.public_key >> secret_word >> keys.secret_key;
  if (public_word != "public" || secret_word != "secret" || !is_z85_key(keys.public_key) ||
      !is_z85_key(keys.secret_key))
    throw FileError(key_file, "is not a key file; make one with sheen-tracker keygen");
  std::array<char, kZ85Length + 1> derived{};
  if (zmq_curve_public(derived.data(), keys.secret_key.c_str()) != 0 || keys.public_key != derived.data())
    throw FileError(key_file, "public and secret key do not belong together");
  return keys;
}

std::string load_public_key(const std::filesystem::path& pub_file) {
  std::istringstream text(read_file(pub_file, kMaxKeyFileBytes));
  std::string key, more;
  text >> key >> more;
  if (!is_z85_key(key) || !more.empty())
    throw FileError(pub_file, "is not a public key; make one with sheen-tracker keygen");
  return key;
}

}  // namespace sheen
