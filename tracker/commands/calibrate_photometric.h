// SPDX-License-Identifier: Apache-2.0
#pragma once

namespace sheen {

class Command;

/// `photometric`, a subcommand of `calibrate`.
void add_calibrate_photometric_command(Command& calibrate);

}  // namespace sheen
