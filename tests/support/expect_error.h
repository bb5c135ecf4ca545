// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <string>
#include <vector>

#include "common/base/errors.h"

namespace sheen {

/// `action` must throw an `Exception` whose message holds all of `words`: an error has to say where and what.
template <typename Exception = FileError, typename Action>
void expect_error(Action action, const std::vector<std::string>& words) {
  try {
    action();
    ADD_FAILURE() << "nothing was thrown";
  } catch (const Exception& error) {
    for (const std::string& word : words) EXPECT_THAT(std::string(error.what()), testing::HasSubstr(word));
  }
}

}  // namespace sheen
