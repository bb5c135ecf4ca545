// SPDX-License-Identifier: Apache-2.0
#include "reconstructor/monitor/token_guesses.h"

#include <gtest/gtest.h>

#include <map>

namespace sheen {
namespace {

using std::chrono::seconds;
using Verdict = TokenGuesses::Verdict;

constexpr const char *kToken = "0123456789abcdef", *kStranger = "192.0.2.7", *kFriend = "192.0.2.8";

class Guessing : public ::testing::Test {
 protected:
  /// Ever new wrong tokens, until one is not looked at; how many were.
  int guess_until_refused(const std::string& address) {
    int looked_at = 0;
    while (guesses_.judge(address, "wrong " + std::to_string(next_++), now_) == Verdict::kWrong) ++looked_at;
    return looked_at;
  }

  int next_ = 0;
  TokenGuesses::Clock::time_point now_{};
  std::map<std::string, int> told_;
  TokenGuesses guesses_{{kToken}, [this](const std::string& address, const std::string& message) {
                          EXPECT_NE(message.find(address), std::string::npos);
                          EXPECT_EQ(message.find("wrong "), message.find("wrong token"))
                              << "guesses are not written down";
                          ++told_[address];
                        }};
};

TEST_F(Guessing, IsSlowedForItsAddressAndNobodyElse) {
  EXPECT_EQ(guess_until_refused(kStranger), 10);
  EXPECT_EQ(guesses_.judge(kStranger, kToken, now_), Verdict::kNotLookedAt) << "else it could go on guessing";
  EXPECT_EQ(guesses_.judge(kFriend, kToken, now_), Verdict::kRight);
  now_ += seconds(10);
  EXPECT_EQ(guess_until_refused(kStranger), 1);
  now_ += seconds(1000);
  EXPECT_EQ(guesses_.judge(kStranger, kToken, now_), Verdict::kRight);
  EXPECT_EQ(guess_until_refused(kStranger), 10);
  EXPECT_GT(told_[kStranger], 0);
  EXPECT_EQ(told_[kFriend], 0);
}

TEST_F(Guessing, APageThatWasLeftOpenWithAnOldTokenIsNoGuess) {
  for (int i = 0; i < 1000; ++i) EXPECT_EQ(guesses_.judge(kStranger, "the old token", now_), Verdict::kWrong);
  for (int i = 0; i < 1000; ++i) EXPECT_EQ(guesses_.judge(kStranger, "", now_), Verdict::kWrong);
  EXPECT_EQ(guesses_.judge(kStranger, kToken, now_), Verdict::kRight);
}

TEST_F(Guessing, ManyAddressesTogetherAreSlowedToo) {
  int looked_at = 0;
  for (int i = 0; i < 5000; ++i)
    looked_at +=
        guesses_.judge("address " + std::to_string(i), "wrong " + std::to_string(next_++), now_) == Verdict::kWrong;
  EXPECT_LE(looked_at, 1100);
}

}  // namespace
}  // namespace sheen
