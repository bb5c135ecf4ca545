// SPDX-License-Identifier: Apache-2.0
#include "reconstructor/commands/export_page.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "common/base/errors.h"
#include "common/base/files.h"
#include "tests/support/temp_folder.h"

namespace sheen {
namespace {

using ::testing::AllOf;
using ::testing::HasSubstr;

class PageExport : public ::testing::Test {
 protected:
  PageText read(const std::string& json) {
    write_file(file_, json);
    return read_page_text(file_, "models/pot.slf");
  }
  std::string refusal(const std::string& json) {
    try {
      read(json);
    } catch (const FileError& error) {
      return error.what();
    }
    return "";
  }
  TempFolder folder_;
  std::filesystem::path file_ = folder_.path() / "about.json";
};

TEST_F(PageExport, TitleIsThatOfTheFileOrTheModelsName) {
  EXPECT_EQ(page_text("models/pot.slf").title, "pot");
  EXPECT_EQ(read("{}").title, "pot");
  EXPECT_EQ(read(R"({"title": "A pot", "notes": [{"at": [0, 1, 2], "title": "Lid"}], "up": [0, 0, 1]})").title,
            "A pot");
}

TEST_F(PageExport, WhatIsWrongWithTheFileIsNamed) {
  EXPECT_THAT(refusal("{"), AllOf(HasSubstr("about.json"), HasSubstr("is not valid JSON")));
  EXPECT_THAT(refusal("[]"), HasSubstr("is not an object"));
  EXPECT_THAT(refusal(R"({"titel": "A pot"})"), HasSubstr("\"titel\" is none of its fields"));
  EXPECT_THAT(refusal(R"({"title": 3})"), HasSubstr("\"title\" is not a text"));
  EXPECT_THAT(refusal(R"({"eye": [1, 2]})"), HasSubstr("\"eye\" is not three numbers"));
  EXPECT_THAT(refusal(R"({"notes": {}})"), HasSubstr("\"notes\" is not a list"));
  EXPECT_THAT(refusal(R"({"notes": [{"at": [0, 0, 0], "title": "a"}, {"title": "b"}]})"),
              HasSubstr("note 2: \"at\" is not three numbers"));
  EXPECT_THAT(refusal(R"({"notes": [{"at": [0, 0, 0]}]})"), HasSubstr("note 1: \"title\" is not a text"));
}

TEST_F(PageExport, TextEndsNoScriptOfThePage) {
  EXPECT_THAT(read(R"({"text": "</script><script>alert(1)</script>"})").about, ::testing::Not(HasSubstr("<")));
}

TEST_F(PageExport, OtherModelsAreRefusedBeforeAnythingIsWritten) {
  write_file(folder_.path() / "other.ilg", "sheenILG and so on");
  const std::filesystem::path page = folder_.path() / "page";
  EXPECT_THROW(write_page(folder_.path() / "other.ilg", page, {}), ConfigError);
  EXPECT_THROW(write_page(folder_.path(), page, {}), ConfigError);
  EXPECT_THROW(write_page(folder_.path() / "none.slf", page, {}), FileError);
  EXPECT_FALSE(std::filesystem::exists(page));
}

TEST_F(PageExport, WhatAKindOfModelHasNoUseForIsRefusedByName) {
  const auto golden = std::filesystem::path(SHEEN_GOLDEN_FOLDER);
  const auto refused = [&](const char* model, const std::string& about) {
    try {
      write_single_page(golden / model, folder_.path() / "page.html", {.title = "x", .about = about});
    } catch (const ConfigError& error) {
      return std::string(error.what());
    } catch (const Error&) {  // a build without the page
    }
    return std::string("taken");
  };
  EXPECT_THAT(refused("sphere.slf", R"({"light": [0, 0, 1]})"), HasSubstr("a surface light field has no \"light\""));
  EXPECT_THAT(refused("relief.rif", R"({"notes": []})"), HasSubstr("an irradiance field has no \"notes\""));
  EXPECT_EQ(refused("sphere.slf", R"({"notes": []})"), "taken");
}

}  // namespace
}  // namespace sheen
