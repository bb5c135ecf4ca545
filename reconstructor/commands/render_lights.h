// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <string>

#include "common/base/report_file.h"

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

/// Renders a saved model that knows moving light, seen by its own camera: linear EXR and PNG, named as in the list or
/// file; `json` gets their list. `marked`: guesses are marked in the PNGs (`mark_guesses`). Throws ConfigError for a
/// model of fixed light or of another kind of light.
void render_lights(const std::filesystem::path& model, const LightRequest& request, bool marked,
                   const std::filesystem::path& out, ReportFile& json);

}  // namespace sheen
