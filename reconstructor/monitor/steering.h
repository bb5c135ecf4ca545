// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <functional>
#include <optional>
#include <string>
#include <string_view>

namespace sheen {

/// What somebody at another desk asks of a capture.
struct SteerRequest {
  enum class Action : std::uint8_t {
    kUndo,     ///< take the last image back
    kHoldOut,  ///< judge by the next image, and do not build with it
    kPause,    ///< store what comes and take it back at once, until
    kGoOn,     ///< this
    kNote,     ///< write `text` down
    kFinish,   ///< end the capture and save the model
  };
  Action action = Action::kUndo;
  std::string text;  ///< UTF-8, without control characters
  std::string from;  ///< address
};

/// "undo", "hold-out", "pause", "go-on", "note", "finish"; empty for any other word.
std::optional<SteerRequest::Action> steer_action(std::string_view word);
const char* to_string(SteerRequest::Action action);

/// Takes a request, to be carried out soon. Never waits. @return why it is not taken; empty: it is.
using Steer = std::function<std::string(const SteerRequest&)>;

}  // namespace sheen
