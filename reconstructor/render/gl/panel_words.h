// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <optional>
#include <string>
#include <vector>

#include "reconstructor/render/demand_map.h"
#include "reconstructor/render/gl/sketch.h"
#include "reconstructor/render/gl/view_controls.h"
#include "reconstructor/render/gl/viewer_state.h"
#include "reconstructor/render/guidance.h"

namespace sheen {

/// How urgent something is: the colour of its light.
enum class Tone { kIdle, kGood, kBusy, kWarn, kBad };

struct ToldLine {
  std::string label, value;
  Tone tone = Tone::kIdle;
};

/// Swatch of a legend.
struct Swatch {
  Rgba color;
  std::string text;
};

/// Where the light is, for a model of which it moves: as whoever looks at the picture sees it (`light_ball.h`).
struct ShownLight {
  Eigen::Matrix3d axes;  ///< object frame -> that of the picture
  Eigen::Vector3d now;
  std::vector<Eigen::Vector3d> images;  ///< in which the images were taken
};

/// All that the panels tell a person, in words; the monitor page tells the same.
struct Told {
  Tone tone = Tone::kIdle;
  std::string sentence;                ///< what comes first
  std::string next;                    ///< where to go; may be empty
  std::optional<Eigen::Vector2f> way;  ///< to there, right and up: unit, or zero where that is here
  std::string counts;                  ///< the rest in a line; may be empty
  std::vector<ToldLine> details;       ///< all figures
  std::string legend_title;            ///< what the picture shows
  std::vector<Swatch> legend;          ///< and what its colours mean
  std::vector<std::string> notes;      ///< warnings and news, a line each
  std::optional<ShownLight> light;
};

/// What words are made of beside the state and the controls.
struct WordSources {
  const char* model;                         ///< what it is called: "surface light field"
  const SnapshotFigures* figures = nullptr;  ///< null without a model
  const DemandMap* demand = nullptr;         ///< null where it is not what is shown
  const Guidance* guidance = nullptr;        ///< null without a next view
};
/// `notes`: those of whoever draws; the state's own are added.
Told told(const ViewerState& state, const ViewControls& controls, const WordSources& sources,
          std::vector<std::string> notes);

}  // namespace sheen
