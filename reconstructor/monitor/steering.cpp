// SPDX-License-Identifier: Apache-2.0
#include "reconstructor/monitor/steering.h"

#include <algorithm>
#include <array>

namespace sheen {
namespace {

using Action = SteerRequest::Action;
struct Word {
  Action action;
  const char* word;
};
constexpr std::array kWords{Word{Action::kUndo, "undo"},   Word{Action::kHoldOut, "hold-out"},
                            Word{Action::kPause, "pause"}, Word{Action::kGoOn, "go-on"},
                            Word{Action::kNote, "note"},   Word{Action::kFinish, "finish"}};

}  // namespace

std::optional<Action> steer_action(std::string_view word) {
  const auto found = std::ranges::find(kWords, word, &Word::word);
  return found == kWords.end() ? std::nullopt : std::optional(found->action);
}

const char* to_string(Action action) {
  return std::ranges::find(kWords, action, &Word::action)->word;
}

}  // namespace sheen
