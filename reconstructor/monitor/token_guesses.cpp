// SPDX-License-Identifier: Apache-2.0
#include "reconstructor/monitor/token_guesses.h"

#include <sodium.h>

#include <algorithm>

#include "common/base/content_hash.h"

namespace sheen {
namespace {

constexpr double kAtOnce = 10;
constexpr std::chrono::duration<double> kOneMoreAfter{10};
constexpr std::size_t kRemembered = 8;
constexpr std::size_t kMostGuessers = 1024;  ///< beyond it all others are taken for one
constexpr const char* kAllOthers = "others";

}  // namespace

bool same_secret(const std::string& a, const std::string& b) {
  return a.size() == b.size() && sodium_memcmp(a.data(), b.data(), a.size()) == 0;
}

TokenGuesses::Guesser& TokenGuesses::guesser(const std::string& address, Clock::time_point now) {
  std::erase_if(guessers_, [now](const auto& g) { return now - g.second.at >= kAtOnce * kOneMoreAfter; });
  const bool known = guessers_.contains(address) || guessers_.size() < kMostGuessers;
  Guesser& guesser = guessers_.try_emplace(known ? address : kAllOthers, Guesser{kAtOnce, now, {}}).first->second;
  guesser.left = std::min(kAtOnce, guesser.left + (now - guesser.at) / kOneMoreAfter);
  guesser.at = now;
  return guesser;
}

TokenGuesses::Verdict TokenGuesses::judge(const std::string& address, const std::string& token, Clock::time_point now) {
  if (token.empty()) return Verdict::kWrong;
  Guesser& who = guesser(address, now);
  const std::string hash = content_hash(token);
  if (std::ranges::find(who.wrong, hash) != who.wrong.end()) return Verdict::kWrong;
  if (who.left < 1) {
    log_(address, "too many wrong tokens from " + address + ": no more are looked at for a while");
    return Verdict::kNotLookedAt;
  }
  if (std::ranges::any_of(tokens_, [&](const std::string& right) { return same_secret(token, right); }))
    return Verdict::kRight;
  who.left -= 1;
  who.wrong.push_back(hash);
  if (who.wrong.size() > kRemembered) who.wrong.pop_front();
  log_(address, "a wrong token from " + address);
  return Verdict::kWrong;
}

}  // namespace sheen
