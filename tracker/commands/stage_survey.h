// SPDX-License-Identifier: Apache-2.0
#pragma once

namespace sheen {

class Command;

/// `survey`, a subcommand of `stage`.
void add_stage_survey_command(Command& stage);

}  // namespace sheen
