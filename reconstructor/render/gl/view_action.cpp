// SPDX-License-Identifier: Apache-2.0
#include "reconstructor/render/gl/view_action.h"

#include <algorithm>

namespace sheen {

const std::vector<ActionWords>& view_actions() {
  static const std::vector<ActionWords> actions = {
      {ViewAction::kAppearance, '1', "Object", "how it looks"},
      {ViewAction::kHeuristic, '2', "Known", "what is known of it: green; where images are needed: red"},
      {ViewAction::kSplit, '3', "Both", "side by side, from the same eye"},
      {ViewAction::kCamera, '4', "Camera", "the camera's image with tags, pose and the mesh's outline"},
      {ViewAction::kDemand, '5', "Effort", "what the scene required: terms; again: samples, bytes"},
      {ViewAction::kShape, '6', "Shape", "from what its shape is known: images, outlines, or nothing"},
      {ViewAction::kReasons, 'W', "Why", "why images are needed, by reason"},
      {ViewAction::kStates, 'M', "Measured", "what is measured, imputed, guessed"},
      {ViewAction::kFollow, 'F', "Follow", "look through the tracked camera"},
      {ViewAction::kReset, 'R', "Reset", "back to the first view"},
      {ViewAction::kGround, 'B', "Background", "dark, grey, light, white, black"},
      {ViewAction::kUndo, 'U', "Undo", "take back the last image"},
      {ViewAction::kHoldOut, 'O', "Hold out", "judge by the next image, and do not build with it"},
      {ViewAction::kScreenshot, 'S', "Picture", "save the picture without panels (PNG)"},
      {ViewAction::kDetails, 'D', "Details", "all figures"},
      {ViewAction::kHelp, 'H', "Keys", "show or hide this list"},
      {ViewAction::kPanels, 'P', "Hide", "hide the panels; P shows them again"},
      {ViewAction::kQuit, 'Q', "Quit", "end, also Esc; a capture is finished and saved first"},
  };
  return actions;
}

const ActionWords& words_of(ViewAction action) {
  return *std::ranges::find(view_actions(), action, &ActionWords::action);
}

std::optional<ViewAction> action_of_key(int key) {
  const auto found = std::ranges::find_if(view_actions(), [key](const ActionWords& words) { return words.key == key; });
  if (found == view_actions().end()) return std::nullopt;
  return found->action;
}

bool apply(ViewAction action, ViewControls& controls) {
  const auto turn = [](bool& is) { is = !is; };
  switch (action) {
    case ViewAction::kAppearance:
      controls.mode = ViewMode::kAppearance;
      return true;
    case ViewAction::kHeuristic:
      controls.mode = ViewMode::kHeuristic;
      return true;
    case ViewAction::kSplit:
      controls.mode = ViewMode::kSplit;
      return true;
    case ViewAction::kCamera:
      controls.mode = ViewMode::kCamera;
      return true;
    case ViewAction::kDemand:  // one after the other
      controls.mode = controls.mode == ViewMode::kRank         ? ViewMode::kResolution
                      : controls.mode == ViewMode::kResolution ? ViewMode::kBytes
                                                               : ViewMode::kRank;
      return true;
    case ViewAction::kShape:
      controls.mode = ViewMode::kShape;
      return true;
    case ViewAction::kReasons:
      turn(controls.reasons);
      return true;
    case ViewAction::kStates:
      turn(controls.states);
      return true;
    case ViewAction::kFollow:
      turn(controls.follow);
      return true;
    case ViewAction::kReset:
      controls.reset();
      return true;
    case ViewAction::kGround:
      controls.ground = next(controls.ground);
      return true;
    case ViewAction::kDetails:
      turn(controls.details);
      return true;
    case ViewAction::kPanels:
      turn(controls.panels);
      return true;
    case ViewAction::kHelp:
      turn(controls.help);
      return true;
    case ViewAction::kUndo:
    case ViewAction::kHoldOut:
    case ViewAction::kScreenshot:
    case ViewAction::kQuit:
      break;
  }
  return false;
}

bool matters(ViewAction action, const ViewControls& controls) {
  switch (action) {
    case ViewAction::kReasons:
      return controls.mode == ViewMode::kHeuristic || controls.mode == ViewMode::kSplit;
    case ViewAction::kStates:
      return controls.mode == ViewMode::kAppearance || controls.mode == ViewMode::kSplit;
    case ViewAction::kFollow:
      return controls.mode != ViewMode::kCamera;
    default:
      return true;
  }
}

bool is_on(ViewAction action, const ViewControls& controls) {
  switch (action) {
    case ViewAction::kAppearance:
      return controls.mode == ViewMode::kAppearance;
    case ViewAction::kHeuristic:
      return controls.mode == ViewMode::kHeuristic;
    case ViewAction::kSplit:
      return controls.mode == ViewMode::kSplit;
    case ViewAction::kCamera:
      return controls.mode == ViewMode::kCamera;
    case ViewAction::kDemand:
      return demand_of(controls.mode).has_value();
    case ViewAction::kShape:
      return controls.mode == ViewMode::kShape;
    case ViewAction::kReasons:
      return controls.reasons;
    case ViewAction::kStates:
      return controls.states;
    case ViewAction::kFollow:
      return controls.follow;
    case ViewAction::kDetails:
      return controls.details;
    case ViewAction::kHelp:
      return controls.help;
    default:
      return false;
  }
}

}  // namespace sheen
