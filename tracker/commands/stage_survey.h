// SPDX-License-Identifier: Apache-2.0
#pragma once

namespace CLI {
class App;
}

namespace sheen {

/// `survey`, a subcommand of `stage`.
void add_stage_survey_command(CLI::App& stage);

}  // namespace sheen
