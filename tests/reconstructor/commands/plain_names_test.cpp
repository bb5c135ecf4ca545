// SPDX-License-Identifier: Apache-2.0
#include "reconstructor/commands/plain_names.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <filesystem>
#include <set>
#include <string>

#include "common/capture/capture_validation.h"
#include "common/datasets/file_finder.h"

namespace sheen {
namespace {

std::string alone(const std::string& name) {
  return PlainNames().take(name);
}

TEST(PlainNames, KeepWhatEveryProgramTakes) {
  EXPECT_EQ(alone("images/0001.png"), "0001");
  EXPECT_EQ(alone("left/0001.JPG"), "left/0001");
  EXPECT_EQ(alone("turn.0001"), "turn.0001");
  EXPECT_EQ(alone("Büste/日本.webp"), "Büste/日本");
}

TEST(PlainNames, ReplaceWhatSomeDoNot) {
  EXPECT_EQ(alone("left frame 17"), "left_frame_17");
  EXPECT_EQ(alone("#a:b*?\"<>|.png"), "_a_b______");
  EXPECT_EQ(alone("-rf"), "_rf");
  EXPECT_EQ(alone("C:\\scan\\a.png"), "C_/scan/a");
  EXPECT_EQ(alone("a.png/b"), "a_png/b") << "no folder has the name of a picture";
  EXPECT_EQ(alone("..\n/\xff\xfe.png"), "___/__");
}

TEST(PlainNames, AllDifferAndNoneLeadsOut) {
  PlainNames names;
  std::set<std::string> taken;
  int count = 0;
  for (const std::string& name :
       {std::string("a.png"), std::string("A.jpg"), std::string("a"), std::string("images/a"), std::string("../a.png"),
        std::string("/etc/passwd"), std::string(".."), std::string(), std::string("/"), std::string("a-2"),
        std::string("a\0b", 3), std::string(4000, 'x'), std::string(4000, 'x') + "y", std::string(".hidden/.b")}) {
    const std::string plain = names.take(name);
    ++count;
    taken.insert(loose_name(plain));
    EXPECT_TRUE(std::filesystem::path(plain).is_relative()) << plain;
    EXPECT_THAT(plain, testing::Not(testing::HasSubstr(".."))) << plain;
    EXPECT_TRUE(is_plain_text(plain)) << plain;
    for (const auto& part : std::filesystem::path(plain)) {
      EXPECT_LE(part.string().size(), 120u);
      EXPECT_NE(part.string().front(), '.');
    }
  }
  EXPECT_EQ(taken.size(), static_cast<std::size_t>(count));
  std::string long_name;
  for (int i = 0; i < 99; ++i) long_name += "日";
  EXPECT_TRUE(is_plain_text(names.take(long_name))) << "cut between letters";
}

}  // namespace
}  // namespace sheen
