// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <chrono>
#include <deque>
#include <functional>
#include <map>
#include <string>
#include <vector>

namespace sheen {

/// Without a look at how long it takes where they differ.
bool same_secret(const std::string& a, const std::string& b);

/// Whoever asks with a wrong token may try another one ten times, and then once every ten seconds; each address for
/// itself. The same wrong token once more, as of a page that was left open, costs nothing. Guesses are logged by
/// address. Not thread-safe.
class TokenGuesses {
 public:
  using Clock = std::chrono::steady_clock;
  enum class Verdict { kRight, kWrong, kNotLookedAt };

  /// Each of `tokens` is right; empty ones are none.
  TokenGuesses(std::vector<std::string> tokens,
               std::function<void(const std::string& address, const std::string& message)> log)
      : tokens_(std::move(tokens)), log_(std::move(log)) {}
  /// Empty is wrong, and no guess.
  Verdict judge(const std::string& address, const std::string& token, Clock::time_point now);

 private:
  struct Guesser {
    double left;  ///< guesses
    Clock::time_point at;
    std::deque<std::string> wrong;  ///< hashes of the latest
  };
  Guesser& guesser(const std::string& address, Clock::time_point now);

  const std::vector<std::string> tokens_;
  const std::function<void(const std::string&, const std::string&)> log_;
  std::map<std::string, Guesser> guessers_;
};

}  // namespace sheen
