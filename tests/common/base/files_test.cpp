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

TEST(Files, ANewFolderIsThereWholeOrNotAtAll) {
  const TempFolder temp;
  const fs::path place = temp.path() / "new";
  const auto beside = [&] { return std::distance(fs::directory_iterator(temp.path()), fs::directory_iterator()); };
  const fs::path abandoned = temp.path() / ("new." + std::to_string(ended_process()) + ".part");
  fs::create_directories(abandoned / "of a process that was killed");
  {
    NewFolder folder(place / "");  // with a slash behind it
    write_file(folder.unfinished() / "a", "half");
    EXPECT_FALSE(fs::exists(place) || fs::exists(abandoned));
  }
  EXPECT_EQ(beside(), 0);
  fs::create_directory(place);  // an empty one will do
  {
    NewFolder folder(place);
    write_file(folder.unfinished() / "a", "whole");
    EXPECT_FALSE(fs::exists(place / "a"));
    folder.finish();
  }
  EXPECT_EQ(read_file(place / "a"), "whole");
  EXPECT_EQ(beside(), 1);
  expect_error([&] { const NewFolder again(place); }, {place.string(), "is there already"});
  expect_error([&] { const NewFolder again(place / "a"); }, {(place / "a").string(), "is there already"});
  expect_error([] { const NewFolder nowhere("/proc/new"); }, {"/proc/new"});
  EXPECT_EQ(read_file(place / "a"), "whole");
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
