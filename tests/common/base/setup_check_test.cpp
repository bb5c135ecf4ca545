// SPDX-License-Identifier: Apache-2.0
#include "common/base/setup_check.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <nlohmann/json.hpp>

#include "common/base/errors.h"
#include "tests/support/expect_error.h"

namespace sheen {
namespace {

const SetupCheck kGood{"mesh", Finding::kOk, "12 triangles"}, kBad{"keys", Finding::kFail, "no such file"};

std::string printed(const std::vector<SetupCheck>& checks, bool json) {
  testing::internal::CaptureStdout();
  try {
    report_checks(checks, json);
  } catch (const Error&) {  // what is printed is asked for
  }
  return testing::internal::GetCapturedStdout();
}

TEST(SetupCheck, WhatLoadsIsOkAndWhatThrowsFailsWithTheRemedy) {
  const SetupCheck good = check_loading(
      "file", [] { return "as it should be"; }, "make one");
  EXPECT_EQ(good.finding, Finding::kOk);
  EXPECT_EQ(good.text, "as it should be");
  const SetupCheck bad = check_loading(
      "file", []() -> std::string { throw Error("it is missing"); }, "make one");
  EXPECT_EQ(bad.finding, Finding::kFail);
  EXPECT_EQ(bad.text, "it is missing; make one");
}

TEST(SetupCheck, OneLinePerCheckOrJson) {
  EXPECT_EQ(printed({kGood, kBad}, false), "OK\tmesh: 12 triangles\nFAIL\tkeys: no such file\n");
  const auto json = nlohmann::json::parse(printed({kGood, kBad}, true));
  ASSERT_EQ(json.size(), 2U);
  EXPECT_EQ(json[1], (nlohmann::json{{"check", "keys"}, {"finding", "FAIL"}, {"text", "no such file"}}));
}

TEST(SetupCheck, AFailureIsAnErrorAndAWarningIsNone) {
  testing::internal::CaptureStdout();
  EXPECT_NO_THROW(report_checks({kGood, {"disk", Finding::kWarn, "2 GB free"}}, false));
  expect_error<Error>([&] { report_checks({kGood, kBad, kBad}, false); }, {"2 of 3 checks failed"});
  testing::internal::GetCapturedStdout();
}

}  // namespace
}  // namespace sheen
