// SPDX-License-Identifier: Apache-2.0
#include "reconstructor/monitor/monitor_token.h"

#include <gtest/gtest.h>
#include <stdlib.h>

#include "common/base/errors.h"
#include "tests/support/expect_error.h"
#include "tests/support/temp_folder.h"

namespace sheen {
namespace {

namespace fs = std::filesystem;

class MonitorToken : public testing::Test {
 protected:
  MonitorToken() { ::unsetenv(kMonitorTokenVariable); }
  ~MonitorToken() override { ::unsetenv(kMonitorTokenVariable); }
  fs::path file(const std::string& text, fs::perms mode = fs::perms::owner_read | fs::perms::owner_write) const {
    const fs::path path = folder_.write("token", text);
    fs::permissions(path, mode);
    return path;
  }
  const TempFolder folder_;
};

TEST_F(MonitorToken, ComesFromTheFileOrTheEnvironment) {
  EXPECT_EQ(monitor_token({}), "");
  ::setenv(kMonitorTokenVariable, "from the environment", 1);
  EXPECT_EQ(monitor_token({}), "from the environment");
  EXPECT_EQ(monitor_token(file(" 0123456789abcdef \r\n\n")), "0123456789abcdef");
}

TEST_F(MonitorToken, AFileThatOthersMayReadOrChangeIsRefused) {
  using fs::perms;
  for (const perms more : {perms::others_read, perms::others_write, perms::group_write})
    expect_error<Error>([&] { monitor_token(file("0123456789abcdef", perms::owner_read | more)); },
                        {(folder_.path() / "token").string(), "chmod 600"});
  EXPECT_EQ(monitor_token(file("0123456789abcdef", perms::owner_read | perms::group_read)), "0123456789abcdef");
}

TEST_F(MonitorToken, WhatIsWrongIsNamed) {
  expect_error<Error>([&] { monitor_token(file(" \n")); }, {"token", "holds no token"});
  expect_error<Error>([&] { monitor_token(folder_.path() / "none"); }, {"none", "no such file"});
}

}  // namespace
}  // namespace sheen
