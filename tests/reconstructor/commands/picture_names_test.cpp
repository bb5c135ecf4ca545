// SPDX-License-Identifier: Apache-2.0
#include "reconstructor/commands/picture_names.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <set>

namespace sheen {
namespace {

using ::testing::ElementsAre;

TEST(PictureNames, WithoutTheFolderThatAllShare) {
  EXPECT_THAT(picture_names({"images/0001.png", "images/0002.JPG", "images/r_3"}), ElementsAre("0001", "0002", "r_3"));
  EXPECT_THAT(picture_names({"0001.png"}), ElementsAre("0001"));
  EXPECT_THAT(picture_names({"turn.0001", "turn.0002"}), ElementsAre("turn.0001", "turn.0002"));
  EXPECT_THAT(picture_names({}), ElementsAre());
}

TEST(PictureNames, FoldersThatTellViewsApartStay) {
  EXPECT_THAT(picture_names({"rig/left/0000.png", "rig/right/0000.png", "rig/0000.png"}),
              ElementsAre("left/0000", "right/0000", "0000"));
}

TEST(PictureNames, AllDifferAndNoneLeadsOut) {
  const auto names = picture_names({"a.png", "a.jpg", "a.jpg", "a", "../a.png", "/a.png", "..", "", "./b/../a.png"});
  EXPECT_EQ(std::set(names.begin(), names.end()).size(), 9u);
  for (const auto& name : names) {
    EXPECT_TRUE(name.is_relative()) << name;
    EXPECT_THAT(name.string(), ::testing::Not(::testing::HasSubstr("..")));
  }
}

}  // namespace
}  // namespace sheen
