// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <string>
#include <vector>

namespace CLI {
class App;
class Validator;
}  // namespace CLI

namespace sheen {

/// Parses and runs a program whose work happens in the callbacks of its subcommands. The exit status: 0 done, 1 failed,
/// 2 wrong usage (ConfigError too); what failed is printed on standard error, with the nearest name where a subcommand
/// was misspelt. Standard output that could not be written is a failure.
int run_program(CLI::App& app, int argc, char** argv);

// For `CLI::Option::check`: what is no number of this range is wrong usage. NaN and infinity are in none.
CLI::Validator number_in(double least, double most);
CLI::Validator whole_number_in(std::int64_t least, std::int64_t most);

/// The one of `words` that `word` is most like, within two slips; empty when none is.
std::string nearest_word(const std::string& word, const std::vector<std::string>& words);

}  // namespace sheen
