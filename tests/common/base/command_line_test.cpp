// SPDX-License-Identifier: Apache-2.0
#include "common/base/command_line.h"

#include <gtest/gtest.h>
#include <sys/resource.h>

#include <cstdlib>
#include <stdexcept>

#include "common/base/files.h"

namespace sheen {
namespace {

TEST(CommandLine, NumbersOutOfRangeAreNoNumbers) {
  const auto number = number_in(0, 10).error, whole = whole_number_in(-2, 65535).error;
  for (const char* text : {"0", "10", "3.5", "1e-300"}) EXPECT_EQ(number(text), "") << text;
  for (const char* text : {"-1", "10.1", "nan", "inf", "-inf", "1e999", "", "soon", "3s", " 3"})
    EXPECT_NE(number(text), "") << text;
  for (const char* text : {"-2", "0", "65535"}) EXPECT_EQ(whole(text), "") << text;
  for (const char* text : {"-3", "65536", "3.5", "18446744073709551615", "nan", "", "1e3"})
    EXPECT_NE(whole(text), "") << text;
}

TEST(CommandLine, TheNearestWord) {
  const std::vector<std::string> words{"serve", "build", "render", "evaluate", "undo"};
  EXPECT_EQ(nearest_word("biuld", words), "build");
  EXPECT_EQ(nearest_word("evalute", words), "evaluate");
  EXPECT_EQ(nearest_word("server", words), "serve");
  EXPECT_EQ(nearest_word("frobnicate", words), "");
  EXPECT_EQ(nearest_word("x", words), "");
  EXPECT_EQ(nearest_word("", words), "");
}

int run(const std::function<void()>& work, std::vector<const char*> words) {
  CommandLine program("prog", "a program");
  program.require_subcommand();
  program.subcommand("build", "").callback(work);
  words.insert(words.begin(), "prog");
  return program.run(static_cast<int>(words.size()), words.data());
}

TEST(CommandLine, TheExitStatusSaysWhatHappened) {
  const auto nothing = [] {};
  EXPECT_EQ(run(nothing, {"build"}), 0);
  EXPECT_EQ(run(nothing, {"--help"}), 0);
  EXPECT_EQ(run(nothing, {}), 2);
  EXPECT_EQ(run([] { throw std::runtime_error("x"); }, {"build"}), 1);
  testing::internal::CaptureStderr();
  EXPECT_EQ(run(nothing, {"biuld"}), 2);
  EXPECT_NE(testing::internal::GetCapturedStderr().find("did you mean \"build\"?"), std::string::npos);
}

TEST(CommandLine, AFileBeyondTheLimitIsAnErrorThatIsTold) {
  const auto write_more = [] {
    const rlimit limit{1000, 1000};
    setrlimit(RLIMIT_FSIZE, &limit);
    std::exit(run([] { write_file(testing::TempDir() + "/beyond_the_limit", std::string(5000, 'x')); }, {"build"}));
  };
  EXPECT_EXIT(write_more(), testing::ExitedWithCode(1), "beyond_the_limit: cannot be written: File too large");
}

TEST(CommandLine, AnOptionMayStandWithoutItsValue) {
  const auto refine = [](std::vector<const char*> words) {
    std::string value, other;
    CommandLine program("prog", "a program");
    program.option("--refine[=mesh]", value, "");
    program.option("--out", other, "");
    program.callback([] {});
    words.insert(words.begin(), "prog");
    EXPECT_EQ(program.run(static_cast<int>(words.size()), words.data()), 0);
    return value;
  };
  EXPECT_EQ(refine({}), "");
  EXPECT_EQ(refine({"--refine"}), "mesh");
  EXPECT_EQ(refine({"--refine", "--out", "x"}), "mesh");
  EXPECT_EQ(refine({"--refine", "poses"}), "poses");
}

TEST(CommandLine, ASubcommandWorksInPlaceOfItsCommand) {
  const auto done = [](std::vector<const char*> words) {
    std::string work;
    CommandLine program("prog", "a program");
    Command stage = program.subcommand("stage", "");
    stage.callback([&] { work += "stage"; });
    stage.subcommand("survey", "").callback([&] { work += "survey"; });
    words.insert(words.begin(), "prog");
    EXPECT_EQ(program.run(static_cast<int>(words.size()), words.data()), 0);
    return work;
  };
  EXPECT_EQ(done({"stage"}), "stage");
  EXPECT_EQ(done({"stage", "survey"}), "survey");
  EXPECT_EQ(done({}), "");
}

}  // namespace
}  // namespace sheen
