// SPDX-License-Identifier: Apache-2.0
#include "common/base/files.h"

#include <gtest/gtest.h>
#include <sys/wait.h>
#include <unistd.h>

#include "tests/support/expect_error.h"
#include "tests/support/temp_folder.h"

namespace sheen {
namespace {

namespace fs = std::filesystem;

pid_t ended_process() {
  const pid_t child = ::fork();
  if (child == 0) ::_exit(0);
  int status = 0;
  ::waitpid(child, &status, 0);
  return child;
}

TEST(Files, WhatAKilledProcessLeftIsRemovedAndNothingElse) {
  const TempFolder folder;
  const std::string gone = std::to_string(ended_process()), alive = std::to_string(::getppid());
  for (const std::string& name : {"m.exr." + gone + ".part", "m.exr." + alive + ".part", std::string("m.exr.x.part"),
                                  "other.exr." + gone + ".part", std::string("m.exr.part")})
    folder.write(name, "half");
  write_file(folder.path() / "m.exr", "whole");
  EXPECT_EQ(read_file(folder.path() / "m.exr"), "whole");
  EXPECT_FALSE(fs::exists(folder.path() / ("m.exr." + gone + ".part")));
  for (const std::string& name : {"m.exr." + alive + ".part", std::string("m.exr.x.part"),
                                  "other.exr." + gone + ".part", std::string("m.exr.part")})
    EXPECT_TRUE(fs::exists(folder.path() / name)) << name;
}

TEST(Files, ADeviceIsWrittenAndNotReplaced) {
  expect_error([] { write_file("/dev/full", "x"); }, {"/dev/full", "No space left"});
  EXPECT_TRUE(fs::is_character_file("/dev/full"));
  write_file("/dev/null", "x");
  EXPECT_TRUE(fs::is_character_file("/dev/null"));
}

TEST(Files, WhatCannotBeWrittenIsToldBefore) {
  const TempFolder folder;
  const fs::path file = folder.write("file", "old");
  check_writable(file);
  check_writable(folder.path() / "new");
  check_writable("/dev/null");
  check_writable_folder(folder.path() / "a" / "b");
  EXPECT_EQ(read_file(file), "old");
  EXPECT_FALSE(fs::exists(folder.path() / "new"));
  EXPECT_FALSE(fs::exists(folder.path() / "a")) << "asked, not made";
  expect_error([&] { check_writable(folder.path() / "absent" / "new"); }, {"absent/new", "cannot be written"});
  expect_error([&] { check_writable(folder.path()); }, {"is a folder"});
  expect_error([&] { check_writable_folder(file / "below"); }, {"file/below", "file is not a folder"});
}

}  // namespace
}  // namespace sheen
