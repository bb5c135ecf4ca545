// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <string>

namespace sheen {

// Words of the command line: a positive number and its unit, with or without a space between them. Each throws
// ConfigError that names the option and says what it takes.

/// "33ms", "0.2s": in milliseconds.
double parse_time_ms(const std::string& option, const std::string& word, const std::string& takes);
/// "35dB".
double parse_decibels(const std::string& option, const std::string& word, const std::string& takes);
/// "25mm" (mm, cm, m): in metres, 10 at most.
double parse_length_m(const std::string& option, const std::string& word, const std::string& takes);
/// "500MB" (B, kB, MB, GB, or KiB, MiB, GiB; without a unit bytes): in bytes.
double parse_bytes(const std::string& option, const std::string& word, const std::string& takes);

/// "1280x800": width and height in pixels, each of least..16384. Throws ConfigError as above.
std::array<int, 2> parse_image_size(const std::string& option, const std::string& word, int least);

/// "12.3 GB", for messages.
std::string gigabytes(double bytes);

}  // namespace sheen
