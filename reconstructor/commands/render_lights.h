// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "common/base/report_file.h"
#include "reconstructor/commands/film.h"

namespace sheen {

/// Lights to render in; one of the four is given.
struct LightRequest {
  std::string list;         ///< .lp: a picture in each
  std::string luminaires;   ///< JSON: see `load_luminaires`
  std::string environment;  ///< OpenEXR, latitude and longitude: one picture
  std::string path;         ///< .lp: `frames` pictures of a light that moves through them
  int frames = 60;
  bool asked() const { return !(list.empty() && luminaires.empty() && environment.empty() && path.empty()); }
};

/// What is written beside the pictures' colours.
struct PictureExtras {
  bool marked = false;              ///< guesses are marked in the PNGs (`mark_guesses`)
  std::vector<std::string> layers;  ///< `PictureLayers`
  FilmRequest film;                 ///< where the pictures go into a video
};

/// Renders a saved model that knows moving light, seen by its own camera: linear EXR and PNG, named as in the list or
/// file, or a video; `json` gets their list. Throws ConfigError for a model of fixed light or of another kind of light,
/// or without one of the layers.
void render_lights(const std::filesystem::path& model, const LightRequest& request, const PictureExtras& extras,
                   const std::filesystem::path& out, ReportFile& json);

}  // namespace sheen
