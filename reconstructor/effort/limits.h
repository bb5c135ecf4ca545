// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>
#include <string>

namespace sheen {

/// What a user asks of a model; what is absent does not matter.
struct Limits {
  std::optional<double> image_ms;  ///< at most: wall time of folding one image in
  std::optional<double> bytes;     ///< at most: of the memory that is counted (`MemoryAccount`)
  std::optional<double> psnr_db;   ///< at least: of held-out views
  std::string favour;              ///< the word that they follow from, for those who watch; empty: none
  bool shown = true;               ///< pictures are shown while the model grows, from snapshots that take memory too

  bool empty() const { return !image_ms && !bytes && !psnr_db; }
};

/// The three words of the command line: "33ms" or "0.2s", "35dB", "1GB" (B, kB, MB, GB, or KiB, MiB, GiB); an empty
/// word asks for nothing. Throws ConfigError naming the option and what it takes.
Limits parse_limits(const std::string& budget, const std::string& target, const std::string& memory);

/// "33 ms", "35 dB" and "1 GB" of limits, joined by commas: for messages.
std::string describe(const Limits& limits);

}  // namespace sheen
