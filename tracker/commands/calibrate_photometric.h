// SPDX-License-Identifier: Apache-2.0
#pragma once

namespace CLI {
class App;
}

namespace sheen {

/// `photometric`, a subcommand of `calibrate`.
void add_calibrate_photometric_command(CLI::App& calibrate);

}  // namespace sheen
