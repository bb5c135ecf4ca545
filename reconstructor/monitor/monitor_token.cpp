// SPDX-License-Identifier: Apache-2.0
#include "reconstructor/monitor/monitor_token.h"

#include <cstdlib>

#include "common/base/errors.h"
#include "common/base/files.h"

namespace sheen {
namespace {

namespace fs = std::filesystem;

constexpr std::uintmax_t kLongestFile = 4096;
constexpr const char* kSpace = " \t\r\n";

std::string token_in(const fs::path& file) {
  const std::string text = read_file(file, kLongestFile);
  // The group may read: so systemd hands its credentials to a service.
  constexpr fs::perms kOfAll = fs::perms::others_all | fs::perms::group_write;
  if ((fs::status(file).permissions() & kOfAll) != fs::perms::none)
    throw ConfigError(file.string() + ": others may read or change this token; chmod 600 keeps it for its owner");
  const std::size_t begin = text.find_first_not_of(kSpace);
  if (begin == std::string::npos)
    throw ConfigError(file.string() + ": holds no token; `openssl rand -hex 16` makes one");
  return text.substr(begin, text.find_last_not_of(kSpace) + 1 - begin);
}

}  // namespace

std::string monitor_token(const fs::path& file) {
  if (!file.empty()) return token_in(file);
  const char* const set = std::getenv(kMonitorTokenVariable);
  return set ? set : "";
}

}  // namespace sheen
