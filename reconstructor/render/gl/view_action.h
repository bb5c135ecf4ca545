// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>
#include <vector>

#include "reconstructor/render/gl/view_controls.h"

namespace sheen {

/// What a person asks of the window with a key or a button.
enum class ViewAction {
  kAppearance,
  kHeuristic,
  kSplit,
  kCamera,
  kDemand,
  kShape,
  kReasons,
  kStates,
  kFollow,
  kReset,
  kGround,
  kDetails,
  kUndo,
  kHoldOut,
  kScreenshot,
  kPanels,
  kHelp,
  kQuit,
};

/// How an action is asked for, and what a person is told of it.
struct ActionWords {
  ViewAction action;
  char key;            ///< a digit or a capital, as on the keyboard
  const char* button;  ///< on it
  const char* says;    ///< in the list of the keys, and beside the button
};
/// All of them, in the order of their buttons.
const std::vector<ActionWords>& view_actions();
const ActionWords& words_of(ViewAction action);
std::optional<ViewAction> action_of_key(int key);

/// Does what changes nothing but the controls. False: the window must do it.
bool apply(ViewAction action, ViewControls& controls);
/// Whether it shows in the picture that is asked for.
bool matters(ViewAction action, const ViewControls& controls);
/// Whether its button is lit.
bool is_on(ViewAction action, const ViewControls& controls);

}  // namespace sheen
